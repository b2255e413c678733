#pragma once

#include <functional>

#include "common/model.h"
#include "common/solver.h"
#include "compare/states/body_frames.h"

/// One machine, described in another way. What is physical stays.
namespace concord::compare::invariance {

/// A way to describe a machine anew. `model` and `state` lead from the first description to the second, `back` leads a
/// state from the second to the first; `evaluation` and `report` lead what a solver found for the second description
/// back to the first (`before` is the state in the first).
struct Change {
  std::function<Model(Model)> model = [](Model same) { return same; };
  std::function<State(State)> state = [](State same) { return same; };
  std::function<State(State)> back = [](State same) { return same; };
  std::function<Evaluation(const State& before, Evaluation)> evaluation = [](const State&, Evaluation same) {
    return same;
  };
  std::function<RankReport(RankReport)> report = [](RankReport same) { return same; };
};

/// One change after another.
Change operator|(const Change& first, const Change& then);

/// The model with its start in `state`: what was kept is kept there, all else is a guess.
Model started_in(Model model, const State& state);

/// Every wrench of an evaluation, one side at a time; those of joints, and of joints and elements.
void for_each_joint_wrench(Evaluation& evaluation, const std::function<void(SideWrench&)>& edit);
void for_each_wrench(Evaluation& evaluation, const std::function<void(SideWrench&)>& edit);

/// Flags of one side of a joint, told in axes C, as they follow from flags told in axes C G. Where G mixes components
/// that are not all unique, the flag is undecided: their sum may be unique all the same.
void turn_flags(const Mat3& G, std::array<bool, 6>& unique, std::array<bool, 6>& decided);

/// The flags that say of each joint's flags whether they are decided; all are if the report says nothing.
std::vector<JointUniqueness>& decided_flags(RankReport& report);

/// Whether a driver, spring or coupling acts on a coordinate of joint k.
bool is_forced(const Model& model, int k);

}  // namespace concord::compare::invariance
