#include "compare/analyses/joint_changes.h"

#include <algorithm>
#include <cmath>

#include "common/rotation.h"
#include "compare/audit/places.h"

namespace concord::compare::analyses {

namespace {

int count_speeds(const Model& model) {
  int n = 0;
  for (const Joint& joint : model.joints) n += static_cast<int>(turning_speeds(*joint.type).size());
  return n;
}

/// How many times a joint's turn runs faster than the slowest turn that a coupling ties to it, at least 1: the motor of
/// a gear goes round many times while nothing else of the machine has turned far.
double gear_ratio(const Model& model, int joint, Eigen::Index speed) {
  double ratio = 1.0;
  for (const Coupling& coupling : model.couplings) {
    double own = 0.0;
    double largest = 0.0;
    for (const CouplingTerm& term : coupling.terms) {
      const joints::JointType& type = *model.joints[term.joint].type;
      const int of_term = first_u(type, term.word) + term.component;
      if (!turning_speeds(type)[static_cast<std::size_t>(of_term)]) continue;
      largest = std::max(largest, std::abs(term.factor));
      if (term.joint == joint && of_term == speed) own = std::abs(term.factor);
    }
    if (own > 0.0) ratio = std::max(ratio, largest / own);
  }
  return ratio;
}

}  // namespace

JointMotion motion_of(const Model& model, std::size_t k, const State& state) {
  const Joint& joint = model.joints[k];
  const auto frame = [&](Side side) { return place(joint.on(side), state.bodies[joint.on(side).body]); };
  return read_motion(*joint.type, relative_motion(frame(Side::parent), frame(Side::child)), state.q[k]);
}

JointStep joint_step(const Model& model, const Chart& chart, const VecX& step) {
  const State moving = chart.origin_moving(step);
  JointStep largest;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const VecX u = motion_of(model, k, moving).u;
    const std::vector<bool> turns = turning_speeds(*model.joints[k].type);
    for (Eigen::Index c = 0; c < u.size(); ++c) {
      if (turns[static_cast<std::size_t>(c)]) {
        largest.fastest_turn = std::max(largest.fastest_turn, std::abs(u(c)));
        largest.turn = std::max(largest.turn, std::abs(u(c)) / gear_ratio(model, static_cast<int>(k), c));
      } else {
        largest.rest = std::max(largest.rest, std::abs(u(c)) / model.length_scale());
      }
    }
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

}  // namespace concord::compare::analyses
