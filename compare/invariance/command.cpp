#include "compare/invariance/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>

#include "common/error.h"
#include "common/reading/model_file.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/invariance/report.h"
#include "compare/report/files.h"
#include "compare/report/interrupt.h"
#include "compare/report/result_folder.h"
#include "compare/report/text_table.h"
#include "compare/states/near_frames.h"
#include "compare/verdict/verdict.h"

namespace concord::compare::invariance {

namespace {

struct Tried {
  Model model;
  InvarianceChecks checks;
};

/// `names` holds the models tried so far.
Tried try_one(const std::filesystem::path& file, const InvarianceCommand& command, const SolverMakers& makers,
              const Console& console, std::set<std::string>& names) {
  const auto begin = std::chrono::steady_clock::now();
  Tried one{read_model(file), {}};
  if (!names.insert(one.model.name).second) {
    throw InputError(
        {file.string(), 0, 0},
        fmt::format("a model called '{}' was tried already: give one of them another name = \"...\"", one.model.name));
  }
  std::string note;
  const NearFrames near(one.model);
  one.model = as_it_starts(near.model(), makers, note);
  one.checks = check_invariance(one.model, makers, command.options);
  one.checks.notes.insert(one.checks.notes.end(), one.model.notes.begin(), one.model.notes.end());
  for (const std::string& one_note : {near.note(), note}) {
    if (!one_note.empty()) one.checks.notes.push_back(one_note);
  }
  console.out << format_checks(one.model, one.checks) << std::flush;
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  console.err << fmt::format("{}: wall time {:.2f} s\n", one.model.name, taken.count());
  note_finished(one.model.name);
  return one;
}

/// One line for each model, whatever became of it.
std::string format_all_checks(const std::vector<std::filesystem::path>& files,
                              const std::vector<std::optional<Tried>>& tried) {
  std::vector<std::vector<std::string>> lines{{"model", "moves", "nearest", "in move", "solver", "verdict"}};
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (!tried[k]) {
      lines.push_back({files[k].stem().string(), "-", "-", "-", "-", "no result"});
      continue;
    }
    const InvarianceChecks& checks = tried[k]->checks;
    const auto applied = std::count_if(checks.moves.begin(), checks.moves.end(),
                                       [](const MoveSummary& move) { return move.why_not.empty(); });
    const std::string moves = fmt::format("{} of {}", applied, checks.moves.size());
    const MoveRow* row = nearest_row(checks);
    if (row == nullptr) {
      lines.push_back({checks.name, moves, "-", "-", "-", to_string(checks.outcome)});
      continue;
    }
    lines.push_back({checks.name, moves, format_nearest(*row->nearest), checks.moves[row->move].name,
                     kSolverNames[static_cast<std::size_t>(index(row->who))], to_string(checks.outcome)});
  }
  return format_table(lines, {false, true, true, false, false, false});
}

void write_all_checks(const std::filesystem::path& file, const std::vector<std::optional<Tried>>& tried) {
  std::vector<std::pair<const Model*, const InvarianceChecks*>> found;
  for (const auto& one : tried) {
    if (one) found.emplace_back(&one->model, &one->checks);
  }
  if (!found.empty()) write_file(file, format_checks_json(found, tried.size() > 1));
}

}  // namespace

int try_invariance(const InvarianceCommand& command, const SolverMakers& makers, const Console& console) {
  const int prepared = guarded(console, [&] {
    check_output(command.json, command.models);
    if (!command.json.empty()) std::filesystem::remove(command.json);
  });
  if (prepared != kAgree) return prepared;
  std::vector<int> codes;
  std::vector<std::optional<Tried>> tried(command.models.size());
  std::set<std::string> names;
  for (std::size_t k = 0; k < command.models.size(); ++k) {
    if (k > 0) console.out << '\n';
    codes.push_back(guarded(console, [&] {
      tried[k] = try_one(command.models[k], command, makers, console, names);
      return exit_code(tried[k]->checks.outcome);
    }));
  }
  if (command.models.size() > 1) console.out << '\n' << format_all_checks(command.models, tried);
  if (!command.json.empty()) {
    codes.push_back(guarded(console, [&] { write_all_checks(command.json, tried); }));
  }
  return *std::max_element(codes.begin(), codes.end());
}

}  // namespace concord::compare::invariance
