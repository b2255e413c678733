#include "common/growth_watch.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace concord {

namespace {

/// Of the body's own size, or of the machine's length if that is larger (a small body may be a mass that one mode
/// carries far): beyond the small deflections that modes stand for.
constexpr double kMostDeflection = 10.0;
/// Of the machine's length: six digits are left there for what is between bodies.
constexpr double kFar = 1e10;
/// In twice the time. A steady flight comes twice as far, a steady push brings it four times as far.
constexpr double kPushedAway = 1e4;
/// What is above this part of its limit has begun to grow.
constexpr double kLarge = 0.01;

/// The diagonal of the box in body axes that holds all mass points and nodes of a flexible body [m].
double size_of(const ModalData& modal) {
  Eigen::AlignedBox3d box;
  for (const MassPoint& point : modal.mass_points) box.extend(point.s0_L);
  for (const ModalNode& node : modal.nodes) box.extend(node.s0_L);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

}  // namespace

double GrowthWatch::Watched::follow(double amount, double t) {
  const double part = per_unit * std::abs(amount);
  const bool was_large = is_large;
  is_large = part > kLarge;
  if (is_large && !was_large) since = t;
  return part;
}

GrowthWatch::GrowthWatch(const Model& model, const State& start)
    : model_(model), length_(model.length_scale()), bodies_(model.bodies.size()) {
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    WatchedBody& body = bodies_[i];
    body.start = start.bodies[i].r;
    if (!model.bodies[i].modal) continue;
    const ModalData& modal = *model.bodies[i].modal;
    body.size = size_of(modal);
    for (const double deflection : largest_displacements(modal)) {
      Watched mode;
      mode.per_unit = deflection / (kMostDeflection * std::max(body.size, length_));
      body.modes.push_back(mode);
    }
  }
}

void GrowthWatch::follow(const State& state, std::string_view solver) {
  times_.push_back(state.t);
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    WatchedBody& body = bodies_[i];
    for (std::size_t k = 0; k < body.modes.size(); ++k) {
      const double part = body.modes[k].follow(state.bodies[i].a(static_cast<Eigen::Index>(k)), state.t);
      if (part <= 1.0) continue;
      const bool is_own = body.size >= length_;
      throw SolverError(
          fmt::format("{}: at t = {:.6g} s the motion of the model has grown without bound: mode a_{} deflects body "
                      "'{}' by {:.3g} times {} ({:.3g} m), and by more than a tenth of that since t = {:.6g} s, "
                      "where modes stand for small deflections: end the run before that, or see what should hold the "
                      "body (no model has geometric stiffness)",
                      solver, state.t, k + 1, model_.bodies[i].name, kMostDeflection * part,
                      is_own ? "its size" : "the machine's length", std::max(body.size, length_), body.modes[k].since));
    }
    follow_place(i, state, solver);
  }
}

void GrowthWatch::follow_place(std::size_t i, const State& state, std::string_view solver) {
  std::vector<double>& farthest = bodies_[i].farthest;
  const double distance = (state.bodies[i].r - bodies_[i].start).norm();
  farthest.push_back(farthest.empty() ? distance : std::max(farthest.back(), distance));
  if (distance <= kFar * length_) return;
  const auto half = std::upper_bound(times_.begin(), times_.end(), 0.5 * state.t) - times_.begin();
  const double before = half > 0 ? farthest[static_cast<std::size_t>(half - 1)] : 0.0;
  if (before <= 0.0 || distance <= kPushedAway * before) return;
  throw SolverError(
      fmt::format("{}: at t = {:.6g} s the motion of the model has grown without bound: body '{}' stands {:.3g} m "
                  "from its start, {:.3g} lengths of the machine, after at most {:.3g} m until t = {:.6g} s: end the "
                  "run before that, or see what pushes the body away",
                  solver, state.t, model_.bodies[i].name, distance, distance / length_, before,
                  times_[static_cast<std::size_t>(half - 1)]));
}

}  // namespace concord
