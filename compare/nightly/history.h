#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/nightly/database.h"
#include "compare/nightly/result.h"
#include "compare/report/origin.h"

/// What nights found, kept for ever in a SQLite file.
namespace concord::compare::nightly {

inline constexpr int kHistoryFormat = 3;

struct Night {
  long id = 0;
  std::string suite;       // its name
  std::string suite_file;  // where it lay
  std::string started;     // "2026-11-22 23:14:05", UTC
  std::string finished;    // empty: it was stopped, or is running
  Origin origin;
  std::string only = {};  // the pattern of the cases that were asked for; empty: all
};

/// A case in one night.
struct Entry {
  Night night;
  Result result;
};

/// One transaction for each case: a program that is killed loses the case that it runs, and programs that write the
/// same file do not harm each other. Functions throw DatabaseError.
class History {
 public:
  /// Opens or creates the file; one of an older version is brought up to date. Throws InputError for a file that is no
  /// history or was written by a later version, or, to be read, is not there. Who may not write it can read it all the
  /// same.
  explicit History(const std::filesystem::path& file, Access access = Access::write);

  /// Begins a night of this process: of all cases, or those that `only` means.
  long begin(const std::string& suite, const std::string& suite_file, const Origin& origin, const std::string& now,
             const std::string& only = "");
  /// The suite's last night, if it was stopped, was done by the same program on the same machine or on a cluster, and
  /// no process or job that is still running does it.
  std::optional<Night> stopped_night(const std::string& suite, const Origin& origin);
  /// From now on this process does the night, or the one that is named.
  void take_over(long night, const std::string& process = "");
  /// From now on the night is one of all cases.
  void ask_for_all(long night);
  /// Which does it, or did it last.
  std::string process_of(long night);
  /// As if it had never begun.
  void withdraw(long night);
  void finish(long night, const std::string& now);

  /// All of it in a new file.
  void copy_to(const std::filesystem::path& file);

  /// Stores a case; what the night had of it before is replaced.
  void store(long night, const Result& result);
  /// Definitions of the cases that a night has run, by name.
  std::map<std::string, std::string> definitions(long night);
  std::optional<Result> find(long night, const std::string& id);

  /// All nights, or those of one suite, the earliest first.
  std::vector<Night> nights(const std::string& suite = "");
  /// A case in the last `count` finished nights of the suite before `night`, the latest first.
  std::vector<Entry> before(long night, const std::string& suite, const std::string& id, int count);
  /// A case in the last `count` nights of a suite, the latest first.
  std::vector<Entry> of_case(const std::string& suite, const std::string& id, int count);
  /// The suites in whose nights a case of this name is, the one of the latest night first.
  std::vector<std::string> suites_of_case(const std::string& id);
  /// Wall time of each case in the suite's last finished night [s].
  std::map<std::string, double> wall_times(const std::string& suite);
  /// Names of all cases that were ever stored, or of those of one night; sorted.
  std::vector<std::string> case_names();
  std::vector<std::string> case_names(long night);

 private:
  void prepare();
  Result read_result(const Statement& row);
  std::vector<Component> components_of(long result);
  std::vector<Entry> entries(Statement& rows);

  Database database_;
  struct Statements;
  std::unique_ptr<Statements, void (*)(Statements*)> statements_;
};

/// The night of this number, "last", "last-1", ..., or the last one of this commit, else the last one whose commit
/// begins so (four letters at least). `nights`: the earliest first. Throws InputError if there is none.
const Night& night_called(const std::string& name, const std::vector<Night>& nights);

}  // namespace concord::compare::nightly
