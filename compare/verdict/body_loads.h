#pragma once

#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/verdict/align.h"
#include "compare/verdict/spring_terms.h"

namespace concord::compare {

/// Loads on a body in one state.
struct BodyLoad {
  double mass = 0.0;
  double least_inertia = 0.0;    // about any axis through the centre of mass, kg m2
  double largest_inertia = 0.0;  // the same
  Mat3 inertia = Mat3::Zero();   // about the centre of mass, in the body's axes
  double eccentricity = 0.0;     // distance of the centre of mass from the origin, m
  double force = 0.0;
  double torque = 0.0;  // about the body's origin
  VecX modal;           // generalized forces by mode
  VecX modal_mass;
};

/// Accelerations that the neighbours nearer to the ground carry a body with [rad/s2, m/s2]. In joint coordinates its
/// own is theirs and its joints': a ring that hangs loose on a shaft stays at rest as the difference of two large
/// numbers. Depths are those of the machine with all joints; a tree that cuts some of them may carry a body otherwise.
struct Carried {
  double turning = 0.0;
  double moving = 0.0;
};

/// Sizes of all that acts on the bodies of a machine in one state, whatever cancels of it.
class BodyLoads {
 public:
  BodyLoads(const Model& model, const SharedState& shared);

  [[nodiscard]] const BodyLoad& of(int body) const { return bodies_[body]; }
  [[nodiscard]] const SpringTerms& of_element(int element) const { return elements_[element]; }
  [[nodiscard]] const Carried& carried(int body) const { return carried_[body]; }
  /// What acts on the neighbours beyond a body is taken apart into what moves them and what their joints pass on to it:
  /// its round-off acts on the body even where a joint passes next to nothing, as a slide along which a spring pulls.
  [[nodiscard]] const SpringTerms& beyond(int body) const { return beyond_[body]; }

 private:
  void add_inertia(int i);
  void take_wrench(const Attachment& side, const Wrench& wrench);
  void add_wrenches(const Evaluation& evaluation);
  void take_terms(const Attachment& side, const SpringTerms& terms);
  void add_coordinate_forces(const Evaluation& evaluation);
  void add_springs();
  [[nodiscard]] VecX forces_on_speeds(int joint) const;
  void take_forces_on_speeds(int joint);
  void carry_on();
  void pass_on_to_ground();

  const Model& model_;
  const SharedState& shared_;
  std::vector<BodyLoad> bodies_;
  std::vector<int> depths_;
  std::vector<Carried> carried_;
  std::vector<SpringTerms> beyond_;
  std::vector<SpringTerms> springs_;  // on joints
  std::vector<SpringTerms> elements_;
  std::vector<double> driven_;  // accelerations by forces on speeds that move and turn a body [m/s2]
};

}  // namespace concord::compare
