#pragma once

#include <cstddef>

#include "compare/joint_check/poses.h"
#include "compare/random_machines/laws.h"
#include "compare/random_machines/machine.h"
#include "compare/random_machines/random.h"
#include "compare/random_machines/recipe.h"

namespace concord::compare::fuzz {

/// To two significant digits.
double rounded(double value);

/// Draws bodies, joints and the ends that join them, each by itself.
class PartDrawing {
 public:
  /// All must outlive it.
  PartDrawing(const Recipe& recipe, const Units& units, Random& random)
      : recipe_(recipe), units_(units), random_(random) {}

  BodyPlan draw_body(int i);
  /// An end on body `i`, which is `body`.
  End draw_end(int i, const BodyPlan& body);
  const joints::JointType* draw_type();
  /// A joint in a regular pose, named by its number; its ends are still to be said.
  JointPlan draw_joint(const joints::JointType* type, std::size_t number);

 private:
  Vec3 draw_point();
  Vec4 draw_frame();
  void draw_inertia(BodyPlan& body);
  void make_flexible(BodyPlan& body);
  void draw_coordinates(JointPlan& joint);
  double draw_place(const joints::JointType& type, const joint_check::Coordinate& one);
  [[nodiscard]] bool is_regular(const JointPlan& joint) const;

  const Recipe& recipe_;
  const Units& units_;
  Random& random_;
};

}  // namespace concord::compare::fuzz
