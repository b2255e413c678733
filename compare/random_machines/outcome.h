#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "compare/verdict/verdict.h"
#include "compare/workers/pool.h"

/// What became of a machine, told apart by kinds from closed lists.
namespace concord::compare::fuzz {

enum class Sort {
  agree,
  refusal,  // honest: of a kind in refusal_kinds()
  differ,   // the solvers, or one of them and the audit: exit code 1
  stop,     // a refusal of no known kind
  lost      // crashed, hung or out of memory: exit code 3
};

/// How often differences at the same state were how large a part of what double precision resolves there: of each
/// component the largest over its states.
struct ResolutionRatios {
  static constexpr std::array<double, 8> kEdges{0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0};

  void add(double ratio);
  void add(const ResolutionRatios& others);
  [[nodiscard]] long count() const;
  /// The least edge that at least this share of the ratios keep to; infinite if none is.
  [[nodiscard]] double edge_of(double share) const;

  std::array<long, kEdges.size() + 1> counts{};  // up to each edge, and beyond the last
  double largest = 0.0;
};

/// Whether more regular machines are refused than sound solvers refuse, which is about 1 %: each refusal may be honest,
/// but a solver that assembles wrong starts is refused, too. A tenth, and ten at least.
bool refuses_too_many(long regular, long refused);

struct Outcome {
  Sort sort = Sort::agree;
  std::string kind;  // what a shrunk machine must keep; the same for machines with the same trouble
  std::string text;  // what was said
  ResolutionRatios ratios = {};
  [[nodiscard]] bool is_wrong() const { return sort != Sort::agree && sort != Sort::refusal; }
};

/// All kinds of known refusals.
std::vector<std::string> refusal_kinds();

/// The kind of known refusal that a message of the program states; empty if it is none.
std::string refusal_kind(std::string_view message);

Outcome outcome_of(const Verdict& verdict);
/// Of an input error: `is_read` says whether the model could be read, so that its start was refused.
Outcome outcome_of_input_error(const std::string& message, bool is_read);
Outcome outcome_of_error(const std::string& message);
/// Of the process: what the task answered is what format_outcome() wrote.
Outcome outcome_of(const workers::Report& report);

std::string format_outcome(const Outcome& outcome);

/// A message without what differs from machine to machine: numbers and names.
std::string without_particulars(std::string_view message);

}  // namespace concord::compare::fuzz
