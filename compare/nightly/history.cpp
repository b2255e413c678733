#include "compare/nightly/history.h"

#include <fmt/format.h>

#include "common/error.h"
#include "compare/nightly/cluster.h"
#include "compare/nightly/process.h"
#include "compare/report/whole_number.h"

namespace concord::compare::nightly {

namespace {

constexpr long kApplication = 0x636f6e63;  // "conc"

/// The first version, as it was.
constexpr const char* kFirstSchema = R"(
CREATE TABLE night(id INTEGER PRIMARY KEY AUTOINCREMENT, suite TEXT NOT NULL, started TEXT NOT NULL,
                   finished TEXT NOT NULL DEFAULT '', version TEXT NOT NULL, compiler TEXT NOT NULL,
                   machine TEXT NOT NULL);
CREATE TABLE result(id INTEGER PRIMARY KEY, night INTEGER NOT NULL REFERENCES night(id), name TEXT NOT NULL,
                    work TEXT NOT NULL, ending TEXT NOT NULL, words TEXT NOT NULL, judged INTEGER NOT NULL,
                    total INTEGER NOT NULL, steps_cartesian INTEGER NOT NULL, steps_relative INTEGER NOT NULL,
                    evaluations_cartesian INTEGER NOT NULL, evaluations_relative INTEGER NOT NULL, wall_s REAL NOT NULL,
                    UNIQUE(night, name));
CREATE TABLE component(result INTEGER NOT NULL REFERENCES result(id) ON DELETE CASCADE, name TEXT NOT NULL,
                       same_state REAL, resolvable REAL, same_run REAL, refined REAL, peak REAL, scale REAL,
                       PRIMARY KEY(result, name)) WITHOUT ROWID;
)";

/// Each brings the version before it up to the next.
constexpr const char* kMigrations[] = {R"(
ALTER TABLE night ADD COLUMN suite_file TEXT NOT NULL DEFAULT '';
ALTER TABLE night ADD COLUMN commit_words TEXT NOT NULL DEFAULT 'unknown';
ALTER TABLE night ADD COLUMN process TEXT NOT NULL DEFAULT '';
ALTER TABLE result ADD COLUMN definition TEXT NOT NULL DEFAULT '';
ALTER TABLE result ADD COLUMN integrator_cartesian TEXT NOT NULL DEFAULT '';
ALTER TABLE result ADD COLUMN integrator_relative TEXT NOT NULL DEFAULT '';
ALTER TABLE result ADD COLUMN processor_s REAL NOT NULL DEFAULT 0;
ALTER TABLE component ADD COLUMN need_same_state REAL NOT NULL DEFAULT 0;
ALTER TABLE component ADD COLUMN need_same_run REAL NOT NULL DEFAULT 0;
ALTER TABLE component ADD COLUMN need_refined REAL NOT NULL DEFAULT 0;
CREATE INDEX result_by_name ON result(name, night);
)",
                                       R"(
ALTER TABLE night ADD COLUMN only_cases TEXT NOT NULL DEFAULT '';
)"};
static_assert(std::size(kMigrations) + 1 == kHistoryFormat);

#define CONCORD_NIGHT_COLUMNS                                                                                   \
  "night.id, night.suite, night.suite_file, night.started, night.finished, night.version, night.commit_words, " \
  "night.compiler, night.machine, night.only_cases"
constexpr int kNightColumns = 10;
#define CONCORD_RESULT_COLUMNS                                                                          \
  "result.id, result.name, work, ending, words, judged, total, integrator_cartesian, steps_cartesian, " \
  "evaluations_cartesian, integrator_relative, steps_relative, evaluations_relative, wall_s, processor_s, definition"
constexpr int kResultColumns = 16;

Night night_of(const Statement& row) {
  return {row.whole(0), row.text(1), row.text(2),
          row.text(3),  row.text(4), {row.text(5), row.text(6), row.text(7), row.text(8)},
          row.text(9)};
}

}  // namespace

