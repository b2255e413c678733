#include "compare/resolution/orders.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "compare/audit/places.h"
#include "compare/resolution/run_pairs.h"

namespace concord::compare {

namespace {

constexpr int kKeptSamples = 41;
constexpr std::size_t kTolerances = 3;
/// Errors that fall by less than this are a matter of round-off, or of steps that the tolerance does not choose.
constexpr double kFalls = 0.5;

using Motion = std::vector<std::vector<BodyState>>;  // sample by sample

/// The largest difference of modal coordinates, or of their rates, each by the largest of its body over the run.
double error_of_modes(const Motion& one, const Motion& other, VecX BodyState::*modal) {
  double error = 0.0;
  for (std::size_t i = 1; i < other.front().size(); ++i) {
    double difference = 0.0;
    double largest = 0.0;
    for (std::size_t k = 0; k < other.size(); ++k) {
      difference = std::max(difference, (one[k][i].*modal - other[k][i].*modal).norm());
      largest = std::max(largest, (other[k][i].*modal).norm());
    }
    if (largest > 0.0) error = std::max(error, difference / largest);
  }
  return error;
}

}  // namespace

OrderStudy::OrderStudy(const QuantityLayout& layout) : layout_(layout) {
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    if (layout.quantities()[row].kind == Kind::reaction) rows_.push_back(static_cast<int>(row));
  }
}

void OrderStudy::add(const RunPair& pair) {
  if (pair.is_mixed) return;
  // Nearer to each other, the error of one would be told by a run that errs nearly as much.
  constexpr double kApart = 50.0;
  // Another integrator converges otherwise: its runs are told apart from those before.
  if (!kept_.empty() && kept_.front().integrators != pair.integrators) kept_.clear();
  const auto is_near = [&](const Kept& one) {
    return std::max(one.rtol, pair.run.rtol) < kApart * std::min(one.rtol, pair.run.rtol);
  };
  if (std::any_of(kept_.begin(), kept_.end(), is_near)) return;
  const auto is_looser = [&](const Kept& one) { return one.rtol > pair.run.rtol; };
  const auto place = std::find_if_not(kept_.begin(), kept_.end(), is_looser);
  Kept kept;
  kept.rtol = pair.run.rtol;
  kept.integrators = pair.integrators;
  const auto n = static_cast<int>(pair.series.times.size());
  const int stride = (n + kKeptSamples - 1) / kKeptSamples;
  std::vector<int> columns;
  for (int k = 0; k < n; k += stride) columns.push_back(k);
  for (std::size_t who = 0; who < 2; ++who) {
    kept.reactions[who] = pair.series.values[who](rows_, columns);
    for (const int k : columns) {
      kept.motions[who].push_back(pair.trajectories[who]->samples[static_cast<std::size_t>(k)].state.bodies);
    }
  }
  kept.scales = VecX::Zero(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t k = 0; k < rows_.size() && !pair.measured.empty(); ++k) {
    kept.scales(static_cast<Eigen::Index>(k)) = pair.measured[static_cast<std::size_t>(rows_[k])].scale;
  }
  kept_.insert(place, std::move(kept));
}

double OrderStudy::error_of_places(const Kept& one, const Kept& other, std::size_t who) const {
  const double length = layout_.model().length_scale();
  double error = error_of_modes(one.motions[who], other.motions[who], &BodyState::a);
  for (std::size_t k = 0; k < one.motions[who].size(); ++k) {
    for (std::size_t i = 1; i < layout_.model().bodies.size(); ++i) {
      const BodyState& a = one.motions[who][k][i];
      const BodyState& b = other.motions[who][k][i];
      error = std::max({error, (a.r - b.r).norm() / length, angle_between(rotation_of(a.p), rotation_of(b.p))});
    }
  }
  return error;
}

