#pragma once

#include <array>

#include "common/elements/facts.h"
#include "common/laws/force_law.h"

namespace concord {

/// A translational spring, damper and actuator along the line between two points, x = their distance. Tension (the law
/// and the actuator) pulls each end towards the other. Below 1e-9 of the machine's length the line
/// has no direction (S33): refused where the force jumps there.
struct LineSpring {
  std::array<Attachment, 2> ends;
  ForceLaw law;

  static constexpr std::string_view kKey = "line_spring";
  static constexpr elements::EndAxes kEndAxes = elements::EndAxes::any;
  static constexpr bool kSidesAlike = true;
  template <class Self>
  static auto ends_of(Self& self) {
    return elements::Ends{self.ends.data(), 2};
  }
  template <class Self, class Visit>
  static void each_quantity(Self& self, const Visit& visit) {
    visit(elements::LawOverCoordinate{self.law, true});
  }
};

}  // namespace concord
