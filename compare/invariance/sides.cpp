#include "compare/invariance/sides.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <numbers>

#include "common/joints/named_coordinates.h"
#include "common/rotation.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/invariance/laws.h"

namespace concord::compare::invariance {

namespace {

enum class Reading { none, backwards, anew };

/// How a joint is described from its other side: the axes of its frame on each side are turned, C' = C Q.
struct Reversal {
  Reading reading = Reading::none;
  std::array<Mat3, 2> Q{Mat3::Identity(), Mat3::Identity()};  // by the side in the first description
  bool words_change_places = false;
};

/// Whether a motion of one coordinate runs backwards if its coordinate changes sign.
bool is_odd(const joints::FunctionOfCoordinates& motion) {
  if (motion.n() != 1) return false;
  constexpr double kNoDifference = 1e-12;
  const double u = 0.0;
  for (const double q : {0.3, -0.8, 1.7}) {
    joints::FunctionOfCoordinates::Motion forth;
    joints::FunctionOfCoordinates::Motion back;
    const double minus_q = -q;
    motion.evaluate(&q, &u, forth);
    motion.evaluate(&minus_q, &u, back);
    const Mat3 R = forth.placement.R.transpose();
    if ((back.placement.R - R).norm() > kNoDifference) return false;
    if ((back.placement.d + R * forth.placement.d).norm() > kNoDifference * (1.0 + forth.placement.d.norm()))
      return false;
  }
  return true;
}

/// Whether a ball is all that a type permits.
bool is_ball(const joints::JointType& type) { return type.permits.size() == 1 && is_orientation(type.permits.front()); }

bool reads_backwards(const joints::JointType& type, Reversal& reversal) {
  if (!type.forbids_speeds.empty()) return false;
  if (type.permits.size() == 1) {
    if (const joints::FunctionOfCoordinates* motion = function_of(type.permits.front())) return is_odd(*motion);
  }
  if (is_ball(type)) return true;
  std::vector<Axis> axes;
  bool only_turns = true;
  for (const NamedCoordinate& coordinate : named_coordinates(type)) {
    if (!coordinate.axis) return false;
    axes.push_back(*coordinate.axis);
    only_turns = only_turns && coordinate.kind == joints::CoordinateKind::angle;
  }
  if (axes.size() != type.permits.size()) return false;  // an arm, or a word of several coordinates
  if (std::all_of(axes.begin(), axes.end(), [&](Axis axis) { return axis == axes.front(); })) return true;
  if (!only_turns || axes.size() != 2) return false;
  // A half turn between both axes changes them.
  Vec3 between = Vec3::Unit(index(axes[0])) + Vec3::Unit(index(axes[1]));
  const Mat3 Q = rotation_about(Vec3(between.normalized()), std::numbers::pi);
  reversal.Q = {Q, Q};
  reversal.words_change_places = true;
  return true;
}

/// The axis of the frame along which the arm of a link points; nothing of other types.
std::optional<Axis> arm_of_link(const joints::JointType& type) {
  const bool is_link = type.forbids.size() == 1 && joints::stated_length(type.forbids.front()) > 0.0;
  if (!is_link) return std::nullopt;
  for (const joints::Permit& word : type.permits) {
    if (const std::optional<Axis> arm = joints::arm_of(word)) return arm;
  }
  return std::nullopt;
}

/// A rotation that leads an axis to a unit vector, and the next one as near to `next` as may be.
Mat3 with_axis(Axis axis, const Vec3& to, const Vec3& next) {
  constexpr double kTooNear = 0.1;
  const Vec3 across = next - to.dot(next) * to;
  Mat3 G;
  G.col(index(axis)) = to;
  G.col((index(axis) + 1) % 3) = across.norm() > kTooNear ? Vec3(across.normalized()) : to.unitOrthogonal();
  G.col((index(axis) + 2) % 3) = to.cross(G.col((index(axis) + 1) % 3));
  return G;
}

Reversal reversal_of(const Model& model, int k, const std::optional<State>& at) {
  const Joint& joint = model.joints[static_cast<std::size_t>(k)];
  Reversal reversal;
  if (reads_backwards(*joint.type, reversal)) {
    reversal.reading = Reading::backwards;
    return reversal;
  }
  if (is_forced(model, k) || !joint.type->forbids_speeds.empty()) return reversal;
  if (joint.type->rows() == 0) {
    reversal.reading = Reading::anew;
  } else if (const auto arm = arm_of_link(*joint.type); arm && at) {
    const RelativeMotion now = relative_motion_of(joint, *at);
    const Vec3 along = -(now.R.transpose() * now.d).normalized();
    // The start keeps turns of the arm: they go on about the same lines, as in a plane that the arms may not leave.
    const Vec3 next = now.R.transpose() * Vec3::Unit((index(*arm) + 1) % 3);
    reversal.Q[index(Side::child)] = with_axis(*arm, along, next);
    reversal.reading = Reading::anew;
  }
  return reversal;
}

/// Coordinates of the child in the parent turned into those of the parent in the child: slides and turns along one axis
/// change sign, a ball's Euler parameters are conjugated.
VecX reversed_coordinates(bool of_ball, const VecX& q) {
  if (!of_ball) return -q;
  return Vec4(q(0), -q(1), -q(2), -q(3));
}

/// The same for speeds: a ball's are seen from the other side.
VecX reversed_speeds(bool of_ball, const VecX& q, const VecX& u) {
  if (!of_ball) return -u;
  return -(rotation_of(Vec4(q.normalized())).transpose() * u);
}

void reverse_words(Joint& joint, const Reversal& reversal) {
  const int last = static_cast<int>(joint.type->permits.size()) - 1;
  const auto place_of = [&](int word) { return reversal.words_change_places ? last - word : word; };
  if (reversal.words_change_places) std::reverse(joint.start.begin(), joint.start.end());
  for (WordStart& word : joint.start) {
    if (word.q.size() == 0) continue;
    word.u = reversed_speeds(is_ball(*joint.type), word.q, word.u);
    word.q = reversed_coordinates(is_ball(*joint.type), word.q);
  }
  for (Driver& driver : joint.drivers) {
    driver.word = place_of(driver.word);
    driver.law = scaled(driver.law, -1.0);
  }
  for (JointSpring& spring : joint.springs) {
    spring.word = place_of(spring.word);
    spring.law = mirrored(spring.law);
  }
}

void swap_sides(Model& model, std::size_t k, const Reversal& reversal) {
  Joint& joint = model.joints[k];
  for (const Side side : kSides) joint.sides[index(side)].C = joint.sides[index(side)].C * reversal.Q[index(side)];
  std::swap(joint.sides[0], joint.sides[1]);
  if (reversal.reading == Reading::anew) return;
  reverse_words(joint, reversal);
  const int last = static_cast<int>(joint.type->permits.size()) - 1;
  for (Coupling& coupling : model.couplings) {
    for (CouplingTerm& term : coupling.terms) {
      if (term.joint != static_cast<int>(k)) continue;
      term.factor = -term.factor;
      if (reversal.words_change_places) term.word = last - term.word;
    }
  }
}

/// All joints, and force elements whose sides are alike, at once.
struct Swapping {
  std::vector<Reversal> joints;
  std::vector<bool> elements;  // whether an element's ends change places
  Model first;
  Model second;

