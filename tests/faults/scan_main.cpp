#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <tuple>

#include "common/reading/model_file.h"
#include "compare/resolution/weighed_states.h"
#include "compare/verdict/refinement.h"
#include "tests/faults/parameter_scan.h"

namespace concord::compare {

bool differs_at_same_state(const Model& model, const std::array<Solver*, 2>& solvers,
                           const std::vector<OwnedState>& states) {
  const QuantityLayout layout(model);
  SharedStates shared = share(solvers, states);
  if (!shared.refusals.empty() || !shared.failures.empty()) return true;
  const WeighedStates weighed = weigh(layout, solvers, std::move(shared.states), kSeed);
  Verdict verdict;
  make_rows(layout, verdict);
  record(layout, measure(layout, weighed.series, weighed.budget()), Check::same_state, verdict);
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (row.unique && row.same_state && !meets_need(row, Check::same_state)) return true;
    }
  }
  return false;
}

namespace {

/// By model, fault and solver: the smallest size seen.
using Frozen = std::map<std::tuple<std::string, std::string, std::string>, double>;

/// Later files replace what earlier ones say.
void read_frozen(const char* file, Frozen& frozen) {
  std::ifstream lines(file);
  std::string line;
  std::getline(lines, line);  // names of the columns
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::array<std::string, 4> cell;
    for (std::string& one : cell) std::getline(cells, one, ',');
    if (cell[3] != "never") frozen[{cell[0], cell[1], cell[2]}] = std::stod(cell[3]);
  }
}

/// Prints every fault of a model with the smallest size seen.
void print_smallest(const Model& model) {
  ParameterScan scan(model);
  fmt::print(stderr, "{}\n", scan.ratios());
  for (const ParameterFault& fault : parameter_faults(model)) {
    for (const Who who : {Who::cartesian, Who::relative}) {
      const auto size = scan.smallest_seen(fault, who);
      fmt::print("{},{},{},{}\n", model.name, fault.name, kSolverNames[index(who)],
                 size ? fmt::format("{:.2e}", *size) : "never");
    }
  }
}

/// Counts and names the faults of a model that are not seen any more at their frozen size.
int count_unseen(const Model& model, const Frozen& frozen) {
  ParameterScan scan(model);
  int unseen = 0;
  for (const ParameterFault& fault : parameter_faults(model)) {
    for (const Who who : {Who::cartesian, Who::relative}) {
      const auto known = frozen.find({model.name, fault.name, kSolverNames[index(who)]});
      if (known == frozen.end() || scan.is_seen(fault, who, known->second)) continue;
      ++unseen;
      fmt::print("{}: {} in {} is not seen at {:.2e}\n", model.name, fault.name, kSolverNames[index(who)],
                 known->second);
    }
  }
  return unseen;
}

}  // namespace
}  // namespace concord::compare

/// parameter_scan MODEL...: "model,fault,solver,smallest size seen" for each. parameter_scan --against FILE EXCEPTIONS
/// MODEL...: ends with 1 if any fault is not seen at the size that FILE holds, or EXCEPTIONS if it stands there.
int main(int argc, char** argv) {
  using namespace concord;
  using namespace concord::compare;
  const bool against = argc > 3 && std::string(argv[1]) == "--against";
  Frozen frozen;
  for (int k = 2; against && k < 4; ++k) read_frozen(argv[k], frozen);
  int unseen = 0;
  for (int k = against ? 4 : 1; k < argc; ++k) {
    const Model model = read_model(argv[k]);
    if (against) {
      unseen += count_unseen(model, frozen);
    } else {
      print_smallest(model);
    }
    std::fflush(stdout);
  }
  if (against) fmt::print("{} of {} faults are not seen at their frozen size\n", unseen, frozen.size());
  return unseen == 0 ? 0 : 1;
}
