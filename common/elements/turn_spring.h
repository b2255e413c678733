#pragma once

#include <array>

#include "common/elements/facts.h"
#include "common/laws/force_law.h"

namespace concord {

/// A rotational spring, damper and actuator between two bodies about the z axis of the parent's end frame:
/// x = the angle from the parent's x axis to the child's, seen along the parent's z (as TurnOfChildAxis{z, x} reads
/// it): in (-pi, pi] at the start, and from there on continued through whole turns. With R the child's frame in the
/// parent's, g = dx/drho (dR = rho~ R) and f the law and the actuator, the torque on the child is -f g in the parent's
/// end frame, and on the parent the opposite: pure couples, conjugate to x also where the axes z do not coincide (S34).
struct TurnSpring {
  std::array<Attachment, 2> ends;
  ForceLaw law;

  static constexpr std::string_view kKey = "turn_spring";
  static constexpr elements::EndAxes kEndAxes = elements::EndAxes::fixed;
  static constexpr bool kSidesAlike = false;
  template <class Self>
  static auto ends_of(Self& self) {
    return elements::Ends{self.ends.data(), 2};
  }
  template <class Self, class Visit>
  static void each_quantity(Self& self, const Visit& visit) {
    visit(elements::LawOverCoordinate{self.law, false});
  }
};

}  // namespace concord
