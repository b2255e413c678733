#pragma once

#include <vector>

#include "common/types.h"

/// The ringing of modes, which a step integrates exactly.
namespace concord::relative {

/// What a time does to the free motion of one oscillator x'' + d x' + s x = 0: [x; x'] <- [xx xv; vx vv] [x; x'].
struct Propagator {
  double xx, xv, vx, vv;
  double change_of_xx, change_of_vv;  // less one, without cancellation
};
/// exp([0 1; -s -d] tau) in closed form (R83): of stiffnesses and dampings of any size and sign.
Propagator propagator(double s, double d, double tau);

/// Modal coordinates a and rates adot among integrated numbers y, as oscillators:
///   addot = -S a - D adot + g,
/// S and D being frozen. In the eigenvectors V of S these are single oscillators; what of D couples them there is left
/// to the remainder g (R82).
class ModalOscillators {
 public:
  /// `a`, `adot`: places in y, mode by mode; `sizes`: of modal coordinates, in which S is nearly symmetric.
  ModalOscillators(std::vector<int> a, std::vector<int> adot, VecX sizes);

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(a_.size()); }
  [[nodiscard]] const std::vector<int>& a() const { return a_; }
  [[nodiscard]] const std::vector<int>& adot() const { return adot_; }

  /// Takes S = -d(addot)/da and D = -d(addot)/d(adot). Allocates.
  void set(const MatX& S, const MatX& D);
  /// Stiffnesses [1/s2] and dampings [1/s] of the single oscillators.
  [[nodiscard]] const VecX& stiffness() const { return stiffness_; }
  [[nodiscard]] const VecX& damping() const { return damping_; }
  /// The fastest rate of all [1/s].
  [[nodiscard]] double fastest() const;

  /// V^-1 x of modal numbers x.
  void to_oscillators(const Eigen::Ref<const VecX>& modal, Eigen::Ref<VecX> single) const {
    single.noalias() = inverse_ * modal;
  }
  /// Writes z = [a; adot] of y.
  void gather(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> z) const;
  /// Writes a = V x and adot = V v into y.
  void scatter(const VecX& x, const VecX& v, Eigen::Ref<VecX> y) const;
  /// Adds z = [a; adot] to y.
  void add(const Eigen::Ref<const VecX>& z, Eigen::Ref<VecX> y) const;
  /// V^-1 g from z = [a; adot] and the rates ydot of y, or from divided differences of both.
  void remainder(const Eigen::Ref<const VecX>& z, const Eigen::Ref<const VecX>& ydot, Eigen::Ref<VecX> g) const;

 private:
  std::vector<int> a_, adot_;
  VecX sizes_;
  MatX V_, inverse_;
  VecX stiffness_, damping_;
  mutable VecX modal_, single_;
};

}  // namespace concord::relative
