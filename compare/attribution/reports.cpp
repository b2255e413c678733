#include "compare/attribution/reports.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace concord::compare {

namespace {

constexpr double kAlike = 1e-9;  // of the largest in all states

/// Largest difference between two solvers and largest size, over all states; a size is at least `floor`.
struct Spread {
  double difference = 0.0;
  double size = 0.0;

  void take(const VecX& one, const VecX& other) {
    difference = std::max(difference, (one - other).norm());
    size = std::max({size, one.norm(), other.norm()});
  }
  [[nodiscard]] bool is_alike(double floor = 0.0) const { return difference <= kAlike * std::max(size, floor); }
};

/// One wrench of a joint in all states, as both solvers give it.
using Reader = const Wrench& (*)(const JointWrenches&, Side);

const Wrench& total_in_global(const JointWrenches& joint, Side side) { return joint.total_on(side).in_global; }
const Wrench& reaction_in_global(const JointWrenches& joint, Side side) { return joint.reaction_on(side).in_global; }
const Wrench& total_in_frame(const JointWrenches& joint, Side side) { return joint.total_on(side).in_C; }

/// What forces and torques of a joint are held against at least: next to nothing is round-off of what is large
/// elsewhere.
struct Floors {
  double force = 0.0;
  double length = 0.0;
};

struct WrenchSpread {
  Spread force;
  Spread torque;
  Floors floors;

  [[nodiscard]] bool forces_alike() const { return force.is_alike(floors.force); }
  [[nodiscard]] bool is_alike() const {
    return forces_alike() && torque.is_alike(std::max(force.size, floors.force) * floors.length);
  }
};

/// The first solver's wrench on `side` against the second one's on `other`.
WrenchSpread spread_of(const std::vector<EvaluatedState>& states, std::size_t joint, Side side, Side other, Reader read,
                       const Floors& floors) {
  WrenchSpread spread{{}, {}, floors};
  for (const EvaluatedState& one : states) {
    const Wrench& a = read(one.by[0]->joints[joint], side);
    const Wrench& b = read(one.by[1]->joints[joint], other);
    spread.force.take(a.force, b.force);
    spread.torque.take(a.torque, b.torque);
  }
  return spread;
}

Floors floors_of(const Model& model, const std::vector<EvaluatedState>& states) {
  constexpr double kSmallest = 1e-6;
  double largest = 0.0;
  for (const EvaluatedState& one : states) {
    for (const JointWrenches& joint : one.by[0]->joints) {
      largest = std::max(largest, joint.total_on(Side::child).in_global.force.norm());
    }
    for (const ElementWrenches& element : one.by[0]->elements) {
      largest = std::max(largest, element.on_side(Side::child).in_global.force.norm());
    }
  }
  return {kSmallest * largest, model.length_scale()};
}

/// The kinds of wrong reports of one joint, from the most telling one on.
std::optional<ReportFault> fault_of(const std::vector<EvaluatedState>& states, std::size_t joint,
                                    const Floors& floors) {
  std::array<WrenchSpread, 2> total;
  std::array<WrenchSpread, 2> reaction;
  std::array<WrenchSpread, 2> in_frame;
  bool is_swapped = true;
  for (const Side side : kSides) {
    const Side other = side == Side::child ? Side::parent : Side::child;
    total[index(side)] = spread_of(states, joint, side, side, total_in_global, floors);
    reaction[index(side)] = spread_of(states, joint, side, side, reaction_in_global, floors);
    in_frame[index(side)] = spread_of(states, joint, side, side, total_in_frame, floors);
    is_swapped = is_swapped && spread_of(states, joint, side, other, total_in_global, floors).forces_alike();
  }
  const auto both_alike = [](const std::array<WrenchSpread, 2>& sides) {
    return sides[0].is_alike() && sides[1].is_alike();
  };
  const auto number = static_cast<int>(joint);
  if (both_alike(total) && both_alike(reaction)) {
    if (both_alike(in_frame)) return std::nullopt;
    return ReportFault{Term::frame, number, "the vectors agree in global axes and differ in the joint's axes"};
  }
  if (both_alike(total)) {
    return ReportFault{Term::subtraction, number,
                       "the totals agree and what is left without drivers and springs differs"};
  }
  if (both_alike(reaction)) {
    return ReportFault{Term::subtraction, number, "the reactions agree and the totals differ"};
  }
  if (total[0].forces_alike() && total[1].forces_alike()) {
    return ReportFault{Term::point, number, "the forces agree on both bodies and the torques differ"};
  }
  if (is_swapped) return ReportFault{Term::side, number, "each body has the other one's wrench"};
  if (total[0].forces_alike() != total[1].forces_alike()) {
    return ReportFault{Term::side, number, "the force agrees on one body and differs on the other one"};
  }
  return ReportFault{Term::reaction, number, "the motions agree and the wrench differs on both bodies"};
}

}  // namespace

bool move_alike(const std::vector<EvaluatedState>& states) {
  Spread linear;
  Spread angular;
  Spread modal;
  for (const EvaluatedState& one : states) {
    for (std::size_t i = 1; i < one.by[0]->bodies.size(); ++i) {
      const BodyAcceleration& a = one.by[0]->bodies[i];
      const BodyAcceleration& b = one.by[1]->bodies[i];
      linear.take(a.vdot, b.vdot);
      angular.take(a.omegadot, b.omegadot);
      modal.take(a.addot, b.addot);
    }
  }
  return linear.is_alike() && angular.is_alike() && modal.is_alike();
}

std::vector<ReportFault> find_report_faults(const Model& model, const std::vector<EvaluatedState>& states,
                                            const std::vector<bool>& ambiguous) {
  constexpr std::array kOrder{Term::subtraction, Term::frame, Term::side, Term::point, Term::reaction};
  const auto order_of = [&](const ReportFault& fault) {
    return std::find(kOrder.begin(), kOrder.end(), fault.term) - kOrder.begin();
  };
  const Floors floors = floors_of(model, states);
  std::vector<ReportFault> faults;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (k < ambiguous.size() && ambiguous[k]) continue;
    if (const auto one = fault_of(states, k, floors)) faults.push_back(*one);
  }
  std::stable_sort(faults.begin(), faults.end(),
                   [&](const ReportFault& a, const ReportFault& b) { return order_of(a) < order_of(b); });
  return faults;
}

}  // namespace concord::compare
