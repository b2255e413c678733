#include "relative/run/adams.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/error.h"

namespace concord::relative {

namespace {

constexpr int kHighestOrder = 12;
/// The next step is chosen for this error, in parts of the one allowed.
constexpr double kAimedError = 0.5;
/// A step of so many of the fastest oscillator's radians or decay times costs more to weigh than to make.
constexpr double kMostRadians = 200.0;
/// Each renewal evaluates twice for each mode, and each step twice.
constexpr long kStepsPerMode = 25;  // between renewals: they are a twenty-fifth of the cost

}  // namespace

Adams::Adams(IntegratedSystem& system, ModalOscillators modes, const VecX& y, Lengths lengths)
    : system_(&system),
      modes_(std::move(modes)),
      weights_(modes_.size()),
      dense_(modes_.size()),
      at_{0.0, 0.0, y, PastRates(y.size(), modes_.size())},
      before_(at_),
      candidate_(at_.y),
      z_(VecX::Zero(2 * modes_.size())),
      remainder_(VecX::Zero(modes_.size())),
      no_modes_(VecX::Zero(modes_.size())),
      h_(lengths.first),
      longest_(lengths.longest) {
  rates_ = change_ = error_ = error_weights_ = VecX::Zero(at_.y.size());
  S_ = D_ = MatX::Zero(modes_.size(), modes_.size());
  Ages equal{};
  for (int i = 0; i < kMostTimes; ++i) equal[i] = i;
  weights_.integrate(0.0, 1.0, equal, kHighestOrder, modes_);
  for (int k = 1; k <= kHighestOrder; ++k) {  // (R88)
    error_constants_[k] = std::abs(weights_.integral(k) - k * weights_.integral(k - 1));
  }
}

void Adams::begin() {
  if (!evaluate(at_.t, at_.y)) throw_failure();
  modes_.gather(at_.y, z_);
  at_.past.begin(rates_, z_, modes_);
  order_ = 1;
  begins_ = false;
  climbs_ = true;
  renew();
}

void Adams::step(double t_end) {
  constexpr int kMostFailures = 20;
  constexpr double kShorter = 0.25;
  constexpr double kFirstPart = 1e-2;  // a first step of all would not see what is the same at both ends
  constexpr double kRoundOff = 8.0 * std::numeric_limits<double>::epsilon();
  const double rest = (t_end - at_.t) - at_.beyond;
  if (rest <= kRoundOff * std::abs(t_end)) {
    at_.t = t_end;
    at_.beyond = 0.0;
    begins_ = true;
    return;
  }
  failure_ = nullptr;
  rejections_ = 0;
  if (begins_) {
    begin();
    h_ = std::min(h_, kFirstPart * rest);
  }
  system_->weigh(at_.y, error_weights_);
  h_ = std::min(h_, longest_);
  if (modes_.fastest() > 0.0) h_ = std::min(h_, kMostRadians / modes_.fastest());
  for (int failures = 0;;) {
    const double h = length_within(rest);
    if (at_.t + h == at_.t) throw_failure();
    if (try_step(h, h == rest ? std::optional(t_end) : std::nullopt)) return;
    if (error_norm_ <= 1.0) {
      if (++failures == kMostFailures) throw_failure();
      h_ = kShorter * h;
    } else {
      shorten_after(h);
    }
  }
}

/// All of the rest, or at most half of it: a last short step would leave the next ones short.
double Adams::length_within(double rest) const {
  constexpr double kNearlyAll = 0.999;
  if (h_ >= kNearlyAll * rest) return rest;
  return std::min(h_, 0.5 * rest);
}

/// Whether a step could be made, with an error that is allowed.
bool Adams::try_step(double h, std::optional<double> t_end) {
  const double t = t_end ? *t_end : at_.t + (at_.beyond + h);
  error_norm_ = 0.0;
  if (!predict_and_correct(h, t)) return false;
  if (!(error_norm_ <= 1.0)) return false;
  if (!take(h, t)) return false;
  ++steps_;
  if (t_end) {
    at_.beyond = 0.0;
    begins_ = true;
    return true;
  }
  h_ = choose_next(h);
  if (++steps_since_renewal_ >= kStepsPerMode * modes_.size()) renew();
  return true;
}

/// Leaves the corrected state in candidate_ and its error in error_norm_; false where rates are not defined.
bool Adams::predict_and_correct(double h, double t) {  // (R87), (R88)
  const int k = order_;
  const PastRates& past = at_.past;
  weights_.integrate(0.0, h, past.ages, k, modes_);
  weights_.advance(at_.y, past, k, modes_, candidate_);
  if (!evaluate(t, candidate_)) return false;
  modes_.gather(candidate_, z_);
  modes_.remainder(z_, rates_, remainder_);
  const auto omega = weights_.polynomials(k + 1);
  rates_.noalias() -= past.f.leftCols(k) * omega.head(k);
  rates_ /= omega(k);
  remainder_.noalias() -= past.g.leftCols(k) * omega.head(k);
  remainder_ /= omega(k);
  weights_.write_change(k, 0.0, rates_, remainder_, modes_, change_);
  weights_.write_change(k, h + past.ages[k - 1], rates_, remainder_, modes_, error_);
  candidate_ += change_;
  error_norm_ = norm(error_);
  return true;
}

/// Goes to the corrected state, projected; back and false where rates are not defined there.
bool Adams::take(double h, double t) {
  std::swap(at_, before_);
  const double length = before_.beyond + h;
  at_.t = t;
  at_.beyond = length - (t - before_.t);
  at_.y = candidate_;
  system_->project(at_.t, at_.y);
  if (!evaluate(at_.t, at_.y)) {
    std::swap(at_, before_);
    return false;
  }
  modes_.gather(at_.y, z_);
  at_.past.follow(before_.past, h, rates_, z_, modes_);
  last_h_ = h;
  last_order_ = order_;
  return true;
}

bool Adams::evaluate(double t, const VecX& y) {
  try {
    system_->evaluate(t, y, rates_);
    if (rates_.allFinite()) return true;
    failure_ = std::make_exception_ptr(SolverError("accelerations are not finite"));
  } catch (const SolverError&) {
    failure_ = std::current_exception();
  }
  return false;
}

void Adams::throw_failure() const {
  if (failure_) std::rethrow_exception(failure_);
  throw SolverError(
      "steps are at the round-off of time, and their errors above the tolerance still: rates jump there, or change "
      "faster than time is told: loosen the tolerance");
}

/// After an error that is too large.
void Adams::shorten_after(double h) {
  constexpr int kMostRejections = 2;  // before the past is not trusted
  constexpr double kSafety = 0.9;
  constexpr double kNoTrust = 0.1;
  climbs_ = false;
  const double best = kSafety * std::pow(kAimedError / error_norm_, 1.0 / (order_ + 1));
  if (!std::isfinite(error_norm_) || (++rejections_ > kMostRejections && order_ > 1)) {
    h_ = kNoTrust * h;
    order_ = 1;
    at_.past.forget();
  } else {
    h_ = h * (order_ > 1 ? std::clamp(best, 0.3, kSafety) : std::min(best, kSafety));
  }
  if (order_ == 1) climbs_ = true;
}

double Adams::norm(const VecX& x) const {
  return std::sqrt(x.cwiseProduct(error_weights_).squaredNorm() / static_cast<double>(x.size()));
}

/// Of the divided difference of this order, of remainders where there are modes.
double Adams::norm_of_difference(int order) {
  change_ = at_.past.f.col(order);
  remainder_ = at_.past.g.col(order);
  modes_.scatter(no_modes_, remainder_, change_);
  return norm(change_);
}

/// The order, of those next to the last, by which the next step can be the longest, and its length (R88). Lengths
/// change only by much: weights of equal steps are kept.
double Adams::choose_next(double h) {
  constexpr double kLonger = 1.2;
  constexpr double kLongest = 2.0;
  constexpr double kShorter = 0.9;
  constexpr double kShortest = 0.5;
  const int most = std::min({kHighestOrder, order_ + 1, at_.past.n - 1});
  double best = 0.0;
  int chosen = order_;
  for (int order = std::max(1, order_ - 1); order <= most; ++order) {
    const double error = error_constants_[order] * std::pow(h, order + 1) * norm_of_difference(order);
    const double factor = std::min(std::pow(kAimedError / error, 1.0 / (order + 1)), 1e3);
    if (factor <= best) continue;
    best = factor;
    chosen = order;
  }
  if (chosen < order_) climbs_ = false;
  order_ = climbs_ ? std::min({kHighestOrder, order_ + 1, at_.past.n}) : chosen;
  if (best >= kLonger) return h * std::min(best, kLongest);
  if (best < kShorter) return h * std::max(best, kShortest);
  return h;
}

/// Takes the oscillators that the machine has now; where they cannot be found, those before stay.
void Adams::renew() {
  steps_since_renewal_ = 0;
  if (modes_.size() == 0) return;
  try {
    system_->differentiate_modes(at_.t, at_.y, at_.past.f.col(0), S_, D_);
  } catch (const SolverError&) {
    return;
  }
  if (!S_.allFinite() || !D_.allFinite()) return;
  modes_.set(S_, D_);
  weights_.forget();
  dense_.forget();
  at_.past.write_remainders(modes_);
}

void Adams::interpolate(double t, Eigen::Ref<VecX> y) {  // (R89)
  const int n = std::min(last_order_ + 1, at_.past.n);
  dense_.integrate(-last_h_, (t - at_.t) - at_.beyond, at_.past.ages, n - 1, modes_);
  dense_.advance(before_.y, at_.past, n, modes_, y);
}

void Adams::step_exactly(double h) {
  std::swap(at_, before_);
  at_.past.write_remainders(modes_);
  order_ = last_order_;
  const double t = at_.t + (at_.beyond + h);
  if (!predict_and_correct(h, t) || !take(h, t)) throw_failure();
}

void Adams::restart(double h) {
  begins_ = true;
  h_ = h;
}

void Adams::rename(const VecX& y) {
  before_.y += y - at_.y;
  at_.y = y;
}

}  // namespace concord::relative