  [[nodiscard]] Model apply(Model model) const {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (joints[k].reading != Reading::none) swap_sides(model, k, joints[k]);
    }
    for (std::size_t e = 0; e < elements.size(); ++e) {
      if (!elements[e]) continue;
      const auto ends = ends_of(model.elements[e]);
      std::swap(ends.front(), ends.back());
    }
    return model;
  }

  [[nodiscard]] State coordinates(State state, const Model& told) const {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (joints[k].reading == Reading::none) continue;
      if (joints[k].reading == Reading::anew) {
        read_coordinates(told.joints[k], state, state.q[k], state.u[k]);
        continue;
      }
      const bool of_ball = is_ball(*told.joints[k].type);
      state.u[k] = reversed_speeds(of_ball, state.q[k], state.u[k]);
      state.q[k] = reversed_coordinates(of_ball, state.q[k]);
      if (!joints[k].words_change_places) continue;
      state.q[k].reverseInPlace();
      state.u[k].reverseInPlace();
    }
    return state;
  }

  [[nodiscard]] Evaluation back(Evaluation evaluation) const {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      const Reversal& reversal = joints[k];
      if (reversal.reading == Reading::none) continue;
      for (auto* wrenches : {&evaluation.joints[k].reaction, &evaluation.joints[k].total}) {
        std::swap((*wrenches)[0], (*wrenches)[1]);
        for (const Side side : kSides) {
          Wrench& wrench = (*wrenches)[static_cast<std::size_t>(index(side))].in_C;
          const Mat3& Q = reversal.Q[index(side)];
          wrench = {Q * wrench.force, Q * wrench.torque};
        }
      }
      const auto read_from_the_other_side = [&](VecX& forces) {
        if (reversal.reading == Reading::backwards && first.joints[k].type->n_q() == forces.size()) forces = -forces;
        if (reversal.words_change_places) forces.reverseInPlace();
      };
      read_from_the_other_side(evaluation.joints[k].tau);
      for (VecX& share : evaluation.joints[k].shares) read_from_the_other_side(share);
    }
    for (std::size_t e = 0; e < elements.size(); ++e) {
      if (elements[e]) std::swap(evaluation.elements[e].on[0], evaluation.elements[e].on[1]);
    }
    return evaluation;
  }

  [[nodiscard]] RankReport flags(RankReport report) const {
    std::vector<JointUniqueness>& decided = decided_flags(report);
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (joints[k].reading == Reading::none) continue;
      JointUniqueness& unique = report.joints[k];
      for (auto part : {&JointUniqueness::unique, &JointUniqueness::unique_total}) {
        std::swap((unique.*part)[0], (unique.*part)[1]);
        std::swap((decided[k].*part)[0], (decided[k].*part)[1]);
        for (std::size_t side = 0; side < 2; ++side) {
          turn_flags(joints[k].Q[side], (unique.*part)[side], (decided[k].*part)[side]);
        }
      }
      if (!joints[k].words_change_places) continue;
      for (auto* one : {&unique, &decided[k]}) {
        std::swap(one->unique_tau[0], one->unique_tau[1]);
        std::swap(one->unique_driver[0], one->unique_driver[1]);
      }
    }
    return report;
  }
};

}  // namespace

