// TSID's control tick on exo18, in double support or on one foot with the other in the air. It follows its own
// accelerations, without physics between the ticks.
#include <pinocchio/algorithm/joint-configuration.hpp>

#include "tsid_exo.hpp"

int main(int, char** argv) {
  const bool single = std::string(argv[2]) == "single";
  const Table start = Table::read(argv[3]);
  TsidExo exo(argv[1], start.row(0));
  auto swing = exo.task_of("swing", exo.links[1], 400.0);
  const pinocchio::SE3 left = exo.placement(exo.links[1]);
  const double aside = exo.placement(exo.links[0]).translation().y() - exo.com_start.y();
  const double dt = 1e-3;
  const int lift = single ? 1500 : -1, ticks = single ? 4500 : 8000;
  Table out;
  out.columns = 3;
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = tick * dt;
    if (single) {
      exo.follow(Vector3(0.0, aside * std::min(1.0, t), 0.0), Vector3::Zero(), Vector3::Zero());
    } else {
      exo.follow_sway(t);
    }
    if (tick == lift) {
      exo.formulation.removeRigidContact(exo.feet[1]->name(), 0.0);
      exo.formulation.addMotionTask(*swing, 10.0, 1);
      exo.resize();
    }
    if (single && tick >= lift) {
      pinocchio::SE3 at = left;
      const double phase = std::min(1.0, (t - lift * dt) / 3.0);
      at.translation() += Vector3(0.1 * std::sin(2.0 * EIGEN_PI * phase), 0.0, 0.06 * std::sin(EIGEN_PI * phase));
      swing->setReference(at);
    }

    const Clock clock;
    const auto& solution = exo.solve(t);
    const bool solved = solution.status == solvers::HQP_STATUS_OPTIMAL;
    if (solved) exo.formulation.getActuatorForces(solution);
    const double time = clock.microseconds();

    if (!single || tick >= lift) out.begin_answer(time, solved, solution.iterations);
    if (!solved) {
      std::fprintf(stderr, "not solved at tick %d\n", tick);
      if (tick < 10) return 1;
      continue;
    }
    exo.v += dt * exo.formulation.getAccelerations(solution);
    exo.q = pinocchio::integrate(exo.robot.model(), exo.q, VectorXd(dt * exo.v));
  }
  std::printf("centre of mass %.1f mm from its reference at the end\n", 1e3 * exo.com_error());
  out.write(argv[4]);
}
