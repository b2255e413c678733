#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <catch2/catch.hpp>
#include <iostream>
#include <set>

#include "cartesian/solver.h"
#include "common/error.h"
#include "common/reading/model_file.h"
#include "compare/invariance/invariance_checks.h"
#include "compare/invariance/report.h"
#include "compare/report/text_table.h"
#include "compare/verdict/verify.h"
#include "relative/solver.h"
#include "tests/faults/catalogue.h"

/// Faults that sleep in a machine because of how its file describes it: both solvers agree. The machine described
/// otherwise wakes them.
namespace concord::compare {
namespace {

using faults::Fault;
using faults::Planting;

/// A fault of one solver, a shipped machine in which it sleeps, and the moves under which that solver is not itself.
struct Sleeper {
  const char* fault;
  const char* model;
  Who who;
  std::set<std::string> moves;
};

/// Written down before the checks was run.
const std::vector<Sleeper>& sleepers() {
  static const std::vector<Sleeper> all{
      // Every joint of these trees leads from its parent outward.
      {"reversed joint reported from the wrong side", "double_pendulum_3d", Who::relative, {"sides"}},
      {"reversed joint reported from the wrong side", "spinning_top", Who::relative, {"sides"}},
  };
  return all;
}

Model shipped_model(const std::string& name) {
  return read_model(std::string(CONCORD_DATA) + "/models/" + name + ".toml");
}

Outcome compared(const Model& model) {
  VerifyOptions options;
  options.states = 40;
  const auto cartesian = cartesian::make_solver(model);
  const auto relative = relative::make_solver(model);
  return verify(model, *cartesian, *relative, options).outcome;
}

std::set<std::string> red_moves(const invariance::InvarianceChecks& checks, Who who) {
  std::set<std::string> red;
  for (const invariance::MoveRow& row : checks.rows) {
    if (row.applies && row.who == who && row.outcome != Outcome::agree) red.insert(checks.moves[row.move].name);
  }
  return red;
}

TEST_CASE("A fault that sleeps in a machine's description shows under the move that wakes it, and under no other") {
  const SolverMakers makers{cartesian::make_solver, relative::make_solver};
  std::vector<std::vector<std::string>> lines{{"fault", "machine", "concord compare", "red under"}};
  for (const Sleeper& sleeper : sleepers()) {
    INFO(sleeper.fault << ", " << sleeper.model);
    const Model model = shipped_model(sleeper.model);
    CHECK(invariance::check_invariance(model, makers, {}).outcome == Outcome::agree);
    const int number = faults::number_of(faults::read_catalogue(), sleeper.fault);
    REQUIRE(number >= 0);
    const Planting planting(number);
    const Outcome by_comparison = compared(model);
    CHECK(by_comparison == Outcome::agree);
    const invariance::InvarianceChecks checks = invariance::check_invariance(model, makers, {});
    INFO(invariance::format_checks(model, checks));
    const std::set<std::string> red = red_moves(checks, sleeper.who);
    CHECK(red == sleeper.moves);
    CHECK(red_moves(checks, sleeper.who == Who::relative ? Who::cartesian : Who::relative).empty());
    lines.push_back({sleeper.fault, sleeper.model, to_string(by_comparison), fmt::format("{}", fmt::join(red, ", "))});
  }
  std::cout << format_table(lines, {false, false, false, false});
}

/// Moves under which each solver differs on a machine of this folder with a fault; nothing where there is no checks.
std::array<std::set<std::string>, 2> red_by_solver(const Fault& fault, const SolverMakers& makers) {
  const Model model = read_model(CONCORD_FAULTS "/" + fault.machine + ".toml");
  const Planting planting(fault.number);
  try {
    const invariance::InvarianceChecks checks = invariance::check_invariance(model, makers, {});
    if (!checks.failures.empty()) return {};
    return {red_moves(checks, Who::cartesian), red_moves(checks, Who::relative)};
  } catch (const InputError&) {  // a solver that cannot start
    return {};
  }
}

TEST_CASE(
    "Each solver alone finds a part of its faults when its machine is described otherwise, and no sound one is red") {
  const SolverMakers makers{cartesian::make_solver, relative::make_solver};
  std::vector<std::vector<std::string>> lines{{"fault", "planted in", "red under"}};
  int found = 0;
  int all = 0;
  for (const Fault& fault : faults::read_catalogue()) {
    if (!fault.is_in("cartesian") && !fault.is_in("relative")) continue;
    INFO(fault.name);
    ++all;
    const auto red = red_by_solver(fault, makers);
    const Who faulty = fault.is_in("cartesian") ? Who::cartesian : Who::relative;
    CHECK(red[static_cast<std::size_t>(1 - index(faulty))].empty());
    const std::set<std::string>& moves = red[static_cast<std::size_t>(index(faulty))];
    if (moves.empty()) continue;
    ++found;
    lines.push_back({fault.name, fault.file, fmt::format("{}", fmt::join(moves, ", "))});
  }
  std::cout << format_table(lines, {false, false, false}) << fmt::format("{} of {}\n", found, all);
  CHECK(found >= 27);  // the others break what a solver says in the same way in every description
}

}  // namespace
}  // namespace concord::compare