void read_coordinates(const Joint& joint, const State& bodies, VecX& q, VecX& u) {
  const JointMotion motion = read_motion(*joint.type, relative_motion_of(joint, bodies), VecX());
  q = motion.q;
  u = motion.u;
}

PartialChange swapped_sides(const Model& model, const std::optional<State>& at) {
  PartialChange partial;
  auto swapping = std::make_shared<Swapping>();
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    const Joint& joint = model.joints[static_cast<std::size_t>(k)];
    swapping->joints.push_back(reversal_of(model, k, at));
    if (swapping->joints.back().reading != Reading::none) {
      ++partial.changed;
    } else {
      partial.left.push_back(fmt::format("joint {}: the sides of type {} are not alike", joint.name, joint.type->name));
    }
  }
  for (const ForceElement& element : model.elements) {
    const bool swaps = has_sides_alike(element);
    swapping->elements.push_back(swaps);
    if (swaps) ++partial.changed;
    if (!swaps && ends_of(element).size() == 2) {
      partial.left.push_back(fmt::format("force element {}: its law is told in the parent's axes", element.name));
    }
  }
  swapping->first = model;
  swapping->second = swapping->apply(model);
  partial.change.model = [swapping](Model first) { return swapping->apply(std::move(first)); };
  partial.change.state = [swapping](State state) { return swapping->coordinates(std::move(state), swapping->second); };
  partial.change.back = [swapping](State state) { return swapping->coordinates(std::move(state), swapping->first); };
  partial.change.evaluation = [swapping](const State&, Evaluation evaluation) {
    return swapping->back(std::move(evaluation));
  };
  partial.change.report = [swapping](RankReport report) { return swapping->flags(std::move(report)); };
  return partial;
}

}  // namespace concord::compare::invariance
