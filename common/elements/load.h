#pragma once

#include "common/elements/facts.h"
#include "common/laws/time_function.h"

namespace concord {

/// Axes in which the components of a load are said: those of ground, of the body frame A, or of the end's own frame A',
/// which follows the body's deformation.
enum class LoadAxes { global, body, follower };

/// A force and a torque on one body at a point, both times one law of time (S32).
struct Load {
  Attachment at;
  LoadAxes axes = LoadAxes::global;
  Vec3 force = Vec3::Zero();   // N
  Vec3 torque = Vec3::Zero();  // N m
  TimeFunction law = ConstantSpeed{1.0, 0.0};

  static constexpr std::string_view kKey = "load";
  static constexpr elements::EndAxes kEndAxes = elements::EndAxes::any;
  static constexpr bool kSidesAlike = false;
  template <class Self>
  static auto ends_of(Self& self) {
    return elements::Ends{&self.at, 1};
  }
  template <class Self, class Visit>
  static void each_quantity(Self& self, const Visit& visit) {
    visit(elements::Word{"axes"});
    visit(elements::Vector{"force", self.force, elements::kForce, self.axes == LoadAxes::follower});
    visit(elements::Vector{"torque", self.torque, elements::kTorque, self.axes == LoadAxes::follower});
    visit(elements::FactorOverTime{"law", self.law});
  }
};

}  // namespace concord
