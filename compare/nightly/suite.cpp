#include "compare/nightly/suite.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <glob.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "common/reading/spelling.h"
#include "common/reading/text_file.h"
#include "common/reading/toml_document.h"
#include "common/reading/toml_reader.h"
#include "compare/joint_check/coupling_check.h"
#include "compare/nightly/baseline.h"
#include "compare/nightly/case_tables.h"
#include "compare/nightly/variants.h"
#include "compare/random_machines/generator.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

constexpr int kSuiteFormat = 1;
constexpr double kMostCases = 100000.0;

/// Keeps the characters of a path from meaning anything in a pattern.
std::string escape_pattern(const std::string& path) {
  std::string text;
  for (const char c : path) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) text += '\\';
    text += c;
  }
  return text;
}

bool has_wildcards(const std::string& pattern) { return pattern.find_first_of("*?[\\") != std::string::npos; }

/// Files that a pattern beside the suite means, sorted.
std::vector<fs::path> files_of(const fs::path& folder, const std::string& pattern) {
  const std::string whole =
      fs::path(pattern).is_absolute() || folder.empty() ? pattern : escape_pattern(folder.string()) + '/' + pattern;
  std::vector<fs::path> files;
  glob_t found{};
  if (glob(whole.c_str(), 0, nullptr, &found) == 0) {
    for (std::size_t k = 0; k < found.gl_pathc; ++k) files.emplace_back(found.gl_pathv[k]);
  }
  globfree(&found);
  std::sort(files.begin(), files.end());
  return files;
}

/// What is not given is as `usual`.
Allowance read_allowance(const TableReader& table, const Allowance& usual) {
  return {table.positive_number("margin").value_or(usual.margin), table.positive_number("cost").value_or(usual.cost),
          table.positive_number("peak").value_or(usual.peak)};
}

Judging read_judging(const TableReader& document) {
  Judging judging;
  const toml::table* found = document.table("judge");
  if (found == nullptr) return judging;
  const TableReader table(*found, "judge", {"margin", "cost", "peak", "nights", "against"}, document.reading());
  judging.allowance = read_allowance(table, judging.allowance);
  judging.nights = table.count("nights", 1, 1000).value_or(judging.nights);
  const std::string against = table.text("against").value_or("baseline");
  judging.against_baseline = against == "baseline" || against == "both";
  judging.against_median = against == "median" || against == "both";
  if (!judging.against_baseline && !judging.against_median) {
    table.complain("against", fmt::format("'against' is \"baseline\", \"median\" or \"both\", found \"{}\"", against));
  }
  return judging;
}

/// Reads a suite file and gives its cases different names.
class SuiteReader {
 public:
  SuiteReader(const fs::path& file, Suite& suite) : suite_(&suite) { reading_.file = file.generic_string(); }

  void read() {
    const toml::table root = parse_toml(read_text_file(suite_->file), reading_.file);
    const TableReader document(root, "", {"format", "name", "baselines", "seconds", "megabytes", "judge", "case"},
                               reading_);
    check_format(document, kSuiteFormat);
    check_name(document);
    suite_->name = document.text("name").value_or(suite_->file.stem().string());
    suite_->baselines = suite_->file.parent_path() /
                        document.text("baselines").value_or("baselines/" + suite_->file.stem().string() + ".csv");
    if (suite_->baselines == log_of(suite_->baselines)) {
      document.complain("baselines", "must not end in .log: there it is written down what was accepted");
    }
    limits_.seconds = document.positive_number("seconds").value_or(600.0);
    limits_.wall_per_processor = 5.0;  // a case that sleeps must not cost the night
    limits_.megabytes = document.positive_number("megabytes").value_or(4096.0);
    suite_->judging = read_judging(document);
    if (document.tables("case").empty()) document.complain("there is no case: write at least one [[case]]");
    for (const toml::table* table : document.tables("case")) read_case(*table);
    reading_.throw_if_any();
    std::sort(suite_->cases.begin(), suite_->cases.end(), [](const Case& a, const Case& b) { return a.id < b.id; });
  }

 private:
  void read_case(const toml::table& found) {
    const TableReader table(found, title_with_name(found, "case"), case_keys(), reading_);
    const Case base = read_common(table);
    const std::size_t before = suite_->cases.size();
    switch (base.work) {
      case Work::joint:
        add_joints(table, base);
        break;
      case Work::fuzz:
        add_fuzz_shares(table, base);
        break;
      default:
        add_models(table, base);
    }
    read_own_allowance(table, before);
  }

