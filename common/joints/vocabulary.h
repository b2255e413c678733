#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/joints/coordinate.h"
#include "common/joints/functions.h"
#include "common/types.h"

/// The words in which a joint type is stated. d = A_j'^T (r_Pi - r_Pj) [m] and R = A_j'^T A_i' are the child's place
/// and orientation seen in the parent's joint frame; e_a is the unit vector of axis a.
///
/// Nothing here computes: `cartesian` evaluates what is forbidden and what reads, `relative` what is permitted. Beside
/// its definition each word declares its facts, which facts.h asks for. A new word does not compile until it declares
/// them and until the solver that reads it, and the referee, have an evaluator for it (README.md lists the places).
namespace concord::joints {

// What a joint forbids: residuals of (d, R) that vanish, each on the branch that is said here. Facts of such a word:
//   rows            number of constraint rows
//   stated_length   length [m] that the word states; zero: none
//   function        its rows as functions, if it is stated by such; else nullptr

/// d = 0: the joint points coincide. 3 rows.
struct Coincide {
  static constexpr int rows() { return 3; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
};

/// d . e_axis = 0: no gap along an axis of the parent. 1 row.
struct NoGapAlong {
  Axis axis;

  static constexpr int rows() { return 1; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
};

/// e_on_parent . (R e_on_child) = 0: a parent's axis and a child's axis stay at right angles. 1 row.
struct Perpendicular {
  Axis on_parent;
  Axis on_child;

  static constexpr int rows() { return 1; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
};

/// R e_axis = e_axis: the same axis on both sides, pointing the same way. 2 rows (the two other parent's axes . R
/// e_axis) on the branch e_axis . R e_axis > 0.
struct SameDirection {
  Axis axis;

  static constexpr int rows() { return 2; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
};

/// R = 1. 3 rows (half the axial vector of R, which is the rotation vector to first order) on the branch trace R > 1.
struct SameOrientation {
  static constexpr int rows() { return 3; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
};

/// |d| = length: the joint points keep their distance [m], which is positive. 1 row, (d . d - length^2) / (2 length).
struct KeepDistance {
  double length;

  static constexpr int rows() { return 1; }
  [[nodiscard]] constexpr double stated_length() const { return length; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
};

/// c(d, R) = 0, one row for each function. `on_branch` tells whether a placement where they vanish is one that the
/// joint means; without it all are.
struct ByResidual {
  std::shared_ptr<const FunctionOfPlacement> residual;
  bool (*on_branch)(const Placement& at) = nullptr;

  [[nodiscard]] int rows() const { return residual->n(); }
  static constexpr double stated_length() { return 0.0; }
  [[nodiscard]] const FunctionOfPlacement* function() const { return residual.get(); }
};

using Forbid =  // (S12)
    std::variant<Coincide, NoGapAlong, Perpendicular, SameDirection, SameOrientation, KeepDistance, ByResidual>;

// What a joint forbids of the velocity alone, beside what it forbids of positions: rates linear in v_rel = [ddot;
// omega_rel] (both in the parent's joint frame) that vanish, and from which no relation of positions follows. Facts:
//   rows                   number of constraint rows on velocities
//   stated_length          length [m] that the word states; zero: none
//   is_seen_from_child     whether the word names an axis of the child

/// The child's material point at d - below e_z, e_z the parent's z, does not slip over the parent along e, an axis of
/// the parent or of the child: e . (ddot + omega_rel x (-below e_z)) = 0. 1 row. A wheel or a ball of radius `below`
/// that rolls (its centre is the child's joint point), or with below = 0 the edge of a skate (S13).
struct NoSlip {
  Side axis_of;
  Axis axis;
  double below = 0.0;  // m

  static constexpr int rows() { return 1; }
  [[nodiscard]] constexpr double stated_length() const { return below; }
  [[nodiscard]] constexpr bool is_seen_from_child() const { return axis_of == Side::child; }
};

using ForbidSpeed = std::variant<NoSlip>;

// What a joint then permits of the velocity: directions that span all v_rel that are possible in a pose. Needed only
// with a ForbidSpeed; the motion below says the places that can be reached. Facts:
//   kind            of the direction's speed: an angle's [rad/s] or a length's [m/s]
//   stated_length   length [m] that the word states; zero: none

/// v_rel = [e; 0], e an axis of the parent or of the child.
struct SpeedAlong {
  Side axis_of;
  Axis axis;

