#include "compare/verdict/verdict.h"

#include <algorithm>
#include <utility>

namespace concord::compare {

std::string to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::agree:
      return "agree";
    case Outcome::differ:
      return "differ";
    default:
      return "failed";
  }
}

std::string to_string(ReferenceWord word) {
  switch (word) {
    case ReferenceWord::equal:
      return "equal";
    case ReferenceWord::other_convention:
      return "equal in another convention";
    case ReferenceWord::one_of_many:
      return "one of infinitely many";
    case ReferenceWord::wrong:
      return "wrong";
    default:
      return "not judged";
  }
}

bool is_off(const ReferenceRow& row) {
  return row.word != ReferenceWord::equal && row.word != ReferenceWord::not_judged;
}

std::string to_string(Judgement judgement) {
  switch (judgement) {
    case Judgement::agree:
      return "agree";
    case Judgement::differ:
      return "differ";
    default:
      return "not judged";
  }
}

int exit_code(Outcome outcome) {
  switch (outcome) {
    case Outcome::agree:
      return 0;
    case Outcome::differ:
      return 1;
    default:
      return 3;
  }
}

namespace {

void add(const QuantityRow& row, ComponentCount& count) {
  ++count.total;
  if (row.judgement != Judgement::not_judged) ++count.judged;
}

}  // namespace

ComponentCount count_reactions(const Verdict& verdict) {
  ComponentCount count;
  for (const QuantityRow& row : verdict.rows) add(row, count);
  return count;
}

ComponentCount count_components(const Verdict& verdict) {
  ComponentCount count = count_reactions(verdict);
  for (const QuantityRow& row : verdict.others) {
    if (row.quantity.kind == Kind::element) add(row, count);
  }
  return count;
}

void leave_out_repeated(std::vector<std::string>& lines) {
  std::vector<std::string> kept;
  for (std::string& line : lines) {
    const auto says_it = [&](const std::string& earlier) { return earlier == line || earlier.ends_with(": " + line); };
    if (std::none_of(kept.begin(), kept.end(), says_it)) kept.push_back(std::move(line));
  }
  lines = std::move(kept);
}

bool keeps_energy(const Verdict& verdict) {
  return std::all_of(verdict.solvers.begin(), verdict.solvers.end(),
                     [&](const SolverSummary& solver) { return keeps_energy(verdict, solver); });
}

bool keeps_energy(const Verdict& verdict, const SolverSummary& solver) {
  return solver.energy_error && *solver.energy_error <= verdict.energy_allowed;
}

}  // namespace concord::compare
