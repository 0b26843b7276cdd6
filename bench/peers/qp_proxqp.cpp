// ProxQP, dense, warm-started from the solution before, set up anew where sizes changed. Tolerance 1e-6, which it reaches on
// most programs; 1000 iterations at most, as it would not end on some.
#include "qp_programs.hpp"

#include <memory>

#include <proxsuite/proxqp/dense/dense.hpp>

using namespace proxsuite::proxqp;

int main(int, char** argv) {
  std::unique_ptr<dense::QP<double>> qp;
  Eigen::Index equalities = -1;
  run(argv[1], argv[2], [&](const Program& p, Table& out) {
    const TwoSided rows(p);
    const auto& [A, C, b, below, above] = rows;
    const Vector l = below.cwiseMax(-1e20), u = above.cwiseMin(1e20);
    const Vector box_l = p.lower.cwiseMax(-1e20), box_u = p.upper.cwiseMin(1e20);
    const Clock clock;
    if (!qp || equalities != A.rows()) {
      qp = std::make_unique<dense::QP<double>>(p.n, A.rows(), C.rows(), true);
      qp->settings.eps_abs = 1e-6;
      qp->settings.max_iter = 1000;
      qp->settings.max_iter_in = 100;
      qp->settings.initial_guess = InitialGuessStatus::WARM_START_WITH_PREVIOUS_RESULT;
      qp->init(p.H, p.g, A, b, C, l, u, box_l, box_u);
      equalities = A.rows();
    } else {
      qp->update(p.H, p.g, A, b, C, l, u, box_l, box_u);
    }
    qp->solve();
    const double time = clock.microseconds();
    const bool solved = qp->results.info.status == QPSolverOutput::PROXQP_SOLVED;
    answer(out, time, solved, double(qp->results.info.iter), qp->results.x);
  });
}