  /// That of the cases from `first` on, if they have one.
  void read_own_allowance(const TableReader& table, std::size_t first) {
    const auto own = inner_table(table, "judge", {"margin", "cost", "peak"});
    if (!own) return;
    const Allowance allowance = read_allowance(*own, suite_->judging.allowance);
    for (std::size_t k = first; k < suite_->cases.size(); ++k) {
      suite_->judging.of_case.emplace(suite_->cases[k].id, allowance);
    }
  }

  /// Names of suites and cases stand in tables and in the files of baselines and histories.
  static void check_name(const TableReader& table) {
    const auto name = table.text("name");
    const auto is_control = [](unsigned char c) { return std::iscntrl(c) != 0; };
    if (!name || (!name->empty() && std::none_of(name->begin(), name->end(), is_control))) return;
    table.complain("name", fmt::format("'name' must be one line that is not empty, found {:?}", *name));
  }

  Case read_common(const TableReader& table) {
    check_name(table);
    Case base;
    const std::string work = table.text("work").value_or("compare");
    const auto& names = work_names();
    const auto known = std::find(names.begin(), names.end(), work);
    if (known == names.end()) {
      table.complain("work", fmt::format("no work '{}': {}", work, suggestion(work, names, "kinds of work")));
    } else {
      base.work = static_cast<Work>(known - names.begin());
      refuse_keys_without_meaning(table, base.work);
    }
    base.where = table.where();
    base.limits = limits_;
    base.limits.seconds = table.positive_number("seconds").value_or(limits_.seconds);
    base.limits.megabytes = table.positive_number("megabytes").value_or(limits_.megabytes);
    base.known_red = read_known_red(table);
    return base;
  }

  void read_run(const TableReader& table, Case& base) {
    base.options.until = table.positive_number("until");
    base.options.rtol = table.positive_number("rtol");
    if (base.options.rtol && !(*base.options.rtol >= kTightestTolerance && *base.options.rtol <= kLoosestTolerance)) {
      table.complain("rtol",
                     fmt::format("'rtol' must lie between {:g} and {:g}", kTightestTolerance, kLoosestTolerance));
    }
    base.options.samples = table.count("samples", 1, 1000000);
    base.options.states = table.count("states", 1, 1000000);
    base.options.integrators = {table.text("cartesian").value_or(""), table.text("relative").value_or("")};
    base.needs = read_case_needs(table);
    const std::string at = table.text("at").value_or("start");
    base.at_equilibrium = at == "equilibrium";
    if (at != "start" && at != "equilibrium") {
      table.complain("at", fmt::format("'at' is \"start\" or \"equilibrium\", found \"{}\"", at));
    }
    base.accelerations = read_accelerations(table);
    base.cut = read_texts(table, "cut");
    each_name(table, "parameters", [&](const TableReader& values, std::string_view name) {
      if (const auto value = values.number(name)) base.parameters.emplace_back(name, *value);
    });
  }

  /// A file that is not there is a case, too, which is refused as it is run: it does not cost the night.
  [[nodiscard]] std::vector<fs::path> models_of(const TableReader& table) const {
    std::set<fs::path> models;
    const fs::path folder = suite_->file.parent_path();
    for (const std::string& pattern : read_texts(table, "models").value_or(std::vector<std::string>())) {
      std::vector<fs::path> found = files_of(folder, pattern);
      if (found.empty() && !has_wildcards(pattern)) found = {folder / pattern};
      if (found.empty()) table.complain("models", fmt::format("there is no file '{}'", pattern));
      models.insert(found.begin(), found.end());
    }
    const bool had_any = !models.empty();
    for (const std::string& pattern : read_texts(table, "except").value_or(std::vector<std::string>())) {
      const std::vector<fs::path> found = files_of(folder, pattern);
      if (found.empty()) table.complain("except", fmt::format("there is no file '{}'", pattern));
      for (const fs::path& one : found) models.erase(one);
    }
    if (had_any && models.empty()) table.complain("except", "leaves none of the files that 'models' names");
    return {models.begin(), models.end()};
  }

  void add_models(const TableReader& table, Case base) {
    read_run(table, base);
    if (!table.require({"models"})) return;
    const std::vector<fs::path> models = models_of(table);
    const Sweep sweep = read_sweep(table);
    const std::string name = table.text("name").value_or("");
    for (const fs::path& model : models) {
      require_parameters(table, model, base, sweep);
      base.model = model;
      base.id = model.stem().string();
      if (!name.empty()) base.id = models.size() == 1 ? name : name + '/' + base.id;
      if (name.empty() && base.work != Work::compare) {
        base.id = fmt::format("{}/{}", name_of(base.work), base.id);
      }
      if (sweep.combinations() + static_cast<double>(suite_->cases.size()) > kMostCases) {
        return table.complain(fmt::format("more than {:g} cases in one suite", kMostCases));
      }
      for (Case& variant : variants_of(base, sweep)) add(table, std::move(variant));
    }
  }