double OrderStudy::error_of_velocities(const Kept& one, const Kept& other, std::size_t who) const {
  const double length = layout_.model().length_scale();
  double error = 0.0;
  double largest = 0.0;
  for (std::size_t k = 0; k < one.motions[who].size(); ++k) {
    for (std::size_t i = 1; i < layout_.model().bodies.size(); ++i) {
      const BodyState& a = one.motions[who][k][i];
      const BodyState& b = other.motions[who][k][i];
      error = std::max({error, (a.v - b.v).norm(), length * (a.omega - b.omega).norm()});
      largest = std::max({largest, b.v.norm(), length * b.omega.norm()});
    }
  }
  const double of_modes = error_of_modes(one.motions[who], other.motions[who], &BodyState::adot);
  return std::max(of_modes, largest > 0.0 ? error / largest : 0.0);
}

std::optional<double> OrderStudy::error_of_reactions(const Kept& one, const Kept& other, std::size_t who,
                                                     const Mask& unique) const {
  std::optional<double> error;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (!(other.scales(row) > 0.0) || (unique.rows() > rows_[k] && !unique.row(rows_[k]).all())) continue;
    const double largest = (one.reactions[who].row(row) - other.reactions[who].row(row)).cwiseAbs().maxCoeff();
    error = std::max(error.value_or(0.0), largest / other.scales(row));
  }
  return error;
}

std::optional<Orders> OrderStudy::orders(const Mask& unique) const {
  if (kept_.size() < 3) return std::nullopt;
  Orders orders;
  const Kept& tightest = kept_.back();
  orders.against = tightest.rtol;
  const std::size_t last = kept_.size() - 1;
  for (std::size_t k = last - std::min(last, kTolerances); k < last; ++k) {
    const Kept& one = kept_[k];
    orders.tolerances.push_back(one.rtol);
    for (std::size_t who = 0; who < 2; ++who) {
      SolverOrders& solver = orders.solvers[who];
      solver.places.errors.push_back(error_of_places(one, tightest, who));
      solver.velocities.errors.push_back(error_of_velocities(one, tightest, who));
      if (const auto error = error_of_reactions(one, tightest, who, unique)) solver.reactions.errors.push_back(*error);
    }
  }
  for (SolverOrders& solver : orders.solvers) {
    for (ObservedOrder* order : {&solver.places, &solver.velocities, &solver.reactions}) {
      order->exponent = observed_exponent(orders.tolerances, order->errors);
    }
  }
  return orders;
}

std::optional<double> observed_exponent(const std::vector<double>& tolerances, const std::vector<double>& errors) {
  const std::size_t n = errors.size();
  if (n < 2 || n != tolerances.size() || !(errors.back() > 0.0)) return std::nullopt;
  for (std::size_t k = 1; k < n; ++k) {
    if (!(errors[k] < kFalls * errors[k - 1])) return std::nullopt;
  }
  VecX x(static_cast<Eigen::Index>(n));
  VecX y(static_cast<Eigen::Index>(n));
  for (std::size_t k = 0; k < n; ++k) {
    x(static_cast<Eigen::Index>(k)) = std::log10(tolerances[k]);
    y(static_cast<Eigen::Index>(k)) = std::log10(errors[k]);
  }
  x.array() -= x.mean();
  return x.dot(y) / x.squaredNorm();
}

std::vector<std::string> describe(const Orders& orders) {
  std::vector<std::string> sentences;
  for (std::size_t who = 0; who < 2; ++who) {
    const SolverOrders& solver = orders.solvers[who];
    std::vector<std::string> parts;
    const auto tell = [&](const char* what, const ObservedOrder& order) {
      if (order.errors.empty()) return;
      std::vector<std::string> errors;
      for (const double error : order.errors) errors.push_back(fmt::format("{:.1e}", error));
      const std::string falls =
          order.exponent ? fmt::format("rtol^{:.2f}", *order.exponent) : std::string("not in the range of convergence");
      parts.push_back(fmt::format("{} {} ({})", what, falls, fmt::join(errors, ", ")));
    };
    tell("places", solver.places);
    tell("velocities", solver.velocities);
    tell("reactions", solver.reactions);
    std::vector<std::string> tolerances;
    for (const double rtol : orders.tolerances) tolerances.push_back(fmt::format("{:g}", rtol));
    sentences.push_back(fmt::format("observed order of {}, errors at rtol {} against its own run at {:g}: {}",
                                    kSolverNames[who], fmt::join(tolerances, ", "), orders.against,
                                    fmt::join(parts, ", ")));
  }
  return sentences;
}

}  // namespace concord::compare
