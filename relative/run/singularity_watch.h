#pragma once

#include <cmath>
#include <vector>

#include "relative/start/assembly.h"

namespace concord::relative {

/// Looks between the steps of an integration for poses where closure rows, or a joint's motion, lose rank: the
/// integrator would step over them, and the motion may go on in another branch.
///
/// A singular value of the closure rows changes by no more than the rows do (Weyl). Where they change by more than the
/// two at the ends of a step, and where the smallest one falls, or has risen, so steeply that it may have been zero, it
/// is sought between them. While they have changed by less than half of the smallest one that was found, none is looked
/// for.
class SingularityWatch {
 public:
  /// All must outlive this object.
  SingularityWatch(Equations& equations, Assembly& assembly);

  /// Takes the projected state at the end of a step; the first call gives the start. Throws SingularPose if the motion
  /// has reached or passed a singular pose since the call before. A time that is not later than the last begins the
  /// step anew.
  void pass(const Coordinates& coordinates);

  /// The coordinates of the motion leave out so many more whole turns from now on (n_q numbers).
  void count_turns(const VecX& more);

 private:
  struct Record {
    Coordinates at;
    VecX qdot;
    MatX Phi;
    double sigma = 0.0;  // the smallest singular value that a general pose has, once it is found
  };

  [[nodiscard]] Record rows_at(const Coordinates& coordinates) const;
  void find_singular_value(Record& one) const;
  [[nodiscard]] double singular() const;
  [[nodiscard]] bool is_far_from_singular(const Record& now) const;
  void add(Record one);
  [[nodiscard]] Coordinates between(const Record& a, const Record& b, double part) const;
  [[nodiscard]] bool may_pass_zero(const Record& a, const Record& b) const;
  void search(const Record& a, const Record& b) const;
  [[nodiscard]] Record probe(const Record& a, const Record& b, double part) const;
  void require_branches(const VecX& before, const VecX& now, double t) const;

  Equations* equations_;
  Assembly* assembly_;
  std::vector<JointIndex> links_;  // joints whose link has two names for a pose
  std::vector<Record> last_;       // at most three, in the order of time
  std::vector<Record> since_;      // at most two later ones, near the last of these: without singular values
  VecX q_;                         // of the last call, at
  double t_ = HUGE_VAL;
  double largest_sigma_ = 0.0;  // so far
};

}  // namespace concord::relative
