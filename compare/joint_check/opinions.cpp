#include "compare/joint_check/opinions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cartesian/solver.h"
#include "compare/audit/carried_components.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "relative/solver.h"

namespace concord::compare::joint_check {

namespace {

constexpr double kVanishes = 1e-11;  // of the weight: a component that a joint cannot carry
constexpr double kAppears = 1e-6;    // of the weight: a component that it can

const Model& model_of(const Rig& rig, std::size_t who) {
  switch (who) {
    case cut_idle:
      return rig.idle_loop();
    case cartesian_loop:
    case cut_loop:
      return rig.loop_cut_at_tested();
    case tree_loop:
      return rig.loop_cut_at_ball();
    default:
      return rig.open();
  }
}

bool is_by_functions(const JointType& type) {
  return std::any_of(type.permits.begin(), type.permits.end(),
                     [](const joints::Permit& word) { return joints::function_of(word) != nullptr; });
}

}  // namespace

State state_of(const Rig& rig, std::size_t who, const State& open) {
  if (in_loop(who)) return rig.in_loop(open);
  return who == cut_idle ? Rig::in_idle_loop(open) : open;
}

std::unique_ptr<Solver> solver_of(const Rig& rig, std::size_t who) {
  const bool is_cartesian = who == cartesian_open || who == cartesian_loop;
  return is_cartesian ? cartesian::make_solver(model_of(rig, who)) : relative::make_solver(model_of(rig, who));
}

Opinions ask_all(Rig& rig, const std::vector<int>& poses) {
  Opinions opinions;
  opinions.poses = poses;
  std::vector<State> open;
  for (const int pose : poses) open.push_back(rig.state(pose));
  for (std::size_t who = 0; who < kOpinions; ++who) {
    const std::unique_ptr<Solver> solver = solver_of(rig, who);
    Auditor auditor(model_of(rig, who));
    for (const State& at : open) {
      const State& state = opinions.states[who].emplace_back(state_of(rig, who, at));
      opinions.evaluations[who].push_back(solver->evaluate(state));
      auditor.add(state, opinions.evaluations[who].back());
    }
    opinions.audits[who] = auditor.report();
  }
  return opinions;
}

void compare_opinions(const Rig& rig, const Opinions& opinions, Opinion one, Opinion other, const std::string& context,
                      Property& property) {
  // The joint that makes an idle loop is nothing that the open rig has.
  const Model& model = model_of(rig, one);
  std::vector<SharedState> shared;
  for (std::size_t k = 0; k < opinions.poses.size(); ++k) {
    SharedState both{opinions.states[one][k], {opinions.evaluations[one][k], opinions.evaluations[other][k]}};
    both.evaluations[1].joints.resize(model.joints.size());
    shared.push_back(std::move(both));
  }
  const QuantityLayout layout(model);
  const std::vector<Measured> measured = measure(layout, align(layout, shared));
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    double scale = measured[row].scale;
    if (quantity.kind != Kind::acceleration) {
      if (quantity.kind != Kind::body_sum && quantity.owner != Rig::kTested) continue;
      scale = std::max(scale, rig.weight() * (unit_of(model, quantity) == "N" ? 1.0 : model.length_scale()));
    }
    property.note(measured[row].difference / scale, opinions.poses[measured[row].worst], [&] {
      return fmt::format("{}: {}, {}: {} {:.9g}, {} {:.9g}, scale {:.3g}", context, describe_owner(model, quantity),
                         describe_component(quantity), kOpinionNames[one], measured[row].values[0],
                         kOpinionNames[other], measured[row].values[1], scale);
    });
  }
}

void note_audits(const Opinions& opinions, const std::string& context, Properties& rules) {
  for (std::size_t who = 0; who < kOpinions; ++who) {
    for (std::size_t rule = 0; rule < rules.size(); ++rule) {
      const AuditFinding& finding = opinions.audits[who].rules[rule];
      if (finding.row.empty()) continue;
      rules[rule].note(std::pow(10.0, -finding.digits), opinions.pose_at(finding.t),
                       [&] { return fmt::format("{}: {}: {}", context, kOpinionNames[who], finding.text()); });
    }
  }
}

void note_largest(const Rig& rig, const Opinions& opinions, Largest& largest) {
  for (const auto& evaluations : opinions.evaluations) {
    for (const Evaluation& evaluation : evaluations) {
      for (const Side side : {Side::parent, Side::child}) {
        Vec6 reaction = evaluation.joints[Rig::kTested].reaction_on(side).in_C.vector() / rig.weight();
        reaction.tail<3>() /= rig.open().length_scale();
        largest[index(side)] = largest[index(side)].cwiseMax(reaction.cwiseAbs());
      }
    }
  }
}

void require_carried(const JointType& type, const Largest& largest, Property& property) {
  for (const Side side : {Side::parent, Side::child}) {
    for (int component = 0; component < 6; ++component) {
      const double found = largest[index(side)](component);
      const bool said = carries(type, side, component);
      const bool right = said ? found > kAppears || is_by_functions(type) : found < kVanishes;
      property.require(right, -1, [&] {
        return fmt::format("{} on the {} is {} be carried, but reaches {:.3g} of the rig's weight",
                           component_names()[component], side == Side::parent ? "parent" : "child",
                           said ? "said to" : "not said to", found);
      });
    }
  }
}

}  // namespace concord::compare::joint_check
