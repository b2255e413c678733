#include "tests/read_back/expected.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "compare/audit/carried_components.h"

namespace concord::read_back {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

const Wrench& wrench_of(const Sample& sample, Which which, Axes axes, std::size_t joint, std::size_t side) {
  const JointWrenches& wrenches = sample.evaluation.joints.at(joint);
  const SideWrench& on = which == Which::reaction ? wrenches.reaction.at(side) : wrenches.total.at(side);
  return axes == Axes::joint ? on.in_C : on.in_global;
}

/// From the frame of a joint's side to global axes: the body's orientation, then the small turn of its modes, then C.
Mat3 frame_of(const Attachment& side, const State& state) {
  const BodyState& body = state.bodies.at(static_cast<std::size_t>(side.body));
  const Eigen::Quaterniond turned(body.p(0), body.p(1), body.p(2), body.p(3));
  Mat3 A = turned.toRotationMatrix();
  if (side.Psi_r_L.cols() > 0) {
    const Vec3 theta = side.Psi_r_L * body.a;
    if (theta.norm() > 0.0) A = A * Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix();
  }
  return A * side.C;
}

/// How many couplings act on each speed of a joint.
std::vector<int> couplings_of(const Model& model, std::size_t k) {
  std::vector<int> count(static_cast<std::size_t>(model.joints[k].type->n_u()), 0);
  for (const Coupling& coupling : model.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      if (term.joint != static_cast<int>(k)) continue;
      ++count.at(static_cast<std::size_t>(first_u(*model.joints[k].type, term.word) + term.component));
    }
  }
  return count;
}

}  // namespace

JointUnits units_of(const Joint& joint) {
  JointUnits units;
  const auto add = [](std::vector<std::string>& list, const char* unit, int count) {
    for (int k = 0; k < count; ++k) list.emplace_back(unit);
  };
  for (const joints::Permit& word : joint.type->permits) {
    for (const joints::StatedCoordinate& one : stated_coordinates(word)) {
      const bool is_length = one.kind == joints::CoordinateKind::length;
      const bool is_ball = one.kind == joints::CoordinateKind::orientation;
      add(units.q, is_ball ? "1" : is_length ? "m" : "rad", is_ball ? 4 : 1);
      add(units.u, is_length ? "m/s" : "rad/s", is_ball ? 3 : 1);
      add(units.tau, is_length ? "N" : "N m", is_ball ? 3 : 1);
    }
  }
  return units;
}

std::vector<std::array<bool, 4>> actors_of(const Joint& joint) {
  std::vector<std::array<bool, 4>> actors(static_cast<std::size_t>(joint.type->n_u()), std::array<bool, 4>{});
  const auto at = [&](const auto& one) -> std::array<bool, 4>& {
    return actors.at(static_cast<std::size_t>(first_u(*joint.type, one.word) + one.component));
  };
  for (const Driver& driver : joint.drivers) at(driver)[0] = true;
  for (const JointSpring& spring : joint.springs) {
    const ForceLaw& law = spring.law;
    std::array<bool, 4>& there = at(spring);
    there[1] = there[1] || law.actuator;
    there[2] = there[2] || law.stiffness != 0.0 || law.preload != 0.0 || law.spring_table || law.lower || law.upper;
    there[3] = there[3] || law.damping != 0.0 || law.damper_table || (law.lower && law.lower->damping != 0.0) ||
               (law.upper && law.upper->damping != 0.0);
  }
  return actors;
}

bool has_end(const ForceElement& element, std::size_t side) {
  return side == 1 || (!std::holds_alternative<Load>(element.what) && !std::holds_alternative<Tire>(element.what));
}

