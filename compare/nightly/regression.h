#pragma once

#include <string>
#include <vector>

#include "compare/nightly/history.h"
#include "compare/nightly/result.h"
#include "compare/nightly/suite.h"

/// What became worse, better, new, gone.
namespace concord::compare::nightly {

/// Code beside those of every command: a baseline is missing, or belongs to another model or other settings.
inline constexpr int kNoBaseline = 4;

enum class ChangeKind {
  red,      // differs, has no verdict or was lost, for no reason that is known
  worse,    // than what is accepted, or than the nights before
  gone,     // was there, and is not any more
  missing,  // has no baseline
  changed,  // other than what is accepted of another model, or of other settings
  flaky,    // one program on one machine gave different results
  known,    // red, for a reason that is known
  better,
  fresh  // was not there before
};

/// Whether a result of an earlier night is one of the same case, asked the same, that agreed.
bool counts_as_past(const Result& then, const Result& now);

/// "differ: " and what it says first.
std::string red_words(const Result& result);

/// "red", "worse", "gone", "no baseline", "changed", "flaky", "known red", "better", "new".
std::string to_string(ChangeKind kind);

struct Change {
  ChangeKind kind = ChangeKind::worse;
  std::string id;         // of the case
  std::string component;  // empty: the case as a whole
  std::string measure;    // "same state", "peak", "evaluations of relative", "ending"
  std::string was;
  std::string is;
  std::string against = {};  // "baseline", "median of 7 nights", "A"
  double size = 1.0;         // how far beyond what is allowed, in its own measure
  int more = 0;              // components of the case that changed in the same way, but less
};

/// All changes from `then` to `now`, of each measure the largest. Digits of the same state count no more than double
/// precision resolves; smaller ones mean nothing. Where both definitions are known and differ, the two were asked
/// different things: then all numbers are `changed`, neither worse nor better; how the case ended is not excused.
std::vector<Change> changes_between(const Result& then, const Result& now, const Judging& judging,
                                    const std::string& against);

/// Component by component the median of the numbers; ending and words are the latest's. At least one result.
Result median_of(const std::vector<Entry>& nights);

/// Whether a red case is excused by its known_red on the day `today`: a reason for a verdict is none for a crash, or
/// for a model that is not read.
bool counts_as_known_red(const Case& one, const Result& now, const std::string& today);

/// A case tonight, compared with its baseline (may be null) and the nights before, the latest first. `today`:
/// "2026-11-22".
std::vector<Change> judge_case(const Case& one, const Result& now, const Result* baseline,
                               const std::vector<Entry>& earlier, const Origin& origin, const Judging& judging,
                               const std::string& today);

/// Code of the program for a set of changes: the worst of 0, 4 (a baseline is missing, or of another model), 1, 2, 3.
/// `now` says how a red case ended.
int exit_code(const Change& change, Ending ending);
int worse_code(int one, int other);

}  // namespace concord::compare::nightly
