// TSID's formulation for exo18: centre of mass, posture, waist, two six-dimensional contacts of four points each, torque bounds;
// solver eiquadprog-fast. With it the motion of the scenario exo-sway.
#pragma once

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

// A coordinate with its derivatives, times another: product rule.
using Motion = std::array<double, 3>;

inline Motion product(const Motion& a, const Motion& b) {
  return {a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]};
}

// What exo-sway adds to the centre of mass of the start: sway, which begins smoothly within its first period, and squat.
inline void sway(double t, Vector3& position, Vector3& velocity, Vector3& acceleration) {
  const double period = 2.0, w = 2.0 * EIGEN_PI / period, s = std::sin(w * t), c = std::cos(w * t), u = t / period;
  Motion begin = {1.0, 0.0, 0.0};
  if (u < 1.0) {
    // Flash and Hogan 1985: minimum jerk.
    begin = {u * u * u * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * u * u * (1.0 - u) * (1.0 - u) / period,
             60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (period * period)};
  }
  const Motion x = product(begin, {s, w * c, -w * w * s}), z = {1.0 - c, w * s, w * w * c};
  Vector3* parts[] = {&position, &velocity, &acceleration};
  for (int k = 0; k < 3; ++k) *parts[k] << 0.01 * x[k], 0.03 * x[k], -0.03 * z[k];
}

struct TsidExo {
  ModelList list;
  robots::RobotWrapper robot;
  InverseDynamicsFormulationAccForce formulation;
  std::unique_ptr<solvers::SolverHQPBase> solver;
  std::vector<std::string> links;
  std::vector<std::shared_ptr<contacts::Contact6d>> feet;
  std::shared_ptr<tasks::TaskComEquality> com;
  std::vector<std::shared_ptr<tasks::TaskMotion>> others;
  std::shared_ptr<tasks::TaskActuationBounds> bounds;
  // Where the list's joints stand among Pinocchio's velocities, less the six of the base.
  std::vector<int> index;
  VectorXd q, v;
  Vector3 com_start, com_goal;

  // `start` is legwork's q: quaternion (w, x, y, z), position, joints.
  TsidExo(const std::string& stem, const double* start)
      : list(ModelList::read(stem + ".txt")),
        robot(stem + ".urdf", std::vector<std::string>(), pinocchio::JointModelFreeFlyer()),
        formulation("tsid", robot, false),
        solver(solvers::SolverHQPFactory::createNewSolver(solvers::SOLVER_HQP_EIQUADPROG_FAST, "solver")),
        q(VectorXd::Zero(robot.nq())),
        v(VectorXd::Zero(robot.nv())) {
    for (const auto& joint : list.joints) {
      const auto& model = robot.model();
      index.push_back(model.joints[model.getJointId(joint.name)].idx_v() - 6);
    }
    set_position(start + 4, start, start + 7);
    formulation.computeProblemData(0.0, q, v);
    com_start = com_goal = robot.com(formulation.data());
    add_contacts();
    add_tasks();
    resize();
  }

  void set_position(const double* position, const double* quaternion, const double* joints) {
    q.head<7>() << position[0], position[1], position[2], quaternion[1], quaternion[2], quaternion[3], quaternion[0];
    for (std::size_t j = 0; j < index.size(); ++j) q[7 + index[j]] = joints[j];
  }

  pinocchio::SE3 placement(const std::string& link) {
    return robot.framePosition(formulation.data(), robot.model().getFrameId(link));
  }

  void resize() { solver->resize(formulation.nVar(), formulation.nEq(), formulation.nIn()); }

  std::shared_ptr<tasks::TaskSE3Equality> task_of(const std::string& name, const std::string& link, double gain) {
    auto task = std::make_shared<tasks::TaskSE3Equality>(name, robot, link);
    task->Kp(VectorXd::Constant(6, gain));
    task->Kd(VectorXd::Constant(6, 2.0 * std::sqrt(gain)));
    return task;
  }

  void follow(const Vector3& position, const Vector3& velocity, const Vector3& acceleration) {
    trajectories::TrajectorySample reference(3);
    com_goal = com_start + position;
    reference.setValue(com_goal);
    reference.setDerivative(velocity);
    reference.setSecondDerivative(acceleration);
    com->setReference(reference);
  }

  void follow_sway(double t) {
    Vector3 position, velocity, acceleration;
    sway(t, position, velocity, acceleration);
    follow(position, velocity, acceleration);
  }

  const solvers::HQPOutput& solve(double t) { return solver->solve(formulation.computeProblemData(t, q, v)); }

  double com_error() { return (robot.com(formulation.data()) - com_goal).norm(); }

 private:
  void add_contacts() {
    for (const auto& contact : list.contacts)
      if (links.empty() || links.back() != contact.link) links.push_back(contact.link);
    for (const auto& link : links) {
      Eigen::Matrix<double, 3, Eigen::Dynamic> points(3, 4);
      int k = 0;
      for (const auto& contact : list.contacts)
        if (contact.link == link) points.col(k++) << contact.position[0], contact.position[1], contact.position[2];
      auto foot =
          std::make_shared<contacts::Contact6d>("contact_" + link, robot, link, points, Vector3::UnitZ(), 0.8, 0.0, 3000.0);
      foot->Kp(VectorXd::Constant(6, 400.0));
      foot->Kd(VectorXd::Constant(6, 40.0));
      foot->setReference(placement(link));
      formulation.addRigidContact(*foot, 1e-5);
      feet.push_back(foot);
    }
  }

  void add_tasks() {
    const int na = robot.na();
    com = std::make_shared<tasks::TaskComEquality>("com", robot);
    com->Kp(Vector3::Constant(20.0));
    com->Kd(Vector3::Constant(9.0));
    formulation.addMotionTask(*com, 1.0, 1);

    auto posture = std::make_shared<tasks::TaskJointPosture>("posture", robot);
    posture->Kp(VectorXd::Constant(na, 10.0));
    posture->Kd(VectorXd::Constant(na, 6.0));
    trajectories::TrajectorySample reference{static_cast<unsigned>(na)};
    reference.setValue(q.tail(na));
    posture->setReference(reference);
    formulation.addMotionTask(*posture, 1e-3, 1);

    auto waist = task_of("waist", list.torso, 100.0);
    VectorXd rotation_only(6);
    rotation_only << 0, 0, 0, 1, 1, 1;
    waist->setMask(rotation_only);
    waist->setReference(placement(list.torso));
    formulation.addMotionTask(*waist, 1.0, 1);
    others = {posture, waist};

    VectorXd effort(na);
    for (std::size_t j = 0; j < index.size(); ++j) effort[index[j]] = list.joints[j].effort;
    bounds = std::make_shared<tasks::TaskActuationBounds>("torques", robot);
    bounds->setBounds(-effort, effort);
    formulation.addActuationTask(*bounds, 1.0, 0);
  }
};
