#pragma once

#include <cstddef>
#include <string_view>

#include "common/attachment.h"

/// The facts that each kind of force element declares on its page: how it is called, what its ends are, and what its
/// numbers mean. Whatever only counts, names, scales, turns or bounds elements asks for them, and knows no kind.
namespace concord::elements {

/// How the axes of an element's ends may be chosen otherwise, so that it still is the same: each end as it likes, both
/// by the same turn, by turns about their own y axis, or not at all.
enum class EndAxes { any, alike, about_y, fixed };

/// The ends of an element, two or one; the child's comes last.
template <class T>
struct Ends {
  T* first;
  std::size_t count;

  [[nodiscard]] T* begin() const { return first; }
  [[nodiscard]] T* end() const { return first + count; }
  [[nodiscard]] T& front() const { return *first; }
  [[nodiscard]] T& back() const { return first[count - 1]; }
  [[nodiscard]] std::size_t size() const { return count; }
};
template <class T>
Ends(T*, std::size_t) -> Ends<T>;

/// Force to one power, times length and time to theirs.
struct Dimension {
  int force = 0;
  int length = 0;
  int time = 0;
};
inline constexpr Dimension kNoUnit{0, 0, 0};
inline constexpr Dimension kLength{0, 1, 0};
inline constexpr Dimension kSpeed{0, 1, -1};
inline constexpr Dimension kForce{1, 0, 0};
inline constexpr Dimension kTorque{1, 1, 0};
inline constexpr Dimension kForcePerLength{1, -1, 0};
inline constexpr Dimension kForcePerSpeed{1, -1, 1};

// What an element's page calls its visitor with. `name`: the key in the model file.

/// One number.
template <class T>
struct Scalar {
  std::string_view name;
  T& value;
  Dimension of;
};
template <class T>
Scalar(std::string_view, T&, Dimension) -> Scalar<T>;

/// Three components, in the axes of the child's end or in others.
template <class T>
struct Vector {
  std::string_view name;
  T& value;
  Dimension of;
  bool in_end_axes;
};
template <class T>
Vector(std::string_view, T&, Dimension, bool) -> Vector<T>;

/// A wrench [F; T] in the axes of the ends [N, N m].
template <class T>
struct Wrench6 {
  std::string_view name;
  T& value;
};
template <class T>
Wrench6(std::string_view, T&) -> Wrench6<T>;

/// What makes a wrench of a motion [d; theta], or of its rate, in the axes of the ends: 6 x 6.
template <class T>
struct WrenchMatrix {
  std::string_view name;
  T& value;
  bool per_rate;
};
template <class T>
WrenchMatrix(std::string_view, T&, bool) -> WrenchMatrix<T>;

/// A ForceLaw over a length or over an angle; its keys are those of every force law.
template <class T>
struct LawOverCoordinate {
  T& value;
  bool over_length;
};
template <class T>
LawOverCoordinate(T&, bool) -> LawOverCoordinate<T>;

/// A TimeFunction without a unit, by which the element is multiplied.
template <class T>
struct FactorOverTime {
  std::string_view name;
  T& value;
};
template <class T>
FactorOverTime(std::string_view, T&) -> FactorOverTime<T>;

/// A Road, by a shared pointer.
template <class T>
struct RoadBelow {
  std::string_view name;
  T& value;
};
template <class T>
RoadBelow(std::string_view, T&) -> RoadBelow<T>;

/// A key whose value is no number.
struct Word {
  std::string_view name;
};

/// For those who look at some kinds of quantities only.
struct IgnoreQuantity {
  template <class Quantity>
  void operator()(const Quantity& /*quantity*/) const {}
};

}  // namespace concord::elements