  static constexpr CoordinateKind kind() { return CoordinateKind::length; }
  static constexpr double stated_length() { return 0.0; }
};

/// Rotation about e, an axis of the parent or of the child, through the point d - below e_z, which rests:
/// v_rel = [below e x e_z; e].
struct SpeedAbout {
  Side axis_of;
  Axis axis;
  double below = 0.0;  // m

  static constexpr CoordinateKind kind() { return CoordinateKind::angle; }
  [[nodiscard]] constexpr double stated_length() const { return below; }
};

using PermitSpeed = std::variant<SpeedAlong, SpeedAbout>;  // (S15)

// What a joint permits: motions, composed left to right from the parent's joint frame. A Slide moves along an axis of
// the frame reached so far, a Turn rotates that frame about its own axis. d is the place reached, R the orientation.
// Facts of such a word:
//   coordinates     those it has, with kind, name, axis and range
//   stated_length   length [m] that the word states; zero: none
//   arm             axis of the frame reached so far along which the stated length carries the child, if it does
//   function        its motion as a function, if it is stated by such; else nullptr

inline constexpr std::array<std::string_view, 3> kTurnNames{"turn_x", "turn_y", "turn_z"};
inline constexpr std::array<std::string_view, 3> kSlideNames{"slide_x", "slide_y", "slide_z"};

/// Rotation about an axis of the frame reached so far. q [rad], u = qdot.
struct Turn {
  Axis axis;

  [[nodiscard]] constexpr StatedCoordinates coordinates() const {
    return StatedCoordinates({CoordinateKind::angle, kTurnNames[index(axis)], axis});
  }
  static constexpr double stated_length() { return 0.0; }
  static constexpr std::optional<Axis> arm() { return {}; }
  static constexpr const FunctionOfCoordinates* function() { return nullptr; }
};

/// Displacement along an axis of the frame reached so far. q [m], u = qdot. Slides stand before turns, so their axes
/// are the parent's.
struct Slide {
  Axis axis;

  [[nodiscard]] constexpr StatedCoordinates coordinates() const {
    return StatedCoordinates({CoordinateKind::length, kSlideNames[index(axis)], axis});
  }
  static constexpr double stated_length() { return 0.0; }
  static constexpr std::optional<Axis> arm() { return {}; }
  static constexpr const FunctionOfCoordinates* function() { return nullptr; }
};

/// A stiff arm along an axis of the frame reached so far [m]: moves d, has no coordinate.
struct Arm {
  Axis axis;
  double length;

  static constexpr StatedCoordinates coordinates() { return {}; }
  [[nodiscard]] constexpr double stated_length() const { return length; }
  [[nodiscard]] constexpr std::optional<Axis> arm() const { return axis; }
  static constexpr const FunctionOfCoordinates* function() { return nullptr; }
};

/// Any rotation, as Euler parameters, scalar first. q has 4 numbers, u 3 [rad/s]: the child's angular velocity relative
/// to the parent, components in the parent's joint frame. Stands last. R is this rotation alone: turns that stand
/// before a ball carry arms, and so move d, but not the child's orientation.
struct Ball {
  static constexpr StatedCoordinates coordinates() { return StatedCoordinates({CoordinateKind::orientation, "ball"}); }
  static constexpr double stated_length() { return 0.0; }
  static constexpr std::optional<Axis> arm() { return {}; }
  static constexpr const FunctionOfCoordinates* function() { return nullptr; }
};

/// A motion given by functions of its coordinates; stands alone. `turns[k]` tells whether coordinate k is an angle
/// [rad] or else a length [m]; `names[k]` is what model files call it.
struct ByMotion {
  std::shared_ptr<const FunctionOfCoordinates> motion;
  std::vector<bool> turns;
  std::vector<std::string> names;
  /// Least and greatest value of each coordinate at which the joint is meant to stand, and is checked; empty: anywhere,
  /// turns several times round.
  std::vector<std::array<double, 2>> ranges = {};

