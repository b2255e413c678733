#include "compare/quantities/sums.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "compare/audit/digits.h"
#include "compare/quantities/align.h"

namespace concord::compare {

namespace {

using Pair = std::pair<int, int>;

std::map<Pair, std::vector<int>> joints_of_pairs(const Model& model) {
  std::map<Pair, std::vector<int>> joints;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const int parent = model.joints[k].on(Side::parent).body;
    const int child = model.joints[k].on(Side::child).body;
    joints[std::minmax(parent, child)].push_back(static_cast<int>(k));
  }
  return joints;
}

Side side_on(const Joint& joint, int body) { return joint.on(Side::child).body == body ? Side::child : Side::parent; }

/// Sum on the child of the first joint, at its point; `scale` grows to the largest force and torque (force: N, torque:
/// N m) that enters.
Wrench sum_at_first(const Model& model, const State& state, const Evaluation& evaluation,
                    const std::vector<int>& joints, double length, Wrench& scale) {
  const Joint& first = model.joints[joints.front()];
  const int body = first.on(Side::child).body;
  const Vec3 place = joint_point(model, state, first, Side::child);
  Wrench sum;
  for (const int k : joints) {
    const Side side = side_on(model.joints[k], body);
    const Wrench& wrench = evaluation.joints[k].total_on(side).in_global;
    const Vec3 arm = joint_point(model, state, model.joints[k], side) - place;
    sum += Wrench{wrench.force, wrench.torque + arm.cross(wrench.force)};
    const double force = wrench.force.norm();
    scale.force = scale.force.cwiseMax(force);
    scale.torque = scale.torque.cwiseMax(std::max(wrench.torque.norm(), force * length));
  }
  return sum;
}

/// How well a wrench is resolved: force [N], torque [N m]; NaN where that is unknown.
struct Resolved {
  double force = 0.0;
  double torque = 0.0;
};

/// One pair of bodies, over all states.
class PairOfBodies {
 public:
  PairOfBodies(const QuantityLayout& layout, std::vector<int> joints, const std::vector<Measured>& measured,
               const Budget& budget)
      : layout_(layout), model_(layout.model()), joints_(std::move(joints)), budget_(budget) {
    const Joint& first = model_.joints[joints_.front()];
    for (const int k : joints_) pair_.what += (pair_.what.empty() ? "" : " + ") + model_.joints[k].name;
    pair_.body = first.on(Side::child).body;
    pair_.what += fmt::format(" on {}, at the point of {}", model_.bodies[pair_.body].name, first.name);
    const auto row = static_cast<std::size_t>(layout.first_row(Kind::total, joints_.front(), Side::child));
    scale_.force.setConstant(kScaleFloor * measured[row].machine);
    scale_.torque.setConstant(kScaleFloor * measured[row + 3].machine);
  }

  void add(const SharedState& shared, Eigen::Index column) {
    std::array<Wrench, 2> sums;
    for (int who = 0; who < 2; ++who) {
      sums[who] = sum_at_first(model_, shared.state, shared.evaluations[who], joints_, model_.length_scale(), scale_);
    }
    if (column == 0) pair_.at_start = sums;
    const std::optional<Resolved> resolved = resolved_in(column);
    if (!resolved) return;
    ++pair_.samples;
    take(sums[0].force - sums[1].force, resolved->force, difference_.force, unexplained_.force);
    take(sums[0].torque - sums[1].torque, resolved->torque, difference_.torque, unexplained_.torque);
  }

  [[nodiscard]] PairSum result() const {
    PairSum pair = pair_;
    pair.digits = digits_of(difference_);
    pair.unexplained_digits = digits_of(unexplained_);
    return pair;
  }

 private:
  static void take(const Vec3& difference, double resolution, Vec3& largest, Vec3& unexplained) {
    const Vec3 size = difference.cwiseAbs();
    largest = largest.cwiseMax(size);
    if (!(size.maxCoeff() <= kWithinResolution * resolution)) unexplained = unexplained.cwiseMax(size);
  }

  [[nodiscard]] double digits_of(const Wrench& difference) const {
    double digits = kMostDigits;
    for (int axis = 0; axis < 3; ++axis) {
      digits = std::min({digits, matching_digits(difference.force(axis), scale_.force(axis)),
                         matching_digits(difference.torque(axis), scale_.torque(axis))});
    }
    return digits;
  }

  /// Of the better resolved of the two bodies on which the sum must be unique; nothing if there is none.
  [[nodiscard]] std::optional<Resolved> resolved_in(Eigen::Index column) const {
    std::optional<Resolved> best;
    for (const Attachment& side : model_.joints[joints_.front()].sides) {
      if (side.body == kGround) continue;
      const std::optional<Resolved> on_body = resolved_on(side.body, column);
      if (on_body && (!best || on_body->force < best->force)) best = on_body;
    }
    return best;
  }

  [[nodiscard]] std::optional<Resolved> resolved_on(int body, Eigen::Index column) const {
    const int sum_row = layout_.first_row(Kind::body_sum, body);
    if (!is_judged(sum_row, column)) return std::nullopt;
    Resolved resolved = resolution_of(sum_row, column);
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      const auto joint = static_cast<int>(k);
      if (std::find(joints_.begin(), joints_.end(), joint) != joints_.end()) continue;
      for (const Side side : kSides) {
        if (model_.joints[k].on(side).body != body) continue;
        const int row = layout_.first_row(Kind::total, joint, side);
        if (!is_judged(row, column)) return std::nullopt;
        const Resolved of_joint = resolution_of(row, column);
        resolved.force += of_joint.force;
        resolved.torque += of_joint.torque;
      }
    }
    resolved.torque += resolved.force * model_.length_scale();  // moved to another point
    return resolved;
  }

  [[nodiscard]] bool is_judged(int row, Eigen::Index column) const {
    return budget_.judged == nullptr || budget_.judged->block(row, column, 6, 1).all();
  }

  [[nodiscard]] Resolved resolution_of(int row, Eigen::Index column) const {
    if (budget_.resolution == nullptr) {
      constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
      return {unknown, unknown};
    }
    const auto wrench = budget_.resolution->block(row, column, 6, 1);
    return {wrench.topRows(3).sum(), wrench.bottomRows(3).sum()};
  }

  const QuantityLayout& layout_;
  const Model& model_;
  std::vector<int> joints_;
  const Budget& budget_;
  PairSum pair_;
  Wrench scale_;
  Wrench difference_;
  Wrench unexplained_;
};

}  // namespace

std::vector<PairSum> compare_pair_sums(const QuantityLayout& layout, const std::vector<SharedState>& states,
                                       const std::vector<Measured>& measured, const Budget& budget) {
  std::vector<PairSum> sums;
  for (const auto& [bodies, joints] : joints_of_pairs(layout.model())) {
    if (joints.size() < 2) continue;
    PairOfBodies pair(layout, joints, measured, budget);
    for (std::size_t n = 0; n < states.size(); ++n) pair.add(states[n], static_cast<Eigen::Index>(n));
    sums.push_back(pair.result());
  }
  return sums;
}

}  // namespace concord::compare
