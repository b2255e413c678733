#include "compare/sums.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "compare/digits.h"

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

PairSum compare_pair(const Model& model, const std::vector<SharedState>& states, const std::vector<int>& joints) {
  PairSum pair;
  const Joint& first = model.joints[joints.front()];
  for (const int k : joints) pair.what += (pair.what.empty() ? "" : " + ") + model.joints[k].name;
  pair.what += fmt::format(" on {}, at the point of {}", model.bodies[first.on(Side::child).body].name, first.name);
  pair.body = first.on(Side::child).body;
  const double length = model.length_scale();
  Wrench scale;
  Wrench difference;
  for (std::size_t n = 0; n < states.size(); ++n) {
    std::array<Wrench, 2> sums;
    for (int who = 0; who < 2; ++who) {
      sums[who] = sum_at_first(model, states[n].state, states[n].evaluations[who], joints, length, scale);
    }
    if (n == 0) pair.at_start = sums;
    difference.force = difference.force.cwiseMax((sums[0].force - sums[1].force).cwiseAbs());
    difference.torque = difference.torque.cwiseMax((sums[0].torque - sums[1].torque).cwiseAbs());
  }
  for (int axis = 0; axis < 3; ++axis) {
    pair.digits = std::min({pair.digits, matching_digits(difference.force(axis), scale.force(axis)),
                            matching_digits(difference.torque(axis), scale.torque(axis))});
  }
  return pair;
}

}  // namespace

std::vector<PairSum> compare_pair_sums(const Model& model, const std::vector<SharedState>& states) {
  std::vector<PairSum> sums;
  for (const auto& [pair, joints] : joints_of_pairs(model)) {
    if (joints.size() > 1) sums.push_back(compare_pair(model, states, joints));
  }
  return sums;
}

}  // namespace concord::compare
