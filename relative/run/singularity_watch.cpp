#include "relative/run/singularity_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

/// But a machine whose rows always depend that nearly is not singular: it must fall to this part of what it is at an
/// end of the step.
constexpr double kFallen = 0.01;
/// A singular value that falls this many times as steeply as at the end of a step may reach zero within it.
constexpr double kSteeper = 3.0;
constexpr int kMostProbes = 60;
constexpr double kGoldenSection = 0.3819660112501051;

bool is_certainly_regular(double sigma_a, double sigma_b, const MatX& Phi_a, const MatX& Phi_b) {  // (R71)
  return (Phi_a - Phi_b).norm() < sigma_a + sigma_b;
}

}  // namespace

SingularityWatch::SingularityWatch(Equations& equations, Assembly& assembly)
    : equations_(&equations), assembly_(&assembly) {
  for (const JointIndex k : upward<JointIndex>(equations.model().joints.size())) {
    if (equations.kinematics().mobilizer(k).has_elevation()) links_.push_back(k);
  }
}

SingularityWatch::Record SingularityWatch::rows_at(const Coordinates& coordinates) const {
  Record found{coordinates, VecX::Zero(equations_->topology().n_q), {}, 0.0};
  const ScaledClosure& scaled = assembly_->scaled();
  scaled.move(found.at);
  found.Phi = scaled.rows(scaled.free_columns());
  equations_->compute_qdot(equations_->motion(), found.qdot);
  return found;
}

void SingularityWatch::find_singular_value(Record& one) const {
  assembly_->scaled().move(one.at);
  one.sigma = assembly_->closure_rank().singular_value(one.Phi);
}

/// Cubic in each coordinate, closed there (R72).
Coordinates SingularityWatch::between(const Record& a, const Record& b, double part) const {
  const double h = b.at.t - a.at.t;
  const double s = part;
  const double value_a = (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s);
  const double value_b = s * s * (3.0 - 2.0 * s);
  Coordinates found = a.at;
  found.t = a.at.t + s * h;
  found.q = value_a * a.at.q + value_b * b.at.q + h * s * (1.0 - s) * ((1.0 - s) * a.qdot - s * b.qdot);
  found.u = (1.0 - s) * a.at.u + s * b.at.u;
  return found;
}

bool SingularityWatch::may_pass_zero(const Record& a, const Record& b) const {
  if (is_certainly_regular(a.sigma, b.sigma, a.Phi, b.Phi)) return false;
  const double h = b.at.t - a.at.t;
  const Record* before = nullptr;
  const Record* after = nullptr;
  for (const Record& one : last_) {
    if (one.at.t < a.at.t) before = &one;
    if (one.at.t > b.at.t) after = &one;
  }
  if (before == nullptr && after == nullptr) return true;
  if (before != nullptr) {
    const double rate = (a.sigma - before->sigma) / (a.at.t - before->at.t);
    if (a.sigma + kSteeper * rate * h <= 0.0) return true;
  }
  if (after != nullptr) {
    const double rate = (after->sigma - b.sigma) / (after->at.t - b.at.t);
    if (b.sigma - kSteeper * rate * h <= 0.0) return true;
  }
  return false;
}

SingularityWatch::Record SingularityWatch::probe(const Record& a, const Record& b, double part) const {
  Coordinates coordinates = between(a, b, part);
  if (assembly_->close_positions_nearby(coordinates)) {
    Record found = rows_at(coordinates);
    find_singular_value(found);
    return found;
  }
  Record lost;  // a pose that does not close counts as singular
  lost.at = coordinates;
  return lost;
}

