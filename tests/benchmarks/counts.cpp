#include "tests/benchmarks/counts.h"

#include <SuiteSparse_config.h>
#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <sundials/sundials_config.h>

#include <Eigen/Core>
#include <ostream>
#include <set>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/nightly/baseline.h"
#include "compare/report/files.h"
#include "compare/report/whole_number.h"

namespace concord::benchmarks {

namespace {

namespace fs = std::filesystem;
using compare::nightly::format_fields;
using compare::nightly::split_fields;

constexpr std::string_view kTitle = "concord counts,1";
constexpr std::string_view kAccept = "tests/run --accept-counts REASON";
constexpr int kNotCompared = 77;  // ctest calls it skipped

/// The lines of a text, with their numbers from 1.
template <class Use>
void for_each_line(std::string_view text, const Use& use) {
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    use(text.substr(at, end - at), ++number);
    at = end + 1;
  }
}

long number_in(const std::string& field, const SourceLocation& where) {
  const auto found = compare::whole_text_as<long>(field);
  if (!found || *found < 0) throw InputError(where, fmt::format("expected a count, found '{}'", field));
  return *found;
}

std::string words_of(const char* what, long old, long now) {
  return fmt::format("{} {} -> {} ({:+.1f} %)", what, old, now, 100.0 * (static_cast<double>(now) / old - 1.0));
}

/// The change of one number of a job, if it is worth telling.
void judge_number(const std::string& job, const char* what, long old, long now, Judgement& judgement) {
  const double change = static_cast<double>(now - old);
  const double least = kWorthTelling * static_cast<double>(old);
  if (change > 0 && change >= least) judgement.red.push_back(job + ": " + words_of(what, old, now));
  if (change < 0 && -change >= least) judgement.fallen.push_back(job + ": " + words_of(what, old, now));
}

std::string words_of(const Count& count) {
  return fmt::format("instructions {}, evaluations {}", count.instructions, count.evaluations);
}

/// Of one callgrind profile: the job that it was dumped for, and its instructions.
std::pair<std::string, long> read_profile(const fs::path& file) {
  constexpr std::string_view kJob = "desc: Trigger: Client Request: ";
  constexpr std::string_view kSum = "totals: ";
  std::pair<std::string, long> found{"", -1};
  for_each_line(read_text_file(file), [&](std::string_view line, int number) {
    if (line.starts_with(kJob)) found.first = line.substr(kJob.size());
    if (line.starts_with(kSum))
      found.second = number_in(std::string(line.substr(kSum.size())), {file.string(), number, 1});
  });
  return found;
}

}  // namespace

std::string build_of_program() {
  return fmt::format("{}, Eigen {}.{}.{}, SUNDIALS {}, SuiteSparse {}.{}.{}, glibc {}",
                     compare::origin_of_program().compiler, EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                     EIGEN_MINOR_VERSION, SUNDIALS_VERSION, SUITESPARSE_MAIN_VERSION, SUITESPARSE_SUB_VERSION,
                     SUITESPARSE_SUBSUB_VERSION, gnu_get_libc_version());
}

std::string format_accepted(const Accepted& accepted) {
  std::string text =
      fmt::format("{}\n# Written by `{}` alone.\n# build,compiler and libraries\n# ,job,instructions,evaluations\n",
                  kTitle, kAccept);
  for (const auto& [build, counts] : accepted) {
    text += format_fields({"build", build}) + '\n';
    for (const auto& [job, count] : counts) {
      text += format_fields({"", job, std::to_string(count.instructions), std::to_string(count.evaluations)}) + '\n';
    }
  }
  return text;
}

Accepted parse_accepted(std::string_view text, const std::string& file) {
  Accepted accepted;
  Counts* counts = nullptr;
  for_each_line(text, [&](std::string_view line, int number) {
    const SourceLocation where{file, number, 1};
    if (number == 1) {
      if (line != kTitle) throw InputError(where, fmt::format("the first line must be '{}'", kTitle));
      return;
    }
    if (line.empty() || line.front() == '#') return;
    const auto fields = split_fields(line);
    if (fields && fields->size() == 2 && fields->front() == "build") {
      counts = &accepted[fields->back()];
    } else if (fields && fields->size() == 4 && fields->front().empty() && counts != nullptr) {
      const Count count{number_in((*fields)[2], where), number_in((*fields)[3], where)};
      const bool is_new = counts->emplace((*fields)[1], count).second;
      if (!is_new) throw InputError(where, fmt::format("'{}' stands there twice", (*fields)[1]));
    } else {
      throw InputError(where, "expected 'build,NAME' and then lines of ',job,instructions,evaluations'");
    }
  });
  return accepted;
}

