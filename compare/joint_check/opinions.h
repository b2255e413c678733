#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/audit/balance.h"
#include "compare/joint_check/property.h"
#include "compare/joint_check/rig.h"

/// What each solver says of the joint in each role, and whether they agree.
namespace concord::compare::joint_check {

/// Each solver with the joint in the tree, and in a loop that is cut at it.
enum Opinion : std::size_t { cartesian_open, tree_open, cut_idle, cartesian_loop, tree_loop, cut_loop };
inline constexpr std::size_t kOpinions = 6;
inline constexpr std::array<const char*, kOpinions> kOpinionNames{
    "cartesian, open rig",   "relative, tree joint, open rig",   "relative, cut joint, open rig with an idle loop",
    "cartesian, closed rig", "relative, tree joint, closed rig", "relative, cut joint, closed rig"};

/// Whether an opinion is of the closed rig.
constexpr bool in_loop(std::size_t who) { return who >= cartesian_loop; }

/// A state and a solver as an opinion has them; `open`: the state of the open rig.
State state_of(const Rig& rig, std::size_t who, const State& open);
std::unique_ptr<Solver> solver_of(const Rig& rig, std::size_t who);

/// The same poses through all of them.
struct Opinions {
  std::vector<int> poses;
  std::array<std::vector<State>, kOpinions> states;
  std::array<std::vector<Evaluation>, kOpinions> evaluations;
  std::array<AuditReport, kOpinions> audits;

  [[nodiscard]] int pose_at(double t) const {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      if (states[cartesian_open][k].t == t) return poses[k];
    }
    return -1;
  }
};

/// All opinions of the rig at the poses, each audited.
Opinions ask_all(Rig& rig, const std::vector<int>& poses);

/// Agreement of two opinions on all of the joint under test and on all accelerations. A wrench is compared with the
/// joint's peak, and at least against the weight of the rig.
void compare_opinions(const Rig& rig, const Opinions& opinions, Opinion one, Opinion other, const std::string& context,
                      Property& property);

/// The worst that the audit found by each of its rules.
void note_audits(const Opinions& opinions, const std::string& context, Properties& rules);

/// Largest reaction components on each side, in its joint frame, relative to the weight.
using Largest = std::array<Vec6, 2>;

void note_largest(const Rig& rig, const Opinions& opinions, Largest& largest);

/// Requires that those components appear that the type carries, and no others. Of what a type by functions carries,
/// every component may appear, none must: it may be carried at other poses than these.
void require_carried(const JointType& type, const Largest& largest, Property& property);

}  // namespace concord::compare::joint_check
