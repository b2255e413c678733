#include "compare/equilibrium/joint_changes.h"

#include <algorithm>
#include <cmath>

#include "common/joints/facts.h"
#include "common/rotation.h"
#include "compare/audit/element_laws.h"
#include "compare/audit/places.h"
#include "compare/quantities/observe.h"

namespace concord::compare {

namespace {

int count_speeds(const Model& model) {
  int n = 0;
  for (const Joint& joint : model.joints) n += static_cast<int>(turning_speeds(*joint.type).size());
  return n;
}

/// By how much coordinate q with change dq enters a stop, in units of the way to half of its width; of one that is
/// pressed in part, by half of its width. What presses its whole width knows its stiffness already.
double into_stops(const ForceLaw& law, double q, double dq) {
  double most = 0.0;
  const auto take = [&most](const std::optional<SmoothStop>& stop, double depth, double change) {
    if (stop && depth < stop->width) most = std::max(most, change / (std::max(0.0, -depth) + 0.5 * stop->width));
  };
  if (law.upper) take(law.upper, q - law.upper->at, dq);
  if (law.lower) take(law.lower, law.lower->at - q, -dq);
  return most;
}

}  // namespace

JointMotion motion_of(const Model& model, std::size_t k, const State& state) {
  const Joint& joint = model.joints[k];
  return read_motion(*joint.type, relative_motion_of(joint, state), state.q[k]);
}

std::vector<JointMotion> motions_of(const Model& model, const State& state) {
  std::vector<JointMotion> motions;
  for (std::size_t k = 0; k < model.joints.size(); ++k) motions.push_back(motion_of(model, k, state));
  return motions;
}

std::vector<SprungCoordinate> sprung_coordinates(const Model& model, const State& state,
                                                 const std::vector<JointMotion>& motions) {
  std::vector<SprungCoordinate> all;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    for (const JointSpring& spring : joint.springs) {
      all.push_back({&spring.law, state.q[k](first_q(*joint.type, spring.word) + spring.component),
                     motions[k].u(first_u(*joint.type, spring.word) + spring.component),
                     joints::is_length(joint.type->permits[spring.word], spring.component)});
    }
  }
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    const ForceElement& element = model.elements[e];
    if (const auto* line = std::get_if<LineSpring>(&element.what)) {
      const LineMotion motion = motion_of(*line, state);
      all.push_back({&line->law, motion.distance, motion.rate, true});
    } else if (const auto* turn = std::get_if<TurnSpring>(&element.what)) {
      const TurnMotion motion = motion_of(*turn, state, state.known_angle(e));
      all.push_back({&turn->law, motion.angle, motion.rate, false});
    }
  }
  return all;
}

JointStep joint_step(const Model& model, const Chart& chart, const VecX& step) {
  const State moving = chart.origin_moving(step);
  const std::vector<JointMotion> motions = motions_of(model, moving);
  JointStep largest;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const VecX& u = motions[k].u;
    const std::vector<bool> turns = turning_speeds(*model.joints[k].type);
    for (Eigen::Index c = 0; c < u.size(); ++c) {
      if (turns[static_cast<std::size_t>(c)]) {
        largest.turn = std::max(largest.turn, std::abs(u(c)));
      } else {
        largest.rest = std::max(largest.rest, std::abs(u(c)) / model.length_scale());
      }
    }
  }
  for (const SprungCoordinate& one : sprung_coordinates(model, moving, motions)) {
    largest.into_stops = std::max(largest.into_stops, into_stops(*one.law, one.x, one.xdot));
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (model.bodies[i].n_modes() == 0) continue;
    largest.rest =
        std::max(largest.rest, modal_sizes(model, i).cwiseProduct(moving.bodies[i].adot).lpNorm<Eigen::Infinity>());
  }
  return largest;
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