  void add_joints(const TableReader& table, Case base) {
    const std::vector<std::string> known = joint_check::subject_names();
    base.poses = table.count("poses", 1, 10000).value_or(base.poses);
    std::vector<std::string> names = known;
    if (table.has("joints")) names = read_texts(table, "joints").value_or(std::vector<std::string>());
    for (const std::string& name : names) {
      if (std::find(known.begin(), known.end(), name) == known.end()) {
        table.complain("joints", fmt::format("no joint type '{}': {}", name, suggestion(name, known, "joint types")));
        continue;
      }
      base.joint = name;
      base.id = fmt::format("{}/{}", table.text("name").value_or("joint"), name);
      add(table, base);
    }
  }

  void add_fuzz_shares(const TableReader& table, Case base) {
    if (!table.require({"seed", "count"})) return;
    base.fuzz.seed = static_cast<std::uint64_t>(table.count("seed", 0).value_or(0));
    base.fuzz.style = table.text("style").value_or(base.fuzz.style);
    const auto& styles = fuzz::style_names();
    if (std::find(styles.begin(), styles.end(), base.fuzz.style) == styles.end()) {
      table.complain("style",
                     fmt::format("no style '{}': {}", base.fuzz.style, suggestion(base.fuzz.style, styles, "styles")));
    }
    const int first = table.count("first", 0).value_or(0);
    const int count = table.count("count", 1).value_or(1);
    const int shares = table.count("shares", 1, 10000).value_or(1);
    const std::string name = table.text("name").value_or(fmt::format("fuzz/seed={}", base.fuzz.seed));
    for (int k = 0; k < shares; ++k) {
      base.fuzz.first = static_cast<std::uint64_t>(first) + static_cast<std::uint64_t>(k) * count;
      base.fuzz.count = static_cast<std::uint64_t>(count);
      base.id = shares == 1 ? name : fmt::format("{}/first={}", name, base.fuzz.first);
      add(table, base);
    }
  }

  void add(const TableReader& table, Case one) {
    const auto [entry, is_new] = places_.emplace(one.id, Place{table.where(), one.model});
    if (is_new) {
      suite_->cases.push_back(std::move(one));
      return;
    }
    if (entry->second.where.line == table.where().line && entry->second.model != one.model) {
      table.complain("models", fmt::format("two of the models would be case '{}', one of them '{}': give it a [[case]] "
                                           "with a 'name' of its own",
                                           one.id, one.model.generic_string()));
    } else {
      table.complain(fmt::format("there is a case '{}' already (line {}): give one of them another name", one.id,
                                 entry->second.where.line));
    }
  }

  /// A misspelt parameter would change nothing, and every variant would agree.
  void require_parameters(const TableReader& table, const fs::path& model, const Case& base, const Sweep& sweep) {
    std::vector<std::string> asked;
    for (const auto& [name, value] : base.parameters) asked.push_back(name);
    for (const auto& [name, values] : sweep.parameters) asked.push_back(name);
    if (asked.empty()) return;
    const auto known = parameters_of(model);
    if (!known) return;  // the case is refused as it is run
    for (const std::string& name : asked) {
      if (std::find(known->begin(), known->end(), name) != known->end()) continue;
      table.complain(base.parameters.empty() ? "sweep" : "parameters",
                     fmt::format("'{}' has no parameter '{}': {}", model.generic_string(), name,
                                 suggestion(name, *known, "parameters")));
    }
  }

  /// Nothing if the model cannot be read.
  static std::optional<std::vector<std::string>> parameters_of(const fs::path& model) {
    std::vector<std::string> names;
    try {
      const toml::table root = parse_toml(read_text_file(model), model.generic_string());
      if (const toml::table* found = root["parameters"].as_table()) {
        for (const auto& [key, value] : *found) names.emplace_back(key.str());
      }
    } catch (const InputError&) {
      return std::nullopt;
    }
    return names;
  }

  Suite* suite_;
  FileReading reading_;
  workers::Limits limits_;
  struct Place {
    SourceLocation where;
    fs::path model;
  };
  std::map<std::string, Place> places_;  // of cases, by name
};

}  // namespace

const Allowance& Judging::allowance_of(const std::string& id) const {
  const auto own = of_case.find(id);
  return own == of_case.end() ? allowance : own->second;
}

Suite read_suite(const fs::path& file) {
  Suite suite;
  suite.file = file;
  SuiteReader(file, suite).read();
  return suite;
}

bool is_meant(std::string_view id, const std::string& pattern) {
  const std::string text(id);
  if (pattern.find_first_of("*?[") == std::string::npos) return text.find(pattern) != std::string::npos;
  return fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
}

}  // namespace concord::compare::nightly
