// All dynamic quantities of a state with Pinocchio: M, h, foot Jacobians and their bias, A, its bias, centre of mass.
#include <pinocchio/algorithm/centroidal.hpp>
#include <pinocchio/algorithm/center-of-mass.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "table.hpp"

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
namespace pin = pinocchio;

struct Foot {
  pin::FrameIndex frame;
  MatrixXd jacobian;
  pin::Motion bias;
};

int main(int, char** argv) {
  const std::string stem = argv[1];
  const ModelList list = ModelList::read(stem + ".txt");
  const bool planar = list.planar();
  pin::Model model;
  if (planar) {
    pin::urdf::buildModel(stem + ".urdf", model);
  } else {
    pin::urdf::buildModel(stem + ".urdf", pin::JointModelFreeFlyer(), model);
  }
  pin::Data data(model);
  const Table states = Table::read(argv[2]);
  const int nv = model.nv;

  // From legwork's order of velocities to Pinocchio's: a floating base is angular first there, linear first here.
  std::vector<int> q_of, v_of;
  if (!planar) {
    v_of = {3, 4, 5, 0, 1, 2};
    q_of = {6, 3, 4, 5, 0, 1, 2};
  }
  for (const auto& joint : list.joints) {
    const auto id = model.getJointId(joint.name);
    q_of.push_back(model.joints[id].idx_q());
    v_of.push_back(model.joints[id].idx_v());
  }

  std::vector<Foot> feet;
  std::vector<int> foot_of;
  for (const auto& contact : list.contacts) {
    const auto frame = model.getFrameId(contact.link);
    std::size_t k = 0;
    while (k < feet.size() && feet[k].frame != frame) ++k;
    if (k == feet.size()) feet.push_back({frame, MatrixXd::Zero(6, nv), {}});
    foot_of.push_back(int(k));
  }

  const int axes = planar ? 2 : 3, momentum = planar ? 3 : 6, rows = axes * int(list.contacts.size());
  Table out;
  out.columns = 3 + nv * nv + nv + rows * nv + rows + momentum * nv + momentum + 3;
  VectorXd q(model.nq), v(nv);
  const VectorXd zero = VectorXd::Zero(nv);
  const std::size_t warm_up = 200;
  for (std::size_t i = 0; i < states.rows() + warm_up; ++i) {
    const double* state = states.row(i < warm_up ? i : i - warm_up);
    for (int j = 0; j < model.nq; ++j) q[q_of[j]] = state[j];
    for (int j = 0; j < nv; ++j) v[v_of[j]] = state[model.nq + j];

    const Clock clock;
    pin::crba(model, data, q, pin::Convention::WORLD);
    pin::nonLinearEffects(model, data, q, v);
    pin::ccrba(model, data, q, v);
    // With forward kinematics to second order, and d/dt of the momentum at zero acceleration
    pin::computeCentroidalMomentumTimeVariation(model, data, q, v, zero);
    data.M.triangularView<Eigen::StrictlyLower>() = data.M.transpose().triangularView<Eigen::StrictlyLower>();
    for (auto& foot : feet) {
      pin::updateFramePlacement(model, data, foot.frame);
      pin::getFrameJacobian(model, data, foot.frame, pin::LOCAL_WORLD_ALIGNED, foot.jacobian);
      foot.bias = pin::getFrameClassicalAcceleration(model, data, foot.frame, pin::LOCAL_WORLD_ALIGNED);
    }
    const double time = clock.microseconds();
    if (i < warm_up) continue;

    out.begin_answer(time, true, 0);
    auto put = [&](double value) { out.values.push_back(value); };
    for (int r = 0; r < nv; ++r)
      for (int c = 0; c < nv; ++c) put(data.M(v_of[r], v_of[c]));
    for (int r = 0; r < nv; ++r) put(data.nle[v_of[r]]);
    // A contact point's rows follow from its foot's; a user would keep those of the foot.
    std::vector<double> biases;
    for (std::size_t k = 0; k < list.contacts.size(); ++k) {
      const Foot& foot = feet[foot_of[k]];
      const double* p = list.contacts[k].position;
      const Vector3d arm = data.oMf[foot.frame].rotation() * Vector3d(p[0], p[1], p[2]);
      const auto velocity = pin::getFrameVelocity(model, data, foot.frame, pin::LOCAL_WORLD_ALIGNED);
      const Vector3d w = velocity.angular();
      const Vector3d bias = foot.bias.linear() + foot.bias.angular().cross(arm) + w.cross(w.cross(arm));
      MatrixXd J(3, nv);
      for (int c = 0; c < nv; ++c) {
        const Vector3d angular = foot.jacobian.col(c).tail<3>();
        J.col(c) = foot.jacobian.col(c).head<3>() + angular.cross(arm);
      }
      for (int axis = 0; axis < 3; ++axis) {
        if (planar && axis == 1) continue;
        for (int c = 0; c < nv; ++c) put(J(axis, v_of[c]));
        biases.push_back(bias[axis]);
      }
    }
    for (double bias : biases) put(bias);
    const int order[] = {3, 4, 5, 0, 1, 2};
    for (int r : order) {
      if (planar && (r == 3 || r == 5 || r == 1)) continue;
      const double sign = planar && r == 4 ? -1.0 : 1.0;
      for (int c = 0; c < nv; ++c) put(sign * data.Ag(r, v_of[c]));
    }
    for (int r : order) {
      if (planar && (r == 3 || r == 5 || r == 1)) continue;
      put((planar && r == 4 ? -1.0 : 1.0) * data.dhg.toVector()[r]);
    }
    for (int axis = 0; axis < 3; ++axis) put(data.com[0][axis]);
  }
  out.write(argv[3]);
}
