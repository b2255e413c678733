#include "relative/run/past_rates.h"

#include <algorithm>

namespace concord::relative {

PastRates::PastRates(Eigen::Index n_numbers, Eigen::Index n_modes)
    : f(MatX::Zero(n_numbers, kMostTimes)),
      z(MatX::Zero(2 * n_modes, kMostTimes)),
      g(MatX::Zero(n_modes, kMostTimes)) {}

void PastRates::begin(const VecX& f_now, const VecX& z_now, const ModalOscillators& modes) {
  n = 1;
  ages[0] = 0.0;
  f.col(0) = f_now;
  z.col(0) = z_now;
  write_remainders(modes);
}

void PastRates::follow(const PastRates& then, double h, const VecX& f_now, const VecX& z_now,
                       const ModalOscillators& modes) {  // (R85)
  begin(f_now, z_now, modes);
  n = std::min(then.n + 1, kMostTimes);
  for (int j = 1; j < n; ++j) {
    ages[j] = h + then.ages[j - 1];
    const double rate = 1.0 / ages[j];
    f.col(j) = rate * (f.col(j - 1) - then.f.col(j - 1));
    z.col(j) = rate * (z.col(j - 1) - then.z.col(j - 1));
    g.col(j) = rate * (g.col(j - 1) - then.g.col(j - 1));
  }
}

void PastRates::write_remainders(const ModalOscillators& modes) {
  if (modes.size() == 0) return;
  for (int j = 0; j < n; ++j) modes.remainder(z.col(j), f.col(j), g.col(j));
}

}  // namespace concord::relative
