// eiquadprog-fast; it has no warm start. Its matrices are those that its users build: equalities, inequalities.
#include "qp_programs.hpp"

#include <eiquadprog/eiquadprog-fast.hpp>

int main(int, char** argv) {
  eiquadprog::solvers::EiquadprogFast solver;
  run(argv[1], argv[2], [&](const Program& p, Table& out) {
    const Split split(p);
    const Eigen::MatrixXd E = split.E, G = split.G;
    const Vector e = -split.e, b = -split.b;
    Vector x = Vector::Zero(p.n);
    const Clock clock;
    solver.reset(std::size_t(p.n), std::size_t(E.rows()), std::size_t(G.rows()));
    const auto status = solver.solve_quadprog(p.H, p.g, E, e, G, b, x);
    const double time = clock.microseconds();
    answer(out, time, status == eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL, solver.getIteratios(), x);
  });
}
