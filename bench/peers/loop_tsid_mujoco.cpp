// TSID and MuJoCo in a closed loop of 1 kHz: exo18 sways, squats and is pushed as in the scenario exo-sway. The clock runs over
// the state's way from MuJoCo to Pinocchio, TSID's tick, and one mj_step.
#include <mujoco/mujoco.h>

#include "tsid_exo.hpp"

// The robot has fallen where its torso is lower than this share of its height at the start.
constexpr double FALLEN = 0.8;

// 200 N for 0.1 s, forward and to the left. A force on the centre of mass moves the joints as its shares by mass on the bodies do.
void push(const mjModel* model, mjData* data, int tick) {
  const auto acts = [tick](int start) { return tick >= start && tick < start + 100 ? 200.0 : 0.0; };
  const double force[] = {acts(2500), acts(5000)};
  for (int body = 1; body < model->nbody; ++body)
    for (int axis = 0; axis < 2; ++axis)
      data->xfrc_applied[6 * body + axis] = force[axis] * model->body_mass[body] / model->body_subtreemass[0];
}

// MuJoCo: position, quaternion (w, x, y, z); linear velocity in world axes, angular in body axes. Pinocchio: both in body axes.
void read_state(const mjData* data, TsidExo& exo) {
  exo.set_position(data->qpos, data->qpos + 3, data->qpos + 7);
  const Eigen::Quaterniond rotation(data->qpos[3], data->qpos[4], data->qpos[5], data->qpos[6]);
  exo.v.head<3>() = rotation.conjugate() * Eigen::Map<const Vector3>(data->qvel);
  exo.v.segment<3>(3) = Eigen::Map<const Vector3>(data->qvel + 3);
  for (std::size_t j = 0; j < exo.index.size(); ++j) exo.v[6 + exo.index[j]] = data->qvel[6 + j];
}

int main(int, char** argv) {
  const std::string stem = argv[1];
  const Table table = Table::read(argv[2]);
  const double* start = table.row(0);
  TsidExo exo(stem, start);
  char error[1000] = "";
  mjModel* model = mj_loadXML((stem + ".xml").c_str(), nullptr, error, sizeof error);
  if (!model) {
    std::fprintf(stderr, "%s\n", error);
    return 1;
  }
  mjData* data = mj_makeData(model);
  std::copy(start + 4, start + 7, data->qpos);
  std::copy(start, start + 4, data->qpos + 3);
  std::copy(start + 7, start + model->nq, data->qpos + 7);

  Table out;
  out.columns = 3;
  double lowest = start[6], largest = 0.0;
  bool stands = true;
  // Of a falling robot TSID's solver may not end.
  for (int tick = 0; tick < 8000 && stands; ++tick) {
    const double t = 1e-3 * tick;
    exo.follow_sway(t);
    push(model, data, tick);

    const Clock clock;
    read_state(data, exo);
    const auto& solution = exo.solve(t);
    const bool solved = solution.status == solvers::HQP_STATUS_OPTIMAL;
    // Unsolved, it keeps the torques of the tick before.
    if (solved) {
      const auto& torques = exo.formulation.getActuatorForces(solution);
      for (std::size_t j = 0; j < exo.index.size(); ++j) data->ctrl[j] = torques[exo.index[j]];
    }
    mj_step(model, data);
    const double time = clock.microseconds();

    lowest = std::min(lowest, double(data->qpos[2]));
    largest = std::max(largest, exo.com_error());
    stands = data->qpos[2] > FALLEN * start[6];
    out.begin_answer(time, solved, solution.iterations);
  }
  // Times on the way to the ground are no measure.
  for (std::size_t i = 0; !stands && i < out.rows(); ++i) out.values[3 * i + 1] = 0.0;
  std::printf("it %s, torso at %.3f m, at the lowest %.3f m of %.3f m; centre of mass %.1f mm from its reference at the end, %.1f mm at most\n",
              stands ? "stands" : "falls", data->qpos[2], lowest, start[6], 1e3 * exo.com_error(), 1e3 * largest);
  out.write(argv[3]);
  mj_deleteData(data);
  mj_deleteModel(model);
}
