#pragma once

#include <array>

#include "common/types.h"
#include "relative/run/modal_oscillators.h"

namespace concord::relative {

/// Up to how many past times a step reaches back, the last one included.
constexpr int kMostTimes = 13;
/// Ages of past times [s], newest first: 0 = ages[0] < ages[1] < ...
using Ages = std::array<double, kMostTimes>;

/// What a multistep method knows of past times: divided differences (R85) by columns, of order 0 to n - 1.
struct PastRates {
  PastRates(Eigen::Index n_numbers, Eigen::Index n_modes);

  /// One time alone, with the rates f and modal numbers z = [a; adot] there.
  void begin(const VecX& f, const VecX& z, const ModalOscillators& modes);
  /// What `then` knows and, h later, one time more.
  void follow(const PastRates& then, double h, const VecX& f, const VecX& z, const ModalOscillators& modes);
  /// Forgets all times but the newest.
  void forget() { n = 1; }
  /// The remainders of oscillators that have changed, from the stored rates and modal numbers.
  void write_remainders(const ModalOscillators& modes);

  int n = 0;  // times
  Ages ages{};
  MatX f;  // rates
  MatX z;  // modal numbers
  MatX g;  // remainders, oscillator by oscillator
};

}  // namespace concord::relative