  [[nodiscard]] StatedCoordinates coordinates() const {
    StatedCoordinates all;
    for (std::size_t k = 0; k < static_cast<std::size_t>(motion->n()); ++k) {
      const bool is_angle = k < turns.size() && turns[k];  // a statement that is too short is refused elsewhere
      StatedCoordinate one;
      one.kind = is_angle ? CoordinateKind::angle : CoordinateKind::length;
      if (k < names.size()) one.name = names[k];
      if (k < ranges.size()) one.range = ranges[k];
      all.add(one);
    }
    return all;
  }
  static constexpr double stated_length() { return 0.0; }
  static constexpr std::optional<Axis> arm() { return {}; }
  [[nodiscard]] const FunctionOfCoordinates* function() const { return motion.get(); }
};

using Permit = std::variant<Turn, Slide, Arm, Ball, ByMotion>;  // (S14)

// How the coordinates read from (d, R): one word for each word of the motion that has coordinates (an Arm has none), in
// the same order; a ByMotion has one ByReading of as many numbers. A turn angle is read in (-pi, pi]; whoever needs
// turns counts them. Facts of such a word:
//   kinds             of the coordinates it reads
//   pushed_by         with what they are pushed
//   is_elevation      whether it reads an angle within a right angle, beyond which the bearing before it is half a turn
//                     on: two pairs of coordinates name one place
//   function          its numbers as functions, if it is stated by such; else nullptr
//   stated_wrenches   the columns that the word states for Push::stated; else nullptr

/// Angle about `about` (an axis that the two sides share, or the yoke axis named below), right-handed, measured in the
/// parent's joint frame from its axis `of_child_axis` to the child's axis of the same name.
struct TurnOfChildAxis {
  Axis about;
  Axis of_child_axis;

  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::angle); }
  static constexpr Push pushed_by() { return Push::torque; }
  static constexpr bool is_elevation() { return false; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }
};

/// Angle about the child's axis `about`, right-handed, measured in the child's joint frame from the parent's axis
/// `of_parent_axis` to the child's axis of the same name.
struct TurnOfParentAxis {
  Axis about;
  Axis of_parent_axis;

  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::angle); }
  static constexpr Push pushed_by() { return Push::torque; }
  static constexpr bool is_elevation() { return false; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }
};

/// d . e_axis.
struct SlideAlong {
  Axis axis;

  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::length); }
  static constexpr Push pushed_by() { return Push::force; }
  static constexpr bool is_elevation() { return false; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }
};

/// The Euler parameters of R, of the sign that is nearest to the last ones known.
struct OrientationOf {
  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::orientation); }
  static constexpr Push pushed_by() { return Push::torque; }
  static constexpr bool is_elevation() { return false; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }
};

/// Angle of d seen along the parent's axis `about`, right-handed from its axis `from`: how far a turn about `about`
/// carries an arm that pointed along `from`. The two axes differ.
struct BearingOfGap {
  Axis about;
  Axis from;

  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::angle); }
  static constexpr Push pushed_by() { return Push::force; }
  static constexpr bool is_elevation() { return false; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }
};

/// Angle in [-pi/2, pi/2] by which d rises out of the plane perpendicular to the parent's axis `towards`.
struct ElevationOfGap {
  Axis towards;

  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::angle); }
  static constexpr Push pushed_by() { return Push::force; }
  static constexpr bool is_elevation() { return true; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }
};

/// Coordinates read by functions of (d, R), one number each.
struct ByReading {
  std::shared_ptr<const FunctionOfPlacement> reading;
  std::vector<bool> turns;
  /// Columns [F; T] on the child at P_i in the parent's joint frame, 6 x n, whose span holds the coordinate wrenches
  /// w_d (S^T w_d = tau): what a motor on these coordinates would exert.
  WrenchesOfPlacement wrenches = nullptr;

  [[nodiscard]] CoordinateKinds kinds() const {
    CoordinateKinds all;
    for (std::size_t k = 0; k < static_cast<std::size_t>(reading->n()); ++k) {
      all.add(k < turns.size() && turns[k] ? CoordinateKind::angle : CoordinateKind::length);
    }
    return all;
  }
  static constexpr Push pushed_by() { return Push::stated; }
  static constexpr bool is_elevation() { return false; }
  [[nodiscard]] const FunctionOfPlacement* function() const { return reading.get(); }
  [[nodiscard]] WrenchesOfPlacement stated_wrenches() const { return wrenches; }
};

using Read =  // (S16)
    std::variant<TurnOfChildAxis, TurnOfParentAxis, SlideAlong, OrientationOf, BearingOfGap, ElevationOfGap, ByReading>;

}  // namespace concord::joints
