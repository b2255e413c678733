#include "cartesian/run/collocation.h"

namespace concord::cartesian {

Collocation::Collocation(const Equations& equations, const Vibrations& vibrations)
    : vibrations_(vibrations),
      at_a_(vibrations_.places_in_q()),
      at_adot_(vibrations_.places_in_Y()),
      rows_(kPoints + 1, Integrals(vibrations_.size())),
      within_(vibrations_.size()),
      xi0_(VecX::Zero(vibrations_.size())),
      xidot0_(xi0_),
      xi_(xi0_),
      xidot_(xi0_) {
  const Layout& layout = equations.layout();
  y0_ = VecX::Zero(layout.n_q() + layout.n_Y() + 1);
  for (int& place : at_adot_) place += layout.n_q();
}

void Collocation::begin(const VecX& y0, double length) {
  y0_ = y0;
  xi_ = y0(at_a_);
  xidot_ = y0(at_adot_);
  xi0_.noalias() = vibrations_.inverse_E() * xi_;
  xidot0_.noalias() = vibrations_.inverse_E() * xidot_;
  if (version_ == vibrations_.version() && length == length_) return;
  length_ = length;
  version_ = vibrations_.version();
  for (int m = 0; m < kPoints; ++m) write_integrals(gauss_rule().points[m], rows_[m]);
  write_integrals(1.0, rows_[kPoints]);
}

/// The response is integrated by Gauss's rule in panels that no vibration passes in more than kPanel of its time
/// constants or radians (C58).
void Collocation::write_integrals(double x, Integrals& integrals) const {
  constexpr double kPanel = 4.0;
  const GaussRule& rule = gauss_rule();
  integrals.plain = length_ * integral_to(x);
  integrals.of_place.setZero();
  integrals.of_rate.setZero();
  const VecX& lambda = vibrations_.lambda();
  const VecX& twice_delta = vibrations_.twice_delta();
  const int panels = 2 + static_cast<int>(vibrations_.fastest() * length_ * x / kPanel);
  PointRow factors;
  for (int i = 0; lambda.size() > 0 && i < panels * kPoints; ++i) {
    const int panel = i / kPoints;
    const double at = x * (panel + rule.points[i % kPoints]) / panels;
    const double weight = length_ * x * rule.weights[i % kPoints] / panels;
    write_interpolation(rule.points.data(), kPoints, at, factors.data());
    for (Eigen::Index k = 0; k < lambda.size(); ++k) {
      const Response left = response(lambda(k), twice_delta(k), length_ * (x - at));
      integrals.of_place.row(k) += weight * left.place * factors;
      integrals.of_rate.row(k) += weight * left.rate * factors;
    }
  }
  for (Eigen::Index k = 0; k < lambda.size(); ++k) {
    const Response left = response(lambda(k), twice_delta(k), length_ * x);
    integrals.place(k) = left.place;
    integrals.rate(k) = left.rate;
  }
}

void Collocation::write_state_within(double x, const PointRates& rates, VecX& y) {
  write_integrals(x, within_);
  write_state(within_, rates, y);
}

void Collocation::write_state(const Integrals& integrals, const PointRates& rates, VecX& y) {  // (C55), (C58)
  y = y0_;
  y.noalias() += rates.ydot * integrals.plain.transpose();
  if (vibrations_.size() == 0) return;
  const auto& [plain, of_place, of_rate, place, rate] = integrals;
  xi_ = rate.cwiseProduct(xi0_) + place.cwiseProduct(vibrations_.twice_delta().cwiseProduct(xi0_) + xidot0_) +
        of_place.cwiseProduct(rates.g).rowwise().sum();
  xidot_ = rate.cwiseProduct(xidot0_) - place.cwiseProduct(vibrations_.lambda().cwiseProduct(xi0_)) +
           of_rate.cwiseProduct(rates.g).rowwise().sum();
  for (Eigen::Index k = 0; k < xi_.size(); ++k) {
    y(at_a_[k]) = vibrations_.E().row(k).dot(xi_);
    y(at_adot_[k]) = vibrations_.E().row(k).dot(xidot_);
  }
}

void Collocation::keep_rates(int m, const VecX& y, const VecX& ydot, PointRates& rates) const {
  rates.ydot.col(m) = ydot;
  for (Eigen::Index k = 0; k < vibrations_.size(); ++k) {
    rates.a(k, m) = y(at_a_[k]);
    rates.adot(k, m) = y(at_adot_[k]);
  }
  take_rest(m, rates);
}

void Collocation::take_rest(int m, PointRates& rates) const {
  const auto& inverse = vibrations_.inverse_E();
  for (Eigen::Index k = 0; k < vibrations_.size(); ++k) {
    double addot = 0.0;
    for (Eigen::Index l = 0; l < vibrations_.size(); ++l) addot += inverse(k, l) * rates.ydot(at_adot_[l], m);
    rates.g(k, m) = addot + vibrations_.twice_delta()(k) * inverse.row(k).dot(rates.adot.col(m)) +
                    vibrations_.lambda()(k) * inverse.row(k).dot(rates.a.col(m));
  }
}

void Collocation::write_change(const Eigen::Ref<const VecX>& of_ydot, const Eigen::Ref<const VecX>& of_g,
                               VecX& change) const {
  change = of_ydot;
  for (Eigen::Index k = 0; k < vibrations_.size(); ++k) {
    change(at_a_[k]) = 0.0;
    change(at_adot_[k]) = vibrations_.E().row(k).dot(of_g);
  }
}

}  // namespace concord::cartesian
