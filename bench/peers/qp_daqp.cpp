// DAQP: one workspace, updated and solved warm from the working set before; solved anew where that fails. The second argument
// says whether it eliminates the equalities ("on", "off"): whichever is faster on a series.
#include "qp_programs.hpp"

extern "C" {
#include "api.h"
#include "utils.h"
}

int main(int, char** argv) {
  DAQPSettings settings;
  daqp_default_settings(&settings);
  settings.eq_reduction = std::string(argv[2]) == "on" ? DAQP_EQ_REDUCTION_ON : DAQP_EQ_REDUCTION_OFF;
  // The default, 10000, takes minutes over programs on which it does not end.
  settings.iter_limit = 1000;
  DAQPWorkspace work{};
  work.settings = &settings;
  bool ready = false;
  run(argv[1], argv[3], [&](const Program& p, Table& out) {
    const int total = p.n + p.m;
    RowMatrix H = p.H, A = p.A;
    Vector f = p.g, upper(total), lower(total);
    upper << p.upper, p.row_upper;
    lower << p.lower, p.row_lower;
    upper = upper.cwiseMin(DAQP_INF);
    lower = lower.cwiseMax(-DAQP_INF);
    DAQPProblem qp{};
    qp.n = p.n;
    qp.m = total;
    qp.ms = p.n;
    qp.H = H.data();
    qp.f = f.data();
    qp.A = A.data();
    qp.bupper = upper.data();
    qp.blower = lower.data();
    Vector x = Vector::Zero(p.n), multipliers = Vector::Zero(total);
    DAQPResult result{};
    result.x = x.data();
    result.lam = multipliers.data();

    const Clock clock;
    int flag;
    if (!ready) {
      flag = setup_daqp(&qp, &work, nullptr);
      ready = flag >= 0;
    } else {
      // The workspace keeps the working set, and finds the equalities by their bounds.
      flag = daqp_update_ldp(DAQP_UPDATE_Rinv | DAQP_UPDATE_M | DAQP_UPDATE_v | DAQP_UPDATE_d, &work, &qp);
    }
    result.exitflag = flag;
    if (flag >= 0) daqp_solve(&result, &work);
    if (result.exitflag < 0) {
      daqp_quadprog(&result, &qp, &settings);
    }
    const double time = clock.microseconds();
    answer(out, time, result.exitflag > 0, result.iter, x);
  });
}
