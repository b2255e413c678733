#pragma once

#include <optional>
#include <variant>

#include "common/joints/vocabulary.h"
#include "common/types.h"

/// The facts that each word declares beside its definition in vocabulary.h, asked of any word of a statement. A new
/// word does not compile here until it declares them all.
namespace concord::joints {

/// The coordinates of one word of a motion.
inline StatedCoordinates stated_coordinates(const Permit& word) {
  return std::visit([](const auto& one) { return one.coordinates(); }, word);
}

/// The kinds of the coordinates that one reading reads.
inline CoordinateKinds kinds_of(const Read& word) {
  return std::visit([](const auto& one) { return one.kinds(); }, word);
}

/// The kind of a direction of velocities.
inline CoordinateKind kind_of(const PermitSpeed& word) {
  return std::visit([](const auto& one) { return one.kind(); }, word);
}

/// Whether a word of velocities that are forbidden names an axis of the child.
inline bool is_seen_from_child(const ForbidSpeed& word) {
  return std::visit([](const auto& one) { return one.is_seen_from_child(); }, word);
}

/// The length that a word states [m]; zero: none.
template <class... Words>
double stated_length(const std::variant<Words...>& word) {
  return std::visit([](const auto& one) { return double{one.stated_length()}; }, word);
}

/// The axis of the frame reached so far along which the stated length of a word carries the child.
inline std::optional<Axis> arm_of(const Permit& word) {
  return std::visit([](const auto& one) { return one.arm(); }, word);
}

/// The function that states a word; nullptr where it says all by itself.
template <class... Words>
auto function_of(const std::variant<Words...>& word) {
  return std::visit([](const auto& one) { return one.function(); }, word);
}

/// With what a reading's coordinates are pushed, and the columns that the word states for Push::stated.
inline Push pushed_by(const Read& word) {
  return std::visit([](const auto& one) { return one.pushed_by(); }, word);
}
inline WrenchesOfPlacement stated_wrenches(const Read& word) {
  return std::visit([](const auto& one) { return one.stated_wrenches(); }, word);
}

/// Whether a reading is an angle within a right angle, beyond which the bearing before it is half a turn on.
inline bool is_elevation(const Read& word) {
  return std::visit([](const auto& one) { return one.is_elevation(); }, word);
}

/// Numbers of q and of u of coordinates of one kind, of one word of a motion, and of one reading.
constexpr int n_q(CoordinateKind kind) { return facts_of(kind).n_q; }
constexpr int n_u(CoordinateKind kind) { return facts_of(kind).n_u; }

inline int n_q(const Permit& word) {
  int count = 0;
  for (const StatedCoordinate& one : stated_coordinates(word)) count += n_q(one.kind);
  return count;
}

inline int n_u(const Permit& word) {
  int count = 0;
  for (const StatedCoordinate& one : stated_coordinates(word)) count += n_u(one.kind);
  return count;
}

inline int n_q(const Read& word) {
  int count = 0;
  for (const CoordinateKind kind : kinds_of(word)) count += n_q(kind);
  return count;
}

inline int n_u(const Read& word) {
  int count = 0;
  for (const CoordinateKind kind : kinds_of(word)) count += n_u(kind);
  return count;
}

/// Number of constraint rows of one word.
inline int rows(const Forbid& word) {
  return std::visit([](const auto& one) { return one.rows(); }, word);
}
inline int rows(const ForbidSpeed& word) {
  return std::visit([](const auto& one) { return one.rows(); }, word);
}

/// Whether a word is an orientation, which then is its only coordinate: of several numbers, which no law can drive.
inline bool is_orientation(const Permit& word) {
  const StatedCoordinates all = stated_coordinates(word);
  return all.size() > 0 && all[0].kind == CoordinateKind::orientation;
}
inline bool is_orientation(const Read& word) {
  const CoordinateKinds all = kinds_of(word);
  return all.size() > 0 && all[0] == CoordinateKind::orientation;
}

/// The kind of the coordinate to which a number of q, or of u, of a word belongs.
inline CoordinateKind kind_of(const Permit& word, int number) {
  return is_orientation(word) ? CoordinateKind::orientation : stated_coordinates(word)[number].kind;
}

inline CoordinateKind kind_of(const Read& word, int number) {
  return is_orientation(word) ? CoordinateKind::orientation : kinds_of(word)[number];
}

/// Whether a number of q, or of u, of a word is a length [m], or its rate [m/s].
inline bool is_length(const Permit& word, int number) { return kind_of(word, number) == CoordinateKind::length; }

/// The value of q of one word where the joint has not moved.
inline VecX home_of(const Permit& word) {
  VecX q(n_q(word));
  Eigen::Index next = 0;
  for (const StatedCoordinate& one : stated_coordinates(word)) {
    const KindFacts facts = facts_of(one.kind);
    for (int k = 0; k < facts.n_q; ++k) q(next++) = facts.home[static_cast<std::size_t>(k)];
  }
  return q;
}

}  // namespace concord::joints
