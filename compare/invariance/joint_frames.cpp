#include "compare/invariance/joint_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "common/joints/named_coordinates.h"
#include "common/overloaded.h"
#include "common/rotation.h"
#include "compare/audit/places.h"
#include "compare/invariance/laws.h"

namespace concord::compare::invariance {

namespace {

/// How the frames of a joint or of a force element are turned, C' = C G, by side; and how coordinates follow: a turn
/// gets a constant more, slides and a ball are seen in the parent's turned axes.
struct FrameTurn {
  std::array<Mat3, 2> G{Mat3::Identity(), Mat3::Identity()};
  std::vector<double> shift;  // by named coordinate
  bool turns = false;

  [[nodiscard]] const Mat3& on(Side side) const { return G[static_cast<std::size_t>(index(side))]; }
  Mat3& on(Side side) { return G[static_cast<std::size_t>(index(side))]; }
};

/// Whether a motion by functions is the same about a turned axis.
bool is_round_about(const joints::FunctionOfCoordinates& motion, const Mat3& G) {
  constexpr double kNoDifference = 1e-12;
  const auto n = static_cast<Eigen::Index>(motion.n());
  for (const double size : {0.4, -0.9}) {
    const VecX q = VecX::LinSpaced(n, size, 0.7 * size);
    const VecX u = VecX::Zero(n);
    joints::FunctionOfCoordinates::Motion at;
    motion.evaluate(q.data(), u.data(), at);
    if ((G * at.placement.R - at.placement.R * G).norm() > kNoDifference) return false;
    if ((G * at.placement.d - at.placement.d).norm() > kNoDifference * (1.0 + at.placement.d.norm())) return false;
  }
  return true;
}

/// The coordinates of a motion, by kind.
struct CoordinatesByKind {
  std::vector<Axis> slides;
  std::optional<Axis> first_turn;
  std::optional<Axis> last_turn;
  std::size_t first_turn_place = 0;  // among the named coordinates
  std::size_t last_turn_place = 0;
  const joints::FunctionOfCoordinates* functions = nullptr;
  bool ball = false;
  bool is_known = true;  // what each one does
};

void add_coordinate(const joints::JointType& type, const NamedCoordinate& one, CoordinatesByKind& found) {
  if (one.kind == joints::CoordinateKind::orientation) {
    found.ball = true;
  } else if (!one.axis) {
    found.functions = function_of(type.permits[static_cast<std::size_t>(one.word)]);
    found.is_known = found.is_known && found.functions != nullptr;
  } else if (one.kind == joints::CoordinateKind::length) {
    found.slides.push_back(*one.axis);
  } else {
    const auto place = static_cast<std::size_t>(one.place);
    if (!found.first_turn) found.first_turn_place = place;
    if (!found.first_turn) found.first_turn = one.axis;
    found.last_turn = one.axis;
    found.last_turn_place = place;
  }
}

CoordinatesByKind coordinates_by_kind(const joints::JointType& type) {
  CoordinatesByKind found;
  for (const NamedCoordinate& one : named_coordinates(type)) add_coordinate(type, one, found);
  return found;
}

bool says_speeds_of_child(const joints::JointType& type) {
  return std::any_of(type.forbids_speeds.begin(), type.forbids_speeds.end(), joints::is_seen_from_child);
}

/// The axis about which the parent's frame may turn while slides stay slides along the same axes, as a plane or a line:
/// of one slide its own, of two the third one; nothing where it is any.
std::optional<Axis> axis_of_slides(const std::vector<Axis>& slides) {
  if (slides.size() == 1) return slides.front();
  if (slides.size() == 2) return static_cast<Axis>(3 - index(slides[0]) - index(slides[1]));
  return std::nullopt;
}

/// Both frames by the same rotation: types that fix the child's orientation.
void turn_together(const CoordinatesByKind& found, Draw& draw, FrameTurn& turn) {
  const std::optional<Axis> axis = axis_of_slides(found.slides);
  if (found.slides.size() > 1) return;
  if (found.functions != nullptr) {
    const double angle = draw.angle();
    for (const Axis about : {Axis::z, Axis::x, Axis::y}) {
      const Mat3 G = rotation_about(about, angle);
      if (!is_round_about(*found.functions, G)) continue;
      turn.G = {G, G};
      turn.turns = true;
      return;
    }
    return;
  }
  const Mat3 G = axis ? rotation_about(*axis, draw.angle()) : draw.rotation();
  turn.G = {G, G};
  turn.turns = true;
}

/// The parent's frame alone: about the first turn, if slides allow it; in front of a ball in any way that slides allow.
void turn_parent(const CoordinatesByKind& found, bool forced, Draw& draw, FrameTurn& turn) {
  const std::optional<Axis> allowed = axis_of_slides(found.slides);
  if (found.slides.size() > 1 && forced) return;  // slides would mix, and what acts on them
  if (found.first_turn) {
    const Axis axis = *found.first_turn;
    if (found.slides.size() == 3 || (allowed && *allowed != axis)) return;
    const double angle = draw.angle();
    turn.on(Side::parent) = rotation_about(axis, angle);
    turn.shift[found.first_turn_place] -= angle;
  } else {
    turn.on(Side::parent) = allowed ? rotation_about(*allowed, draw.angle()) : draw.rotation();
  }
  turn.turns = true;
}

void turn_child(const CoordinatesByKind& found, Draw& draw, FrameTurn& turn) {
  if (found.ball) {
    turn.on(Side::child) = draw.rotation();
  } else {
    const double angle = draw.angle();
    turn.on(Side::child) = rotation_about(*found.last_turn, angle);
    turn.shift[found.last_turn_place] += angle;
  }
  turn.turns = true;
}

FrameTurn turn_of(const Model& model, int k, Draw& draw) {
  const joints::JointType& type = *model.joints[static_cast<std::size_t>(k)].type;
  const CoordinatesByKind found = coordinates_by_kind(type);
  FrameTurn turn;
  turn.shift.assign(named_coordinates(type).size(), 0.0);
  if (!found.is_known) return turn;
  if (!found.ball && !found.last_turn) {
    turn_together(found, draw, turn);
    return turn;
  }
  turn_parent(found, is_forced(model, k), draw, turn);
  if (!says_speeds_of_child(type)) turn_child(found, draw, turn);
  return turn;
}

/// CoordinatesByKind and speeds of a joint between turned frames. `sign` -1 leads back.
void turn_coordinates(const joints::JointType& type, const FrameTurn& turn, int sign, VecX& q, VecX& u) {
  const Mat3 parent = sign > 0 ? turn.on(Side::parent) : Mat3(turn.on(Side::parent).transpose());
  const Mat3 child = sign > 0 ? turn.on(Side::child) : Mat3(turn.on(Side::child).transpose());
  Vec3 d = Vec3::Zero();
  Vec3 ddot = Vec3::Zero();
  const std::vector<NamedCoordinate> coordinates = named_coordinates(type);
  const auto for_each_slide = [&](const auto& use) {
    for (const NamedCoordinate& one : coordinates) {
      if (one.kind != joints::CoordinateKind::length || !one.axis) continue;
      use(index(*one.axis), first_q(type, one.word) + one.component, first_u(type, one.word) + one.component);
    }
  };
  for_each_slide([&](int axis, int at_q, int at_u) {
    d(axis) = q(at_q);
    ddot(axis) = u(at_u);
  });
  d = parent.transpose() * d;
  ddot = parent.transpose() * ddot;
  for_each_slide([&](int axis, int at_q, int at_u) {
    q(at_q) = d(axis);
    u(at_u) = ddot(axis);
  });
  for (const NamedCoordinate& one : coordinates) {
    const int at_q = first_q(type, one.word) + one.component;
    const int at_u = first_u(type, one.word) + one.component;
    switch (one.kind) {
      case joints::CoordinateKind::length:
        break;
      case joints::CoordinateKind::angle:
        if (one.axis) q(at_q) += sign * turn.shift[static_cast<std::size_t>(one.place)];
        break;
      case joints::CoordinateKind::orientation: {
        const Mat3 R = rotation_of(Vec4(q.segment<4>(at_q).normalized()));
        q.segment<4>(at_q) = euler_parameters_of(parent.transpose() * R * child);
        u.segment<3>(at_u) = parent.transpose() * u.segment<3>(at_u).eval();
        break;
      }
    }
  }
}

/// The start of a joint. Where slides mix, each keeps its role: what is not said must have its number, as started_in()
/// gives it.
void turn_start(Joint& joint, const FrameTurn& turn) {
  const joints::JointType& type = *joint.type;
  VecX q = VecX::Zero(type.n_q());
  VecX u = VecX::Zero(type.n_u());
  for (std::size_t word = 0; word < joint.start.size(); ++word) {
    const WordStart& start = joint.start[word];
    q.segment(first_q(type, static_cast<int>(word)), start.q.size()) = start.q;
    u.segment(first_u(type, static_cast<int>(word)), start.u.size()) = start.u;
  }
  turn_coordinates(type, turn, 1, q, u);
  for (std::size_t word = 0; word < joint.start.size(); ++word) {
    WordStart& start = joint.start[word];
    start.q = q.segment(first_q(type, static_cast<int>(word)), start.q.size()).eval();
    start.u = u.segment(first_u(type, static_cast<int>(word)), start.u.size()).eval();
  }
}

/// How the frames of a force element may turn.
FrameTurn turn_of(const ForceElement& element, Draw& draw) {
  const elements::EndAxes axes = end_axes_of(element);
  FrameTurn turn;
  turn.turns = axes != elements::EndAxes::fixed;
  if (!turn.turns) return turn;
  const bool about_y = axes == elements::EndAxes::about_y;
  turn.on(Side::child) = about_y ? rotation_about(Axis::y, draw.angle()) : draw.rotation();
  if (axes == elements::EndAxes::alike) turn.on(Side::parent) = turn.on(Side::child);
  if (axes == elements::EndAxes::any && ends_of(element).size() == 2) turn.on(Side::parent) = draw.rotation();
  return turn;
}

Mat6 in_turned_axes(const Mat6& matrix, const Mat3& G) {
  Mat6 B = Mat6::Zero();
  B.topLeftCorner<3, 3>() = B.bottomRightCorner<3, 3>() = G;
  const Mat6 turned = B.transpose() * matrix * B;
  return 0.5 * (turned + turned.transpose());
}

/// Tells a quantity of an element in the turned axes of its ends.
struct QuantityInTurnedAxes {
  const Mat3& G;

