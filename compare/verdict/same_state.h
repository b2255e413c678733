#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/solver.h"
#include "compare/resolution/weighed_states.h"
#include "compare/states/states.h"
#include "compare/verdict/judge.h"

/// The check "same state": both solvers are asked in the same states, no integration in between.
namespace concord::compare {

class SameState {
 public:
  /// `seed`: of the draws within round-off. What is referred to must outlive this.
  SameState(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers, std::uint64_t seed, Judge& judge,
            Verdict& verdict);

  /// Weighs and judges states that both solvers evaluated: those that they found themselves, and perturbed ones. Ranks
  /// and uniqueness, refusals, singular poses and rows. The measured rows, empty if there is no state.
  std::vector<Measured> judge_states(SharedStates found, SharedStates perturbed = {});

  /// The states of judge_states(), those that the solvers found first.
  [[nodiscard]] const WeighedStates& weighed() const { return weighed_; }

 private:
  void note_failures(const SharedStates& shared);
  bool is_singular_throughout(const SharedStates& found) const;
  void forget_neighbours();
  void note_singular_start();
  void note_refusals(const std::vector<RefusedState>& refused);
  bool is_at_singular_pose(const OwnedState& state) const;
  void note_resolution();

  const QuantityLayout& layout_;
  std::array<Solver*, 2> solvers_;
  std::uint64_t seed_;
  Judge& judge_;
  Verdict& verdict_;
  WeighedStates weighed_;
};

}  // namespace concord::compare
