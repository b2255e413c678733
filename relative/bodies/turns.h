#pragma once

/// Angles whose whole turns are counted apart. A turn is known in more digits than an angle has, so that adding and
/// taking off many of them loses none of the angle's.
namespace concord::relative {

inline constexpr long double kWholeTurn = 6.283185307179586476925286766559L;

/// q + 2 pi turns [rad] as a double; `rest` gets what that rounds off.
inline double add_turns(double q, double turns, double& rest) {
  rest = 0.0;
  if (turns == 0.0) return q;
  const long double value = q + kWholeTurn * turns;
  const auto rounded = static_cast<double>(value);
  rest = static_cast<double>(value - rounded);
  return rounded;
}

inline double add_turns(double q, double turns) {
  double rest = 0.0;
  return add_turns(q, turns, rest);
}

}  // namespace concord::relative
