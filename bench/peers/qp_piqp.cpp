// PIQP, dense, at its default tolerances; an interior-point method without warm start, set up anew where sizes changed.
#include "qp_programs.hpp"

#include <memory>

#include <piqp/piqp.hpp>

int main(int, char** argv) {
  std::unique_ptr<piqp::DenseSolver<double>> solver;
  Eigen::Index equalities = -1;
  run(argv[1], argv[2], [&](const Program& p, Table& out) {
    // One-sided rows of the contact switches become equalities, hence other sizes.
    const TwoSided rows(p);
    const auto& [A, C, b, l, u] = rows;
    const Clock clock;
    if (!solver || equalities != A.rows()) {
      solver = std::make_unique<piqp::DenseSolver<double>>();
      solver->setup(p.H, p.g, A, b, C, l, u, p.lower, p.upper);
      equalities = A.rows();
    } else {
      solver->update(p.H, p.g, A, b, C, l, u, p.lower, p.upper);
    }
    const auto status = solver->solve();
    const double time = clock.microseconds();
    answer(out, time, status == piqp::Status::PIQP_SOLVED, double(solver->result().info.iter), solver->result().x);
  });
}
