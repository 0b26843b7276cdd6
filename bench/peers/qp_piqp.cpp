// PIQP, dense, at its default tolerances; an interior-point method without warm start, set up anew where sizes changed.
#include "qp_programs.hpp"

#include <memory>

#include <piqp/piqp.hpp>

int main(int, char** argv) {
  std::unique_ptr<piqp::DenseSolver<double>> solver;
  Eigen::Index equalities = -1;
  run(argv[1], argv[2], [&](const Program& p, Table& out) {
    // One-sided rows of the contact switches become equalities, hence other sizes.
    std::vector<int> equal, other;
    for (int i = 0; i < p.m; ++i) {
      if (p.A.row(i).isZero(0.0)) continue;
      (p.row_lower[i] >= p.row_upper[i] ? equal : other).push_back(i);
    }
    Eigen::MatrixXd A(Eigen::Index(equal.size()), p.n), G(Eigen::Index(other.size()), p.n);
    Vector b(A.rows()), l(G.rows()), u(G.rows());
    for (std::size_t i = 0; i < equal.size(); ++i) {
      A.row(Eigen::Index(i)) = p.A.row(equal[i]);
      b[Eigen::Index(i)] = p.row_upper[equal[i]];
    }
    for (std::size_t i = 0; i < other.size(); ++i) {
      G.row(Eigen::Index(i)) = p.A.row(other[i]);
      l[Eigen::Index(i)] = p.row_lower[other[i]];
      u[Eigen::Index(i)] = p.row_upper[other[i]];
    }
    const Eigen::MatrixXd H = p.H;
    const Clock clock;
    if (!solver || equalities != A.rows()) {
      solver = std::make_unique<piqp::DenseSolver<double>>();
      solver->setup(H, p.g, A, b, G, l, u, p.lower, p.upper);
      equalities = A.rows();
    } else {
      solver->update(H, p.g, A, b, G, l, u, p.lower, p.upper);
    }
    const auto status = solver->solve();
    const double time = clock.microseconds();
    answer(out, time, status == piqp::Status::PIQP_SOLVED, double(solver->result().info.iter), solver->result().x);
  });
}