  template <class Quantity>
  void operator()(const Quantity& /*without axes*/) const {}
  void operator()(const elements::Vector<Vec3>& vector) const {
    if (vector.in_end_axes) vector.value = G.transpose() * vector.value;
  }
  void operator()(const elements::WrenchMatrix<Mat6>& matrix) const { matrix.value = in_turned_axes(matrix.value, G); }
  void operator()(const elements::Wrench6<Vec6>& wrench) const {
    wrench.value << G.transpose() * wrench.value.head<3>().eval(), G.transpose() * wrench.value.tail<3>().eval();
  }
};

/// Tells a force element in turned frames.
void turn_element(ForceElement& element, const FrameTurn& turn) {
  for (const Side side : kSides) {
    if (end_of(element, side) == nullptr) continue;
    Attachment& end = side == Side::parent ? ends_of(element).front() : ends_of(element).back();
    end.C = end.C * turn.on(side);
  }
  each_quantity(element, QuantityInTurnedAxes{turn.on(Side::child)});
}

/// All frames at once.
struct Turning {
  std::vector<FrameTurn> joints;
  std::vector<FrameTurn> elements;
  Model first;

  [[nodiscard]] Model apply(Model model) const {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (!joints[k].turns) continue;
      Joint& joint = model.joints[k];
      for (const Side side : kSides) {
        Attachment& at = joint.sides[static_cast<std::size_t>(index(side))];
        at.C = at.C * joints[k].on(side);
      }
      for (const NamedCoordinate& one : named_coordinates(*joint.type)) {
        const double shift = joints[k].shift[static_cast<std::size_t>(one.place)];
        if (shift != 0.0) shift_coordinate(model, static_cast<int>(k), one.word, one.component, shift);
      }
      turn_start(joint, joints[k]);
    }
    for (std::size_t e = 0; e < elements.size(); ++e) turn_element(model.elements[e], elements[e]);
    return model;
  }

