#include <catch2/catch.hpp>
#include <filesystem>

#include "closed_forms.h"
#include "compare/attribution/ranks.h"
#include "compare/audit/machine_rank.h"
#include "compare/verdict/blame.h"

/// The comparator counts constraints from what joints permit, by code of its own: on every shipped machine it must see
/// what both solvers see, or it would blame one that is right.
namespace concord::verification {
namespace {

const std::filesystem::path kModels = std::filesystem::path(CONCORD_DATA) / "models";

TEST_CASE("The comparator's own count of constraints is that of both solvers on every shipped machine") {
  int sure = 0;
  int machines = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kModels)) {
    if (entry.path().extension() != ".toml") continue;
    INFO(entry.path().filename().string());
    const Model model = read_model(entry.path());
    const auto cartesian_solver = cartesian::make_solver(model);
    const auto relative_solver = relative::make_solver(model);
    const std::array<Solver*, 2> solvers{cartesian_solver.get(), relative_solver.get()};
    const std::vector<compare::OwnedState> starts{{solvers[0]->assemble(), compare::Who::cartesian},
                                                  {solvers[1]->assemble(), compare::Who::relative}};
    const auto asked = compare::ask_of_constraints(solvers, compare::states_of_ranks(model, solvers, starts, 1));
    CHECK(asked.size() > 1);
    ++machines;
    compare::ConstraintOpinion opinion(model, asked);
    for (const auto& fault : {opinion.wrong_count(), opinion.wrong_velocities(), opinion.wrongly_closed(),
                              opinion.wrongly_singular(), opinion.wrong_uniqueness()}) {
      INFO((fault ? fault->where + ": " + fault->because : ""));
      CHECK_FALSE(fault);
    }
    for (const auto& one : asked) {
      const compare::MachineConstraints constraints(model, one.state);
      if (!constraints.is_sure()) continue;
      ++sure;
      for (const auto& stated : one.by) {
        if (!stated.rank || stated.rank->undecided) continue;
        CHECK(stated.rank->degrees_of_freedom == constraints.report().degrees_of_freedom);
        CHECK(stated.rank->constraints - stated.rank->rank ==
              constraints.report().constraints - constraints.report().rank);
        const auto span = constraints.hold_against(stated.tangent);
        CHECK(span.holds_all);
        CHECK(span.holds_nothing_else);
        INFO(span.worst);
      }
    }
  }
  CHECK(machines > 20);
  CHECK(sure > 5 * machines);
}

}  // namespace
}  // namespace concord::verification
