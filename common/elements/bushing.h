#pragma once

#include <array>

#include "common/elements/facts.h"

namespace concord {

/// Six springs and dampers between two frames. With d = A_j'^T (r_Pi - r_Pj), theta = log(R) (beyond 175 deg it is
/// refused, unless no stiffness or preload asks for it) and v_rel = [ddot; omega_rel], all in the parent's end frame,
/// the wrench on the child at P_i in those axes is [F; T] = -L^T (stiffness [d; theta] - preload) - damping v_rel, with
/// L = diag(1, J^-1(theta)), thetadot = J^-1 omega_rel. On the parent, at P_j: -F and -(T + d x F) (S35).
struct Bushing {
  std::array<Attachment, 2> ends;
  Mat6 stiffness = Mat6::Zero();  // symmetric; N/m, N m/rad
  Mat6 damping = Mat6::Zero();    // N s/m, N m s/rad
  Vec6 preload = Vec6::Zero();    // wrench on the child at d = 0, theta = 0

  static constexpr std::string_view kKey = "bushing";
  static constexpr elements::EndAxes kEndAxes = elements::EndAxes::alike;
  static constexpr bool kSidesAlike = false;
  template <class Self>
  static auto ends_of(Self& self) {
    return elements::Ends{self.ends.data(), 2};
  }
  template <class Self, class Visit>
  static void each_quantity(Self& self, const Visit& visit) {
    visit(elements::WrenchMatrix{"stiffness", self.stiffness, false});
    visit(elements::WrenchMatrix{"damping", self.damping, true});
    visit(elements::Wrench6{"preload", self.preload});
  }
};

}  // namespace concord
