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

/// A turn of a joint that gears tie to others.
struct Shaft {
  int joint;
  int speed;
  double rate = 1.0;  // of the shaft beside which its train was found
  int train = 0;
};

/// All turns that gears of two tie to each other; trains of gears are followed. A differential leaves its shafts free.
std::vector<Shaft> geared_shafts(const Model& model) {
  std::vector<Shaft> shafts;
  const auto shaft_of = [&](const CouplingTerm& term) {
    const int speed = speed_of(model, term);
    const auto is_it = [&](const Shaft& shaft) { return shaft.joint == term.joint && shaft.speed == speed; };
    const auto found = std::find_if(shafts.begin(), shafts.end(), is_it);
    if (found != shafts.end()) return static_cast<std::size_t>(found - shafts.begin());
    shafts.push_back({term.joint, speed, 1.0, static_cast<int>(shafts.size())});
    return shafts.size() - 1;
  };
  for (const Coupling& coupling : model.couplings) {
    if (coupling.terms.size() != 2 || !is_turn(model, coupling.terms[0]) || !is_turn(model, coupling.terms[1]))
      continue;
    const std::size_t first = shaft_of(coupling.terms[0]);
    const std::size_t second = shaft_of(coupling.terms[1]);
    const double rate = shafts[first].rate * std::abs(coupling.terms[0].factor / coupling.terms[1].factor);
    const double change = rate / shafts[second].rate;
    const int joined = shafts[second].train;
    for (Shaft& shaft : shafts) {
      if (shaft.train != joined || joined == shafts[first].train) continue;
      shaft.rate *= change;
      shaft.train = shafts[first].train;
    }
  }
  return shafts;
}

/// How many times a joint's turn runs faster than the slowest one of its train, at least 1: the motor of a gear goes
/// round many times while nothing else of the machine has turned far.
double gear_ratio(const std::vector<Shaft>& shafts, std::size_t joint, Eigen::Index speed) {
  for (const Shaft& one : shafts) {
    if (one.joint != static_cast<int>(joint) || one.speed != speed) continue;
    double slowest = one.rate;
    for (const Shaft& other : shafts) {
      if (other.train == one.train) slowest = std::min(slowest, other.rate);
    }
    return one.rate / slowest;
  }
  return 1.0;
}

/// Turns of a thread: a screw goes round many times while its nut has hardly moved, and so does the shaft that turns
/// it.
struct Threads {
  struct Thread {
    const Joint* joint;
    double turn;   // |speed| in the step [rad]
    double ratio;  // the machine's length over what a radian moves along the axis
  };
  std::vector<Thread> all;

  /// Of a joint's motion along the step: turns that move along their own axes.
  void take(const Joint& joint, const JointMotion& motion, const std::vector<bool>& turns, double length) {
    constexpr double kAlong = 0.9;  // cosine between the displacement and the axis
    for (Eigen::Index c = 0; c < motion.u.size(); ++c) {
      if (!turns[static_cast<std::size_t>(c)]) continue;
      const Vec3 moved = motion.S.col(c).head<3>();
      const Vec3 axis = motion.S.col(c).tail<3>();
      if (!(std::abs(moved.dot(axis)) > kAlong * moved.norm() * axis.norm())) continue;
      all.push_back({&joint, std::abs(motion.u(c)), length * axis.norm() / moved.norm()});
    }
  }
  /// By how much a turn of this size of a joint counts less, at least 1: that of a thread, or of what turns as fast on
  /// one of its bodies.
  [[nodiscard]] double ratio(const Joint& joint, double turn) const {
    constexpr double kAsFast = 1e-6;
    double ratio = 1.0;
    for (const Thread& thread : all) {
      const bool is_as_fast = std::abs(turn - thread.turn) <= kAsFast * thread.turn;
      if (is_as_fast && share_a_body(joint, *thread.joint)) ratio = std::max(ratio, thread.ratio);
    }
    return ratio;
  }
  static bool share_a_body(const Joint& one, const Joint& other) {
    return std::any_of(one.sides.begin(), one.sides.end(), [&](const Attachment& side) {
      return side.body != 0 && (side.body == other.sides[0].body || side.body == other.sides[1].body);
    });
  }
};

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
  const std::vector<Shaft> shafts = geared_shafts(model);
  const std::vector<JointMotion> motions = motions_of(model, moving);
  Threads threads;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    threads.take(model.joints[k], motions[k], turning_speeds(*model.joints[k].type), model.length_scale());
  }
  JointStep largest;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const VecX& u = motions[k].u;
    const std::vector<bool> turns = turning_speeds(*model.joints[k].type);
    for (Eigen::Index c = 0; c < u.size(); ++c) {
      if (turns[static_cast<std::size_t>(c)]) {
        const double turn = std::abs(u(c));
        largest.fastest_turn = std::max(largest.fastest_turn, turn);
        largest.turn =
            std::max(largest.turn, turn / std::max(gear_ratio(shafts, k, c), threads.ratio(model.joints[k], turn)));
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