/// The least singular value of a step, by golden sections, until it is zero or certainly is not.
void SingularityWatch::search(const Record& a, const Record& b) const {
  const auto is_regular = [](const Record& from, const Record& to) {
    return is_certainly_regular(from.sigma, to.sigma, from.Phi, to.Phi);
  };
  Record low = a;
  Record high = b;
  double part_low = 0.0;
  double part_high = 1.0;
  double part = kGoldenSection;
  const double singular = std::min(kBesideSingular, kFallen * std::max(a.sigma, b.sigma));
  Record inner = probe(a, b, part);
  for (int count = 0; count < kMostProbes; ++count) {
    if (inner.sigma <= singular) assembly_->closure_rank().throw_singular(inner.at, "reach or pass a pose where they ");
    const bool is_low_regular = is_regular(low, inner);
    const bool is_high_regular = is_regular(inner, high);
    if (is_low_regular && is_high_regular) return;
    const bool probes_low = !is_low_regular && (is_high_regular || part - part_low > part_high - part);
    double part_next = part + kGoldenSection * ((probes_low ? part_low : part_high) - part);
    Record next = probe(a, b, part_next);
    if (next.sigma < inner.sigma) {  // the probe is the new middle, and the old one an end on its other side
      std::swap(next, inner);
      std::swap(part_next, part);
      (probes_low ? high : low) = std::move(next);
      (probes_low ? part_high : part_low) = part_next;
    } else {
      (probes_low ? low : high) = std::move(next);
      (probes_low ? part_low : part_high) = part_next;
    }
  }
}

/// A link passes between the two names of its poses only where its motion loses rank.
void SingularityWatch::require_branches(const VecX& before, const VecX& now, double t) const {
  for (const JointIndex k : links_) {
    const Mobilizer& mobilizer = equations_->kinematics().mobilizer(k);
    const int first = equations_->topology().joints[k].first_q;
    if (mobilizer.is_on_branch_of(now.data() + first, before.data() + first)) continue;
    throw SingularPose(fmt::format(
        "relative: at t = {:.6g} s joint '{}' passes a pose where two of its motions are one, its link along the axis "
        "of its first turn: turn its frame on the parent, so that the machine stays away from there",
        t, equations_->model().joints[k].name));
  }
}

void SingularityWatch::count_turns(const VecX& more) {
  const VecX angles = static_cast<double>(kWholeTurn) * more;
  for (std::vector<Record>* records : {&last_, &since_}) {
    for (Record& one : *records) one.at.q -= angles;
  }
  if (q_.size() > 0) q_ -= angles;
}

void SingularityWatch::pass(const Coordinates& coordinates) {
  if (!links_.empty()) {
    if (t_ < coordinates.t) require_branches(q_, coordinates.q, coordinates.t);
    q_ = coordinates.q;
    t_ = coordinates.t;
  }
  if (equations_->closure().n_rows() == 0) return;
  const auto begin_anew = [&](std::vector<Record>& records) {
    while (!records.empty() && records.back().at.t >= coordinates.t) records.pop_back();
  };
  begin_anew(since_);
  begin_anew(last_);
  Record now = rows_at(coordinates);
  if (is_far_from_singular(now)) {
    if (since_.size() == 2) since_.erase(since_.begin());
    since_.push_back(std::move(now));
    return;
  }
  if (!since_.empty()) add(std::move(since_.back()));
  since_.clear();
  add(std::move(now));
  largest_sigma_ = std::max(largest_sigma_, last_.back().sigma);
  if (last_.back().sigma <= singular()) assembly_->closure_rank().throw_singular(coordinates, "");
  const std::size_t n = last_.size();
  if (n >= 2 && may_pass_zero(last_[n - 2], last_[n - 1])) search(last_[n - 2], last_[n - 1]);
  if (n == 3 && may_pass_zero(last_[0], last_[1])) search(last_[0], last_[1]);
}

/// Singular values up to this one are.
double SingularityWatch::singular() const { return std::min(kBesideSingular, kFallen * largest_sigma_); }

/// The smallest singular value is at least what the last one that was found is more than the rows have changed since,
/// so that no step within half of it can pass zero by (R71).
bool SingularityWatch::is_far_from_singular(const Record& now) const {
  if (last_.empty()) return false;
  const double half = 0.5 * last_.back().sigma;
  return half > singular() && (now.Phi - last_.back().Phi).norm() < half;
}

void SingularityWatch::add(Record one) {
  find_singular_value(one);
  last_.push_back(std::move(one));
  if (last_.size() > 3) last_.erase(last_.begin());
}

}  // namespace concord::relative
