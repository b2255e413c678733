#include "compare/equilibrium/joint_changes.h"

#include <algorithm>
#include <cmath>

#include "common/joints/facts.h"
#include "common/rotation.h"
#include "compare/audit/element_laws.h"
#include "compare/audit/places.h"
#include "compare/verdict/observe.h"

namespace concord::compare {

namespace {

int count_speeds(const Model& model) {
  int n = 0;
  for (const Joint& joint : model.joints) n += static_cast<int>(turning_speeds(*joint.type).size());
  return n;
}

}  // namespace

JointMotion motion_of(const Model& model, std::size_t k, const State& state) {
  const Joint& joint = model.joints[k];
  return read_motion(*joint.type, relative_motion_of(joint, state), state.q[k]);
}

VecX joint_speeds(const Model& model, const State& state) {
  VecX speeds(count_speeds(model));
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const VecX u = motion_of(model, k, state).u;
    const std::vector<bool> turns = turning_speeds(*model.joints[k].type);
    for (Eigen::Index c = 0; c < u.size(); ++c) {
      speeds(row++) = u(c) / (turns[static_cast<std::size_t>(c)] ? 1.0 : model.length_scale());
    }
  }
  return speeds;
}

VecX joint_displacements(const Model& model, const State& start, const State& state) {
  VecX moved = VecX::Zero(count_speeds(model));
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const joints::JointType& type = *model.joints[k].type;
    const std::vector<bool> turns = turning_speeds(type);
    const VecX from = motion_of(model, k, start).q;
    const VecX to = motion_of(model, k, state).q;
    for (std::size_t word = 0; word < type.permits.size(); ++word) {
      const int q = first_q(type, static_cast<int>(word));
      const int u = first_u(type, static_cast<int>(word));
      if (is_orientation(type.permits[word])) {
        const Mat3 turn = rotation_of(Vec4(to.segment<4>(q))) * rotation_of(Vec4(from.segment<4>(q))).transpose();
        const Eigen::AngleAxisd by(turn);
        moved.segment<3>(first + u) = by.angle() * by.axis();
        continue;
      }
      for (int c = 0; c < n_u(type.permits[word]); ++c) {
        const bool is_turn = turns[static_cast<std::size_t>(u + c)];
        moved(first + u + c) = (to(q + c) - from(q + c)) / (is_turn ? 1.0 : model.length_scale());
      }
    }
    first += static_cast<Eigen::Index>(turns.size());
  }
  return moved;
}

MatX weighed_by_nearness(const Model& model, const VecX& moved, MatX rates) {
  constexpr double kLeastCurvature = 0.02;  // at half a turn it vanishes
  Eigen::Index first = 0;
  for (const Joint& joint : model.joints) {
    const joints::JointType& type = *joint.type;
    for (std::size_t word = 0; word < type.permits.size(); ++word) {
      if (!is_orientation(type.permits[word])) continue;
      const Eigen::Index u = first + first_u(type, static_cast<int>(word));
      const Vec3 turn = moved.segment<3>(u);
      const double half = 0.5 * turn.norm();
      if (!(half > 0.0)) continue;
      const double across = std::sqrt(std::max(kLeastCurvature, half / std::tan(half)));
      const Vec3 axis = turn.normalized();
      const Mat3 weights = across * Mat3::Identity() + (1.0 - across) * axis * axis.transpose();
      rates.middleRows<3>(u) = weights * MatX(rates.middleRows<3>(u));
    }
    first += type.n_u();
  }
  return rates;
}

}  // namespace concord::compare