const Night& night_called(const std::string& name, const std::vector<Night>& nights) {
  constexpr std::size_t kLeastOfCommit = 4;
  if (nights.empty()) throw InputError({name, 0, 0}, "the history holds no night");
  if (name.starts_with("last")) {
    const std::string back = name.starts_with("last-") ? name.substr(5) : name == "last" ? "0" : "";
    const auto number = whole_text_as<std::size_t>(back);
    if (number && *number < nights.size()) return nights[nights.size() - 1 - *number];
  }
  for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
    if (fmt::format("{}", night->id) == name) return *night;
  }
  for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
    if (night->origin.commit == name) return *night;
  }
  for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
    if (name.size() >= kLeastOfCommit && night->origin.commit.starts_with(name)) return *night;
  }
  throw InputError({name, 0, 0},
                   fmt::format("is no file, and the history has no such night: it has {} to {}; \"last\" is the last, "
                               "\"last-1\" the one before; or give a commit or its beginning, {} letters at least",
                               nights.front().id, nights.back().id, kLeastOfCommit));
}

/// Used for every case: prepared once.
struct History::Statements {
  explicit Statements(Database& database)
      : forget(database, "DELETE FROM result WHERE night = ? AND name = ?"),
        add_result(database,
                   "INSERT INTO result(night, name, work, ending, words, judged, total, integrator_cartesian,"
                   " steps_cartesian, evaluations_cartesian, integrator_relative, steps_relative, evaluations_relative,"
                   " wall_s, processor_s, definition) VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
        add_component(database,
                      "INSERT INTO component(result, name, same_state, resolvable, same_run, refined, need_same_state,"
                      " need_same_run, need_refined, peak, scale) VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
        find(database, "SELECT " CONCORD_RESULT_COLUMNS " FROM result WHERE night = ? AND name = ?"),
        components(database,
                   "SELECT name, same_state, resolvable, same_run, refined, need_same_state, need_same_run,"
                   " need_refined, peak, scale FROM component WHERE result = ? ORDER BY name"),
        before(database, "SELECT " CONCORD_NIGHT_COLUMNS ", " CONCORD_RESULT_COLUMNS
                         " FROM result JOIN night ON night.id = result.night WHERE result.name = ? AND night.suite = ?"
                         " AND night.id < ? AND night.finished <> '' ORDER BY night.id DESC LIMIT ?") {}

  Statement forget;
  Statement add_result;
  Statement add_component;
  Statement find;
  Statement components;
  Statement before;
};

History::History(const std::filesystem::path& file, Access access)
    : database_(file, access), statements_(nullptr, nullptr) {
  // First the schema: it is there only if the two others were committed with it.
  const bool is_new = database_.pragma("schema_version") == 0;
  const long application = database_.pragma("application_id");
  const long version = database_.pragma("user_version");
  if (!is_new && application != kApplication) {
    throw InputError({file.string(), 0, 0}, "is no history: it is a SQLite file of another program");
  }
  if (version > kHistoryFormat) {
    throw InputError({file.string(), 0, 0},
                     fmt::format("version {} of the history is not known: this program reads versions 1 to {}", version,
                                 kHistoryFormat));
  }
  if (!database_.is_writable() && version < kHistoryFormat) {
    throw InputError({file.string(), 0, 0},
                     fmt::format("is a history of version {}, which must be brought to version {} first by somebody "
                                 "who may write it: any command that reads it does",
                                 version, kHistoryFormat));
  }
  if (database_.is_writable()) database_.use_write_ahead_log();
  if (version < kHistoryFormat) prepare();
  statements_ = {new Statements(database_), [](Statements* statements) { delete statements; }};
}

/// Another program may do the same at the same time: the version is looked at again inside the transaction.
void History::prepare() {
  Transaction transaction(database_);
  long version = database_.pragma("user_version");
  if (version == 0) {
    database_.execute(kFirstSchema);
    database_.execute(fmt::format("PRAGMA application_id = {}", kApplication));
    version = 1;
  }
  for (; version < kHistoryFormat; ++version) database_.execute(kMigrations[version - 1]);
  database_.execute(fmt::format("PRAGMA user_version = {}", kHistoryFormat));
  transaction.commit();
}

long History::begin(const std::string& suite, const std::string& suite_file, const Origin& origin,
                    const std::string& now, const std::string& only) {
  Transaction transaction(database_);
  Statement(database_,
            "INSERT INTO night(suite, suite_file, started, version, commit_words, compiler, machine, process,"
            " only_cases) VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(suite)
      .bind(suite_file)
      .bind(now)
      .bind(origin.version)
      .bind(origin.commit)
      .bind(origin.compiler)
      .bind(origin.machine)
      .bind(this_process())
      .bind(only)
      .run();
  const long night = database_.last_row();
  transaction.commit();
  return night;
}

std::optional<Night> History::stopped_night(const std::string& suite, const Origin& origin) {
  Statement last(database_,
                 "SELECT " CONCORD_NIGHT_COLUMNS ", process FROM night WHERE suite = ? ORDER BY id DESC LIMIT 1");
  if (!last.bind(suite).step()) return std::nullopt;
  Night night = night_of(last);
  Origin same = origin;
  if (is_cluster_machine(night.origin.machine)) same.machine = night.origin.machine;
  if (!night.finished.empty() || night.origin != same || is_running(last.text(kNightColumns))) return std::nullopt;
  return night;
}

void History::take_over(long night, const std::string& process) {
  Transaction transaction(database_);
  Statement(database_, "UPDATE night SET process = ? WHERE id = ?")
      .bind(process.empty() ? this_process() : process)
      .bind(night)
      .run();
  transaction.commit();
}

void History::ask_for_all(long night) {
  Statement(database_, "UPDATE night SET only_cases = '' WHERE id = ?").bind(night).run();
}

std::string History::process_of(long night) {
  Statement row(database_, "SELECT process FROM night WHERE id = ?");
  return row.bind(night).step() ? row.text(0) : "";
}

void History::withdraw(long night) {
  Transaction transaction(database_);
  Statement(database_, "DELETE FROM result WHERE night = ?").bind(night).run();
  Statement(database_, "DELETE FROM night WHERE id = ?").bind(night).run();
  transaction.commit();
}

void History::finish(long night, const std::string& now) {
  Transaction transaction(database_);
  Statement(database_, "UPDATE night SET finished = ? WHERE id = ?").bind(now).bind(night).run();
  transaction.commit();
}

void History::copy_to(const std::filesystem::path& file) {
  Statement(database_, "VACUUM INTO ?").bind(file.string()).run();
}

void History::store(long night, const Result& result) {
  Transaction transaction(database_);
  statements_->forget.bind(night).bind(result.id).run();
  statements_->add_result.bind(night)
      .bind(result.id)
      .bind(result.work)
      .bind(to_string(result.ending))
      .bind(result.words)
      .bind(result.judged)
      .bind(result.total)
      .bind(result.cost[0].integrator)
      .bind(result.cost[0].steps)
      .bind(result.cost[0].evaluations)
      .bind(result.cost[1].integrator)
      .bind(result.cost[1].steps)
      .bind(result.cost[1].evaluations)
      .bind(result.wall_s)
      .bind(result.processor_s)
      .bind(result.definition)
      .run();
  const long row = database_.last_row();
  for (const Component& one : result.components) {
    statements_->add_component.bind(row)
        .bind(one.name)
        .bind(one.same_state)
        .bind(one.resolvable)
        .bind(one.same_run)
        .bind(one.refined)
        .bind(one.need[0])
        .bind(one.need[1])
        .bind(one.need[2])
        .bind(one.peak)
        .bind(one.scale)
        .run();
  }
  transaction.commit();
}

std::map<std::string, std::string> History::definitions(long night) {
  std::map<std::string, std::string> all;
  Statement rows(database_, "SELECT name, definition FROM result WHERE night = ? AND ending <> 'not run'");
  rows.bind(night);
  while (rows.step()) all.emplace(rows.text(0), rows.text(1));
  return all;
}

std::optional<Result> History::find(long night, const std::string& id) {
  Statement& row = statements_->find;
  if (!row.bind(night).bind(id).step()) return std::nullopt;
  Result result = read_result(row);
  result.components = components_of(row.whole(0));
  row.reset();
  return result;
}

std::vector<Night> History::nights(const std::string& suite) {
  std::vector<Night> all;
  Statement rows(database_, "SELECT " CONCORD_NIGHT_COLUMNS " FROM night WHERE ?1 = '' OR suite = ?1 ORDER BY id");
  rows.bind(suite);
  while (rows.step()) all.push_back(night_of(rows));
  return all;
}

std::vector<Entry> History::before(long night, const std::string& suite, const std::string& id, int count) {
  statements_->before.bind(id).bind(suite).bind(night).bind(count);
  return entries(statements_->before);
}

std::vector<Entry> History::of_case(const std::string& suite, const std::string& id, int count) {
  Statement rows(database_, "SELECT " CONCORD_NIGHT_COLUMNS ", " CONCORD_RESULT_COLUMNS
                            " FROM result JOIN night ON night.id = result.night WHERE result.name = ?"
                            " AND night.suite = ? ORDER BY night.id DESC LIMIT ?");
  rows.bind(id).bind(suite).bind(count);
  return entries(rows);
}

std::vector<std::string> History::suites_of_case(const std::string& id) {
  std::vector<std::string> suites;
  Statement rows(database_,
                 "SELECT suite FROM result JOIN night ON night.id = result.night WHERE result.name = ?"
                 " GROUP BY suite ORDER BY max(night.id) DESC");
  rows.bind(id);
  while (rows.step()) suites.push_back(rows.text(0));
  return suites;
}

std::map<std::string, double> History::wall_times(const std::string& suite) {
  std::map<std::string, double> times;
  Statement rows(database_,
                 "SELECT name, wall_s FROM result WHERE night ="
                 " (SELECT max(id) FROM night WHERE suite = ? AND finished <> '')");
  rows.bind(suite);
  while (rows.step()) times.emplace(rows.text(0), rows.real(1));
  return times;
}

std::vector<std::string> History::case_names() {
  std::vector<std::string> names;
  Statement rows(database_, "SELECT DISTINCT name FROM result ORDER BY name");
  while (rows.step()) names.push_back(rows.text(0));
  return names;
}

std::vector<std::string> History::case_names(long night) {
  std::vector<std::string> names;
  Statement rows(database_, "SELECT name FROM result WHERE night = ? ORDER BY name");
  rows.bind(night);
  while (rows.step()) names.push_back(rows.text(0));
  return names;
}

std::vector<Entry> History::entries(Statement& rows) {
  std::vector<Entry> all;
  while (rows.step()) {
    Entry& entry = all.emplace_back(Entry{night_of(rows), {}});
    entry.result = read_result(rows);
    entry.result.components = components_of(rows.whole(kNightColumns));
  }
  return all;
}

/// The result's columns are the last ones of a row.
Result History::read_result(const Statement& row) {
  const int first = row.columns() - kResultColumns;
  Result result;
  result.id = row.text(first + 1);
  result.work = row.text(first + 2);
  result.ending = ending_of(row.text(first + 3));
  result.words = row.text(first + 4);
  result.judged = static_cast<int>(row.whole(first + 5));
  result.total = static_cast<int>(row.whole(first + 6));
  for (int who = 0; who < 2; ++who) {
    const int at = first + 7 + 3 * who;
    result.cost[who] = {row.text(at), row.whole(at + 1), row.whole(at + 2)};
  }
  result.wall_s = row.real(first + 13);
  result.processor_s = row.real(first + 14);
  result.definition = row.text(first + 15);
  return result;
}

std::vector<Component> History::components_of(long result) {
  std::vector<Component> all;
  Statement& row = statements_->components;
  row.bind(result);
  while (row.step()) {
    Component& one = all.emplace_back();
    one.name = row.text(0);
    one.same_state = row.optional_real(1);
    one.resolvable = row.optional_real(2);
    one.same_run = row.optional_real(3);
    one.refined = row.optional_real(4);
    one.need = {row.real(5), row.real(6), row.real(7)};
    one.peak = row.optional_real(8);
    one.scale = row.real(9);
  }
  return all;
}

}  // namespace concord::compare::nightly
