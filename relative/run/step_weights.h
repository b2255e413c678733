#pragma once

#include <vector>

#include "common/types.h"
#include "relative/run/modal_oscillators.h"
#include "relative/run/past_rates.h"

namespace concord::relative {

/// What rates that are polynomials in time do to integrated numbers within a step. The polynomials are Newton's: with
/// tau the time since the newest past one, omega_j(tau) is the product of (tau + age_i) over i < j. Modal numbers
/// respond as oscillators do to remainders that are such polynomials (R86). All memory is laid out at construction.
class StepWeights {
 public:
  explicit StepWeights(Eigen::Index n_modes);

  /// Takes a step over `lower` <= tau <= `upper`, and polynomials 0 to `last`. Nothing is computed if these, and the
  /// oscillators, are those of the last call.
  void integrate(double lower, double upper, const Ages& ages, int last, const ModalOscillators& modes);
  /// The oscillators have changed.
  void forget() { last_ = -1; }

  /// The integral of omega_j.
  [[nodiscard]] double integral(int j) const { return integrals_(j); }
  /// omega_0 to omega_(n-1) at `upper`.
  [[nodiscard]] auto polynomials(int n) const { return polynomials_.head(n); }

  /// y at `upper` from y_lower by the polynomials through the newest n past times.
  void advance(const VecX& y_lower, const PastRates& past, int n, const ModalOscillators& modes, Eigen::Ref<VecX> y);
  /// What of y at `upper` comes from rates f and remainders g times omega_j - back omega_(j-1).
  void write_change(int j, double back, const VecX& f, const VecX& g, const ModalOscillators& modes,
                    Eigen::Ref<VecX> change);

 private:
  void add_node(double tau, double weight, const ModalOscillators& modes);
  void write_polynomials(double tau);

  double lower_ = 0.0;
  double upper_ = 0.0;
  Ages ages_{};
  int last_ = -1;
  VecX integrals_, polynomials_;
  MatX to_x_, to_v_;  // of an oscillator's place and speed, from each polynomial
  std::vector<Propagator> propagators_;
  VecX z_, x_, v_;
};

}  // namespace concord::relative
