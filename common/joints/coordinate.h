#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "common/types.h"

/// Facts of joint coordinates, which each word of the vocabulary declares beside its definition. Whoever needs no more
/// than these asks for them (facts.h) and does not tell words apart.
namespace concord::joints {

/// What the numbers of one coordinate are.
enum class CoordinateKind {
  angle,        // one number q, u = qdot
  length,       // one number q, u = qdot
  orientation,  // q four Euler parameters, scalar first; u the three components of the relative angular velocity
};

/// Counts of numbers, their units and the value at rest of a kind of coordinate.
struct KindFacts {
  int n_q;
  int n_u;
  const char* unit_of_q;
  const char* unit_of_u;
  const char* unit_of_tau;     // of the force that a driver exerts on it
  std::array<double, 4> home;  // the first n_q are q of the unmoved joint
};

constexpr KindFacts facts_of(CoordinateKind kind) {
  KindFacts facts{};
  switch (kind) {
    case CoordinateKind::angle:
      facts = {1, 1, "rad", "rad/s", "N m", {0.0}};
      break;
    case CoordinateKind::length:
      facts = {1, 1, "m", "m/s", "N", {0.0}};
      break;
    case CoordinateKind::orientation:
      facts = {4, 3, "1", "rad/s", "N m", {1.0, 0.0, 0.0, 0.0}};
      break;
  }
  return facts;
}

/// One coordinate of a motion, as its word declares it. An orientation stands alone in its word.
struct StatedCoordinate {
  CoordinateKind kind{};
  std::string_view name;  // what model files call it; lives as long as the word
  /// The axis of the frame reached so far about which the coordinate turns that frame, or along which it moves it,
  /// and does nothing else, so that whole turns of it change no pose. None of an orientation and of functions.
  std::optional<Axis> axis = {};
  /// Least and greatest value at which the joint is meant to stand; none: anywhere.
  std::optional<std::array<double, 2>> range = {};
};

/// At most six of a kind, without heap memory.
template <class T>
class ShortList {
 public:
  constexpr ShortList() = default;
  constexpr explicit ShortList(const T& only) : items_{only}, size_(1) {}

  constexpr void add(const T& item) { items_.at(static_cast<std::size_t>(size_++)) = item; }
  [[nodiscard]] constexpr int size() const { return size_; }
  [[nodiscard]] constexpr const T& operator[](int k) const { return items_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] constexpr const T* begin() const { return items_.data(); }
  [[nodiscard]] constexpr const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, 6> items_{};
  int size_ = 0;
};

using StatedCoordinates = ShortList<StatedCoordinate>;
using CoordinateKinds = ShortList<CoordinateKind>;

/// With what a reading's coordinate is pushed: a force where it reads the gap d, a torque where it reads the
/// orientation, or the wrenches that the word itself states.
enum class Push { force, torque, stated };

}  // namespace concord::joints