/// The comparator lists reactions, reactions in global axes and totals, twelve numbers for each joint; then the forces
/// on joint speeds on which something acts, what each of several actors exerts of them, then couplings.
Expected::Expected(const Run& run) : run_(run) {
  const std::size_t n = run.model.joints.size();
  std::size_t row = 36 * n;
  for (std::size_t k = 0; k < n; ++k) {
    const std::vector<int> couplings = couplings_of(run.model, k);
    const std::vector<std::array<bool, 4>> actors = actors_of(run.model.joints[k]);
    tau_rows_.emplace_back();
    share_rows_.emplace_back(couplings.size(), std::array<int, 4>{-1, -1, -1, -1});
    for (std::size_t speed = 0; speed < couplings.size(); ++speed) {
      const auto count = couplings[speed] + std::count(actors[speed].begin(), actors[speed].end(), true);
      tau_rows_.back().push_back(count > 0 ? static_cast<int>(row++) : -1);
      if (count < 2) share_rows_.back()[speed].fill(tau_rows_.back().back());
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    const std::vector<int> couplings = couplings_of(run.model, k);
    const std::vector<std::array<bool, 4>> actors = actors_of(run.model.joints[k]);
    for (std::size_t speed = 0; speed < couplings.size(); ++speed) {
      if (couplings[speed] + std::count(actors[speed].begin(), actors[speed].end(), true) < 2) continue;
      for (std::size_t actor = 0; actor < 4; ++actor) {
        if (actors[speed][actor]) share_rows_[k][speed][actor] = static_cast<int>(row++);
      }
    }
  }
  first_coupling_ = row;
}

double Expected::own(Which which, Axes axes, std::size_t k, std::size_t joint, std::size_t side,
                     std::size_t component) const {
  const Wrench& wrench = wrench_of(sample(k), which, axes, joint, side);
  return component < 3 ? wrench.force(static_cast<int>(component)) : wrench.torque(static_cast<int>(component) - 3);
}

bool Expected::flag(std::size_t row, std::size_t k) const {
  return run_.unique == nullptr || (*run_.unique)(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k));
}

bool Expected::may_be_open(Which which, std::size_t joint, std::size_t side, std::size_t component) const {
  const Side on = side == 1 ? Side::child : Side::parent;
  const bool is_carried = compare::carries(*run_.model.joints[joint].type, on, static_cast<int>(component));
  const std::vector<int>& rows = tau_rows_[joint];
  const bool is_forced = std::any_of(rows.begin(), rows.end(), [](int row) { return row >= 0; });
  return is_carried || (which == Which::total && is_forced);
}

bool Expected::is_unique(Which which, std::size_t k, std::size_t joint, std::size_t side, std::size_t component) const {
  const std::size_t first = which == Which::reaction ? 0 : 24 * run_.model.joints.size();
  return flag(first + 12 * joint + 6 * side + component, k) || !may_be_open(which, joint, side, component);
}

double Expected::known(Which which, Axes axes, std::size_t k, std::size_t joint, std::size_t side,
                       std::size_t component) const {
  const double number = own(which, axes, k, joint, side, component);
  if (run_.unique == nullptr) return number;
  if (axes == Axes::joint) return is_unique(which, k, joint, side, component) ? number : kNone;
  const std::size_t first = component / 3 * 3;
  std::array<bool, 3> is_open{};
  for (std::size_t c = 0; c < 3; ++c) is_open[c] = !is_unique(which, k, joint, side, first + c);
  if (is_open == std::array<bool, 3>{}) return number;
  const Mat3 A = frame_of(run_.model.joints[joint].sides.at(side), sample(k).state);
  for (std::size_t c = 0; c < 3; ++c) {
    constexpr double kRoundOff = 1e-12;
    const double part = A(static_cast<int>(component - first), static_cast<int>(c));
    if (is_open[c] && std::abs(part) > kRoundOff) return kNone;
  }
  return number;
}

double Expected::known_tau(std::size_t k, std::size_t joint, std::size_t speed) const {
  const int row = tau_rows_[joint].at(speed);
  if (row >= 0 && !flag(static_cast<std::size_t>(row), k)) return kNone;
  return sample(k).evaluation.joints.at(joint).tau(static_cast<int>(speed));
}

double Expected::known_share(std::size_t k, std::size_t joint, std::size_t speed, std::size_t actor) const {
  const int row = share_rows_[joint].at(speed)[actor];
  if (row >= 0 && actors_of(run_.model.joints[joint])[speed][actor] && !flag(static_cast<std::size_t>(row), k)) {
    return kNone;
  }
  return sample(k).evaluation.joints.at(joint).shares[actor](static_cast<int>(speed));
}

double Expected::known_coupling(std::size_t k, std::size_t coupling) const {
  return flag(first_coupling_ + coupling, k) ? sample(k).evaluation.couplings.at(coupling) : kNone;
}

bool is_same(double one, double other) { return one == other || (std::isnan(one) && std::isnan(other)); }

void Complaints::add(const std::string& what) {
  constexpr std::size_t kTold = 5;
  if (told_.size() < kTold) {
    told_.push_back(fmt::format("{}: {}", file_, what));
  } else {
    ++more_;
  }
}

std::vector<std::string> Complaints::all() const {
  std::vector<std::string> all = told_;
  if (more_ > 0) all.push_back(fmt::format("{}: and {} more", file_, more_));
  return all;
}

}  // namespace concord::read_back
