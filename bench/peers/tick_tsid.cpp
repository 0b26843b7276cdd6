// TSID's control tick on exo18: centre of mass, posture, waist, two six-dimensional contacts or one and a swing foot, torque
// bounds; solver eiquadprog-fast. It follows its own accelerations, without physics between the ticks.
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <tsid/contacts/contact-6d.hpp>
#include <tsid/formulations/inverse-dynamics-formulation-acc-force.hpp>
#include <tsid/robots/robot-wrapper.hpp>
#include <tsid/solvers/solver-HQP-factory.hxx>
#include <tsid/solvers/utils.hpp>
#include <tsid/tasks/task-actuation-bounds.hpp>
#include <tsid/tasks/task-com-equality.hpp>
#include <tsid/tasks/task-joint-posture.hpp>
#include <tsid/tasks/task-se3-equality.hpp>

#include "table.hpp"

using namespace tsid;
using Eigen::VectorXd;
using Vector3 = Eigen::Vector3d;

int main(int, char** argv) {
  const std::string stem = argv[1], mode = argv[2];
  const bool single = mode == "single";
  const ModelList list = ModelList::read(stem + ".txt");
  const std::vector<std::string> none;
  robots::RobotWrapper robot(stem + ".urdf", none, pinocchio::JointModelFreeFlyer());
  const auto& model = robot.model();
  const int nv = robot.nv(), na = robot.na();

  // The start pose is that of the recorded loop: torques, then q with the quaternion (w, x, y, z) first.
  const Table steps = Table::read(argv[3]);
  const double* start = steps.row(0) + list.joints.size();
  VectorXd q = VectorXd::Zero(robot.nq()), v = VectorXd::Zero(nv), effort = VectorXd::Zero(na);
  q.head<7>() << start[4], start[5], start[6], start[1], start[2], start[3], start[0];
  for (std::size_t j = 0; j < list.joints.size(); ++j) {
    const auto& joint = model.joints[model.getJointId(list.joints[j].name)];
    q[joint.idx_q()] = start[7 + j];
    effort[joint.idx_v() - 6] = list.joints[j].effort;
  }

  InverseDynamicsFormulationAccForce formulation("tsid", robot, false);
  formulation.computeProblemData(0.0, q, v);
  auto placement = [&](const std::string& link) { return robot.framePosition(formulation.data(), model.getFrameId(link)); };

  std::vector<std::string> links;
  std::vector<std::shared_ptr<contacts::Contact6d>> feet;
  for (const auto& contact : list.contacts)
    if (links.empty() || links.back() != contact.link) links.push_back(contact.link);
  for (const auto& link : links) {
    Eigen::Matrix<double, 3, Eigen::Dynamic> points(3, 4);
    int k = 0;
    for (const auto& contact : list.contacts)
      if (contact.link == link) points.col(k++) << contact.position[0], contact.position[1], contact.position[2];
    auto foot = std::make_shared<contacts::Contact6d>("contact_" + link, robot, link, points, Vector3::UnitZ(), 0.8, 0.0, 3000.0);
    foot->Kp(VectorXd::Constant(6, 400.0));
    foot->Kd(VectorXd::Constant(6, 40.0));
    foot->setReference(placement(link));
    formulation.addRigidContact(*foot, 1e-5);
    feet.push_back(foot);
  }

  tasks::TaskComEquality com("com", robot);
  com.Kp(Vector3::Constant(20.0));
  com.Kd(Vector3::Constant(9.0));
  formulation.addMotionTask(com, 1.0, 1);
  tasks::TaskJointPosture posture("posture", robot);
  posture.Kp(VectorXd::Constant(na, 10.0));
  posture.Kd(VectorXd::Constant(na, 6.0));
  formulation.addMotionTask(posture, 1e-3, 1);
  trajectories::TrajectorySample posture_reference{static_cast<unsigned>(na)};
  posture_reference.setValue(q.tail(na));
  posture.setReference(posture_reference);

  auto task_of = [&](const std::string& name, const std::string& link, bool rotation_only, double gain) {
    auto task = std::make_shared<tasks::TaskSE3Equality>(name, robot, link);
    task->Kp(VectorXd::Constant(6, gain));
    task->Kd(VectorXd::Constant(6, 2.0 * std::sqrt(gain)));
    if (rotation_only) {
      VectorXd mask(6);
      mask << 0, 0, 0, 1, 1, 1;
      task->setMask(mask);
    }
    return task;
  };
  auto waist = task_of("waist", list.torso, true, 100.0);
  waist->setReference(placement(list.torso));
  formulation.addMotionTask(*waist, 1.0, 1);
  auto swing = task_of("swing", links[1], false, 400.0);

  tasks::TaskActuationBounds bounds("torques", robot);
  bounds.setBounds(-effort, effort);
  formulation.addActuationTask(bounds, 1.0, 0);

  std::unique_ptr<solvers::SolverHQPBase> solver(
      solvers::SolverHQPFactory::createNewSolver(solvers::SOLVER_HQP_EIQUADPROG_FAST, "solver"));
  auto resize = [&] { solver->resize(formulation.nVar(), formulation.nEq(), formulation.nIn()); };
  resize();

  const Vector3 com_start = robot.com(formulation.data());
  const pinocchio::SE3 right = placement(links[0]), left = placement(links[1]);
  const double dt = 1e-3, pi = 3.14159265358979;
  const int lift = single ? 1500 : -1, ticks = single ? 4500 : 8000;
  Table out;
  out.columns = 3;
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = tick * dt;
    trajectories::TrajectorySample reference(3);
    Vector3 offset = Vector3::Zero();
    if (single) {
      offset.y() = (right.translation().y() - com_start.y()) * std::min(1.0, t);
    } else {
      const double phase = 2.0 * pi * t / 2.0;
      offset << 0.01 * std::sin(phase), 0.03 * std::sin(phase), -0.03 * (1.0 - std::cos(phase));
    }
    reference.setValue(com_start + offset);
    com.setReference(reference);
    if (tick == lift) {
      formulation.removeRigidContact(feet[1]->name(), 0.0);
      formulation.addMotionTask(*swing, 10.0, 1);
      resize();
    }
    if (single && tick >= lift) {
      pinocchio::SE3 at = left;
      const double phase = std::min(1.0, (t - lift * dt) / 3.0);
      at.translation() += Vector3(0.1 * std::sin(2.0 * pi * phase), 0.0, 0.06 * std::sin(pi * phase));
      swing->setReference(at);
    }

    const Clock clock;
    const auto& problem = formulation.computeProblemData(t, q, v);
    const auto& solution = solver->solve(problem);
    const bool solved = solution.status == solvers::HQP_STATUS_OPTIMAL;
    if (solved) formulation.getActuatorForces(solution);
    const double time = clock.microseconds();

    if (!single || tick >= lift) out.begin_answer(time, solved, solution.iterations);
    if (!solved) {
      std::fprintf(stderr, "not solved at tick %d\n", tick);
      if (tick < 10) return 1;
      continue;
    }
    v += dt * formulation.getAccelerations(solution);
    q = pinocchio::integrate(model, q, VectorXd(dt * v));
  }
  const double error = (robot.com(formulation.data()) - com_start).norm();
  std::printf("TSID: centre of mass %.3f m from the start at the end\n", error);
  out.write(argv[4]);
}
