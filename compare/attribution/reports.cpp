#include "compare/attribution/reports.h"

#include <algorithm>
#include <cmath>

#include "common/decompositions.h"

namespace concord::compare {

namespace {

constexpr double kAlike = 1e-9;  // of the largest in all states

/// Largest difference between two solvers and largest size, over all states.
struct Spread {
  double difference = 0.0;
  double size = 0.0;

  void take(const VecX& one, const VecX& other) {
    difference = std::max(difference, (one - other).norm());
    size = std::max({size, one.norm(), other.norm()});
  }
  [[nodiscard]] double part() const { return size > 0.0 ? difference / size : 0.0; }
  [[nodiscard]] bool is_alike() const { return part() <= kAlike; }
};

/// One wrench of a joint in all states, as both solvers give it: the force first, then the torque.
using Reader = Wrench (*)(const JointWrenches&, Side);

Wrench total_in_global(const JointWrenches& joint, Side side) { return joint.total_on(side).in_global; }
Wrench reaction_in_global(const JointWrenches& joint, Side side) { return joint.reaction_on(side).in_global; }
Wrench total_in_frame(const JointWrenches& joint, Side side) { return joint.total_on(side).in_C; }

struct WrenchSpread {
  Spread force;
  Spread torque;

  [[nodiscard]] bool is_alike() const { return force.is_alike() && torque.is_alike(); }
  [[nodiscard]] double part() const { return std::max(force.part(), torque.part()); }
};

WrenchSpread spread_of(const std::vector<EvaluatedState>& states, std::size_t joint, Side side, Reader read) {
  WrenchSpread spread;
  for (const EvaluatedState& one : states) {
    const Wrench a = read(one.by[0]->joints[joint], side);
    const Wrench b = read(one.by[1]->joints[joint], side);
    spread.force.take(a.force, b.force);
    spread.torque.take(a.torque, b.torque);
  }
  return spread;
}

/// The kinds of wrong reports of one joint, from the most telling one on.
std::optional<ReportFault> fault_of(const std::vector<EvaluatedState>& states, std::size_t joint) {
  std::array<WrenchSpread, 2> total;
  std::array<WrenchSpread, 2> reaction;
  std::array<WrenchSpread, 2> in_frame;
  for (const Side side : kSides) {
    total[index(side)] = spread_of(states, joint, side, total_in_global);
    reaction[index(side)] = spread_of(states, joint, side, reaction_in_global);
    in_frame[index(side)] = spread_of(states, joint, side, total_in_frame);
  }
  const auto number = static_cast<int>(joint);
  const bool totals_alike = total[0].is_alike() && total[1].is_alike();
  const bool reactions_alike = reaction[0].is_alike() && reaction[1].is_alike();
  const bool frames_alike = in_frame[0].is_alike() && in_frame[1].is_alike();
  if (totals_alike && reactions_alike && frames_alike) return std::nullopt;
  if (totals_alike && reactions_alike) {
    return ReportFault{Term::frame, number, "the vectors agree in global axes and differ in the joint's axes"};
  }
  if (totals_alike || reactions_alike) {
    return ReportFault{Term::subtraction, number,
                       totals_alike ? "the totals agree and what is left without drivers and springs differs"
                                    : "the reactions agree and the totals differ"};
  }
  if (total[0].is_alike() != total[1].is_alike()) {
    return ReportFault{Term::side, number, "the wrench agrees on one body and differs on the other one"};
  }
  if (total[0].force.is_alike() && total[1].force.is_alike()) {
    return ReportFault{Term::point, number, "the forces agree on both bodies and the torques differ"};
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

std::optional<ReportFault> find_report_fault(const Model& model, const std::vector<EvaluatedState>& states) {
  // A wrong wrench of one joint makes others wrong that are found from it: those kinds that concern one joint alone
  // come first.
  std::optional<ReportFault> found;
  const auto comes_before = [](Term one, Term other) {
    const auto order = [](Term term) {
      return term == Term::subtraction ? 0
             : term == Term::frame     ? 1
             : term == Term::side      ? 2
             : term == Term::point     ? 3
                                       : 4;
    };
    return order(one) < order(other);
  };
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const std::optional<ReportFault> one = fault_of(states, k);
    if (one && (!found || comes_before(one->term, found->term))) found = one;
  }
  return found;
}

}  // namespace concord::compare