Judgement judge(const Accepted& accepted, const std::string& build, const Counts& counted) {
  const auto known = accepted.find(build);
  if (known == accepted.end()) return {false, {}, {}};
  Judgement judgement;
  for (const auto& [job, old] : known->second) {
    const auto now = counted.find(job);
    if (now == counted.end()) {
      judgement.red.push_back(job + ": accepted, but no longer counted");
      continue;
    }
    judge_number(job, "instructions", old.instructions, now->second.instructions, judgement);
    judge_number(job, "evaluations", old.evaluations, now->second.evaluations, judgement);
  }
  for (const auto& [job, now] : counted) {
    if (!known->second.contains(job)) judgement.red.push_back(job + ": counted, but not accepted yet");
  }
  return judgement;
}

Counts read_counts(const fs::path& folder) {
  Counts counts;
  const fs::path evaluations = folder / "evaluations";
  for_each_line(read_text_file(evaluations), [&](std::string_view line, int number) {
    const SourceLocation where{evaluations.string(), number, 1};
    const auto fields = split_fields(line);
    if (!fields || fields->size() != 2) throw InputError(where, "expected 'JOB,NUMBER'");
    counts[fields->front()] = {-1, number_in(fields->back(), where)};
  });
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().stem() != "profile") continue;
    const auto [job, instructions] = read_profile(entry.path());
    if (const auto found = counts.find(job); found != counts.end()) found->second.instructions = instructions;
  }
  for (const auto& [job, count] : counts) {
    if (count.instructions >= 0) continue;
    throw InputError({folder.string(), 0, 0}, fmt::format("callgrind left no profile of '{}'", job));
  }
  return counts;
}

int judge_counts(const fs::path& folder, const fs::path& file, std::ostream& out) {
  const Accepted accepted = fs::exists(file) ? parse_accepted(read_text_file(file), file.string()) : Accepted{};
  const std::string build = build_of_program();
  const Counts counted = read_counts(folder);
  for (const auto& [job, count] : counted) out << fmt::format("{}: {}\n", job, words_of(count));
  const Judgement judgement = judge(accepted, build, counted);
  if (!judgement.is_compared) {
    out << fmt::format("not compared: {} holds no counts of {}", file.generic_string(), build);
    for (const auto& [other, counts] : accepted) out << fmt::format("\n  but of {}", other);
    out << fmt::format("; accept those above: {}\n", kAccept);
    return kNotCompared;
  }
  for (const std::string& line : judgement.fallen) out << fmt::format("fallen: {}; accept it: {}\n", line, kAccept);
  for (const std::string& line : judgement.red) out << fmt::format("RED {}\n", line);
  out << fmt::format("{}: {} jobs of {}, {} red\n", file.generic_string(), counted.size(), build, judgement.red.size());
  return judgement.red.empty() ? 0 : 1;
}

void accept_counts(const fs::path& folder, const fs::path& file, const std::string& reason, std::ostream& out) {
  Accepted accepted = fs::exists(file) ? parse_accepted(read_text_file(file), file.string()) : Accepted{};
  const std::string build = build_of_program();
  Counts& old = accepted[build];
  const Counts counted = read_counts(folder);
  std::string changes;
  for (const auto& [job, count] : counted) {
    const auto known = old.find(job);
    if (known == old.end()) changes += fmt::format("  {}: new: {}\n", job, words_of(count));
    if (known == old.end() || known->second == count) continue;
    changes += fmt::format("  {}: old: {}\n  {}  new: {}\n", job, words_of(known->second), std::string(job.size(), ' '),
                           words_of(count));
  }
  for (const auto& [job, count] : old) {
    if (!counted.contains(job)) changes += fmt::format("  {}: gone: {}\n", job, words_of(count));
  }
  old = counted;
  compare::write_file(file, format_accepted(accepted));
  compare::nightly::write_down(file, compare::origin_of_program(), reason, changes);
  out << changes << fmt::format("{}: {} jobs of {} accepted\n", file.generic_string(), counted.size(), build);
}

}  // namespace concord::benchmarks