  [[nodiscard]] State coordinates(State state, int sign) const {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (joints[k].turns) turn_coordinates(*first.joints[k].type, joints[k], sign, state.q[k], state.u[k]);
    }
    return state;
  }

  [[nodiscard]] Evaluation back(Evaluation evaluation) const {
    const auto turn = [](std::array<SideWrench, 2>& wrenches, const FrameTurn& by) {
      for (std::size_t side = 0; side < 2; ++side) {
        Wrench& wrench = wrenches[side].in_C;
        wrench = {by.G[side] * wrench.force, by.G[side] * wrench.torque};
      }
    };
    for (std::size_t k = 0; k < joints.size(); ++k) {
      turn(evaluation.joints[k].reaction, joints[k]);
      turn(evaluation.joints[k].total, joints[k]);
    }
    for (std::size_t e = 0; e < elements.size(); ++e) turn(evaluation.elements[e].on, elements[e]);
    return evaluation;
  }

  [[nodiscard]] RankReport flags(RankReport report) const {
    std::vector<JointUniqueness>& decided = decided_flags(report);
    for (std::size_t k = 0; k < joints.size(); ++k) {
      for (auto part : {&JointUniqueness::unique, &JointUniqueness::unique_total}) {
        for (std::size_t side = 0; side < 2; ++side) {
          turn_flags(joints[k].G[side], (report.joints[k].*part)[side], (decided[k].*part)[side]);
        }
      }
    }
    return report;
  }
};

}  // namespace

PartialChange turned_joint_frames(const Model& model, Draw& draw) {
  PartialChange partial;
  auto turning = std::make_shared<Turning>();
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    turning->joints.push_back(turn_of(model, k, draw));
    const Joint& joint = model.joints[static_cast<std::size_t>(k)];
    if (turning->joints.back().turns) {
      ++partial.changed;
    } else {
      partial.left.push_back(fmt::format("joint {}: type {} fixes its frames", joint.name, joint.type->name));
    }
  }
  for (const ForceElement& element : model.elements) {
    turning->elements.push_back(turn_of(element, draw));
    if (turning->elements.back().turns) {
      ++partial.changed;
    } else {
      partial.left.push_back(fmt::format("force element {}: its angle counts from its frames", element.name));
    }
  }
  turning->first = model;
  partial.change.model = [turning](Model first) { return turning->apply(std::move(first)); };
  partial.change.state = [turning](State state) { return turning->coordinates(std::move(state), 1); };
  partial.change.back = [turning](State state) { return turning->coordinates(std::move(state), -1); };
  partial.change.evaluation = [turning](const State&, Evaluation evaluation) {
    return turning->back(std::move(evaluation));
  };
  partial.change.report = [turning](RankReport report) { return turning->flags(std::move(report)); };
  return partial;
}

}  // namespace concord::compare::invariance
