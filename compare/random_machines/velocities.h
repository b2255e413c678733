#pragma once

#include <vector>

#include "compare/random_machines/machine.h"

/// Poses and velocities of a machine that is being drawn, as the joint check's referee says what a joint permits.
namespace concord::compare::fuzz {

using Motion = joints::FunctionOfCoordinates::Motion;

/// Place of a joint's frame on a side in the global frame.
Pose frame_of(const End& end, const Pose& body);

/// The motion of a joint of its own type at the coordinates and speeds that were drawn.
Motion motion_of(const JointPlan& joint, const joints::JointType& type);

/// The body that the joint carries in the tree stands on this side.
Side outer_side(const JointPlan& joint, int body);

/// Appends rows of equal length.
void append_rows(MatX& rows, const MatX& more);

/// The velocity level of a machine in its pose: a column for each joint speed, scaled so that turns and slides compare.
class Velocities {
 public:
  /// Machine and poses must outlive it.
  Velocities(const Machine& machine, const std::vector<Pose>& poses);

  [[nodiscard]] int n() const { return n_; }
  [[nodiscard]] int first(int joint) const { return first_[joint]; }
  /// What one unit of a scaled column is: m/s or rad/s.
  [[nodiscard]] double scale(int column) const { return scale_(column); }

  /// The loops: v_rel of the bodies is what the joint permits.
  [[nodiscard]] MatX loops() const;

  /// What must not slip.
  [[nodiscard]] MatX slips() const;

 private:
  /// v and omega of a body's origin, 3 rows each.
  struct Speeds {
    MatX v;
    MatX omega;
  };

  void find_scales();
  void move_tree();
  [[nodiscard]] MatX at_point(const Speeds& body, const Vec3& arm) const;
  [[nodiscard]] Speeds permitted(int k, const Motion& motion, const Mat3& A_joint) const;
  [[nodiscard]] MatX loop_rows(int k) const;

  const Machine& machine_;
  const std::vector<Pose>& poses_;
  std::vector<joints::JointType> types_;
  std::vector<int> first_;
  int n_ = 0;
  VecX scale_;
  std::vector<Speeds> bodies_;
};

}  // namespace concord::compare::fuzz
