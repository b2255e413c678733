#pragma once

#include <optional>
#include <variant>

#include "common/joints/vocabulary.h"
#include "common/types.h"

/// The facts that each word declares beside its definition in vocabulary.h, asked of any word of a statement. A new
/// word does not compile in facts.cpp until it declares them all.
namespace concord::joints {

/// The coordinates of one word of a motion.
StatedCoordinates stated_coordinates(const Permit& word);

/// The kinds of the coordinates that one reading reads.
CoordinateKinds kinds_of(const Read& word);

/// The kind of a direction of velocities.
CoordinateKind kind_of(const PermitSpeed& word);

/// Whether a word of velocities that are forbidden names an axis of the child.
bool is_seen_from_child(const ForbidSpeed& word);

/// The length that a word states [m]; zero: none.
template <class... Words>
double stated_length(const std::variant<Words...>& word) {
  return std::visit([](const auto& one) { return double{one.stated_length()}; }, word);
}

/// The axis of the frame reached so far along which the stated length of a word carries the child.
std::optional<Axis> arm_of(const Permit& word);

/// The function that states a word; nullptr where it says all by itself.
template <class... Words>
auto function_of(const std::variant<Words...>& word) {
  return std::visit([](const auto& one) { return one.function(); }, word);
}

/// With what a reading's coordinates are pushed, and the columns that the word states for Push::stated.
Push pushed_by(const Read& word);
WrenchesOfPlacement stated_wrenches(const Read& word);

/// Whether a reading is an angle within a right angle, beyond which the bearing before it is half a turn on.
bool is_elevation(const Read& word);

/// Numbers of q and of u of coordinates of one kind, of one word of a motion, and of one reading.
constexpr int n_q(CoordinateKind kind) { return facts_of(kind).n_q; }
constexpr int n_u(CoordinateKind kind) { return facts_of(kind).n_u; }

int n_q(const Permit& word);
int n_u(const Permit& word);
int n_q(const Read& word);
int n_u(const Read& word);

/// Number of constraint rows of one word.
int rows(const Forbid& word);
int rows(const ForbidSpeed& word);

/// Whether a word is an orientation, which then is its only coordinate: of several numbers, which no law can drive.
bool is_orientation(const Permit& word);
bool is_orientation(const Read& word);

/// The kind of the coordinate to which a number of q, or of u, of a word belongs.
CoordinateKind kind_of(const Permit& word, int number);
CoordinateKind kind_of(const Read& word, int number);

/// Whether a number of q, or of u, of a word is a length [m], or its rate [m/s].
bool is_length(const Permit& word, int number);

/// The value of q of one word where the joint has not moved.
VecX home_of(const Permit& word);

}  // namespace concord::joints
