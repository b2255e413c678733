#include "compare/program/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <set>
#include <sstream>

#include "common/reading/model_file.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/page/page.h"
#include "compare/program/progress_line.h"
#include "compare/quantities/not_expressible.h"
#include "compare/report/colours.h"
#include "compare/report/files.h"
#include "compare/report/force_table.h"
#include "compare/report/info.h"
#include "compare/report/interrupt.h"
#include "compare/report/junit.h"
#include "compare/report/plots.h"
#include "compare/report/report_json.h"
#include "compare/report/result_document.h"
#include "compare/report/result_folder.h"
#include "compare/report/start_text.h"
#include "compare/report/table.h"
#include "compare/report/text_table.h"
#include "compare/report/told_axes.h"
#include "compare/resolution/run_check.h"
#include "compare/states/stiff_choice.h"
#include "compare/verdict/reference.h"

namespace concord::compare {

namespace {

/// Empty words mean the frame of each side.
std::optional<int> axes_of(const std::string& words, const Model& model, const std::filesystem::path& file) {
  return words.empty() ? std::nullopt : std::optional(told_axes(model, words, file));
}

/// A model that was read, and what was found about it.
struct Case {
  Model model;
  Verdict verdict;
};

void write_results(const std::filesystem::path& folder, const Case& one, const std::string& table,
                   const Console& console) {
  StagedFolder staged(folder);
  write_file(staged.path() / (one.model.name + ".table.txt"), table);
  write_file(staged.path() / (one.model.name + ".result.json"), format_result(one.model, one.verdict));
  const auto& runs = one.verdict.trajectories;
  const std::array<std::string_view, 2> names{one.verdict.solvers[0].name, one.verdict.solvers[1].name};
  for (std::size_t who = 0; who < 2; ++who) {
    if (runs[who])
      write_run_files(staged.path(), one.model,
                      {names[who], &*runs[who], one.verdict.unique ? &*one.verdict.unique : nullptr, one.verdict.axes});
  }
  if (runs[0] && runs[1]) {
    const auto reason = plot_reactions(staged.path(), one.model, names, *runs[0], *runs[1], one.verdict.axes);
    if (reason) {
      console.err << fmt::format("{}: {}\n", one.model.name, *reason);
    }
  }
  staged.finish(result_file_names(one.model, {names[0], names[1]}));
}

void tell_wall_times(const Verdict& verdict, const Console& console) {
  console.err << fmt::format("{}: wall time of the same run", verdict.name);
  for (const SolverSummary& solver : verdict.solvers) {
    console.err << fmt::format(", {} {:.2f} s in {} steps, {} evaluations", solver.name, solver.statistics.wall_s,
                               solver.statistics.steps, solver.statistics.evaluations);
  }
  console.err << '\n';
}

/// The third opinion, if one is wanted and knows all of the model's parts; `silent` says why it does not.
std::unique_ptr<ThirdOpinion> ask_for_third(const CompareCommand& command, const Model& model,
                                            std::optional<ThirdReport>& silent) {
  if (!command.make_third) return nullptr;
  try {
    return command.make_third(model);
  } catch (const NotExpressible& reason) {
    silent.emplace();
    silent->name = command.third_name;
    silent->not_expressible = reason.what();
    return nullptr;
  }
}

InputFiles inputs_of(const CompareCommand& command) {
  std::vector<std::filesystem::path> inputs = command.models;
  if (!command.reference.empty()) inputs.push_back(command.reference);
  return inputs;
}

/// `inputs`: of the whole command.
void solve_both(const CompareCommand& command, const InputFiles& inputs, const SolverMakers& makers,
                const Console& console, Case& one) {
  std::optional<Reference> reference;
  if (!command.reference.empty()) {
    reference = read_reference(command.reference, one.model);
    check_times(*reference, run_options(one.model, command.options));
  }
  const StartedMachine machine(one.model, makers);
  Solver& cartesian = machine.solver(Who::cartesian);
  Solver& relative = machine.solver(Who::relative);
  check_results(command.out, result_file_names(one.model, {cartesian.name(), relative.name()}), inputs);
  VerifyOptions options = command.options;
  std::optional<ThirdReport> silent;
  const auto third = ask_for_third(command, machine.model(), silent);
  options.third = third.get();
  options.makers = &makers;
  {
    ComparisonProgress progress(console, one.model.name, options);
    options.progress = [&](std::string_view check, const std::array<double, 2>& done) { progress.show(check, done); };
    one.verdict = verify(machine.model(), cartesian, relative, options);
  }
  one.verdict.trajectories = machine.back(std::move(one.verdict.trajectories));
  one.verdict.start = start_of(one.model, machine, makers, SeekPoses::of_few_joints);
  if (silent) one.verdict.third = silent;
  one.verdict.notes.insert(one.verdict.notes.end(), machine.notes().begin(), machine.notes().end());
  if (reference) judge_reference(one.model, *reference, one.verdict);
}

/// `inputs`: of the whole command; `names` holds the models compared so far.
Case compare_one(const std::filesystem::path& file, const CompareCommand& command, const InputFiles& inputs,
                 const SolverMakers& makers, const Console& console, std::set<std::string>& names) {
  Case one;
  one.model = read_model(file);
  if (!names.insert(one.model.name).second) {
    throw InputError({file.string(), 0, 0},
                     fmt::format("a model called '{}' was compared already: give one of them another name = \"...\"",
                                 one.model.name));
  }
  const std::optional<int> axes = axes_of(command.axes, one.model, file);
  solve_both(command, inputs, makers, console, one);
  one.verdict.axes = axes;
  const std::string table = format_verdict(one.model, one.verdict, command.all_rows);
  console.out << shown(console, table) << std::flush;
  const bool has_run = one.verdict.trajectories[0] || one.verdict.trajectories[1];
  if (has_run && one.verdict.integrates) tell_wall_times(one.verdict, console);
  if (!command.out.empty()) write_results(command.out, one, table, console);
  note_finished(one.model.name);
  return one;
}

const char* meaning(int code) {
  constexpr std::array kMeanings{"agree", "differ", "bad input", "could not finish"};
  return kMeanings.at(static_cast<std::size_t>(code));
}

/// One line for each model, whatever became of it.
std::string format_summary(const std::vector<std::filesystem::path>& files, const std::vector<int>& codes,
                           const std::vector<std::optional<Case>>& cases) {
  std::vector<std::vector<std::string>> lines{
      {"model", "judged", "same state", "same run", "refined", "audit", "verdict"}};
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (!cases[k]) {
      lines.push_back({files[k].stem().string(), "-", "-", "-", "-", "-", meaning(codes[k])});
      continue;
    }
    const Verdict& verdict = cases[k]->verdict;
    const ComponentCount count = count_components(verdict);
    lines.push_back({verdict.name, fmt::format("{} of {}", count.judged, count.total),
                     digits_cell(verdict.same_state.digits), digits_cell(verdict.same_run.digits),
                     digits_cell(verdict.refined.digits), digits_cell(verdict.audit.digits), meaning(codes[k])});
  }
  return format_table(lines, {false, true, true, true, true, true, false});
}

/// guarded(), and keeps what was said.
template <class Work>
int guarded_aloud(const Console& console, std::string& said, const Work& work) {
  std::ostringstream heard;
  const int code = guarded({console.out, heard, console.progress, console.colours}, work);
  said = heard.str();
  console.err << said;
  return code;
}

void require_one_model(const CompareCommand& command) {
  if (command.reference.empty() || command.models.size() == 1) return;
  throw InputError({command.reference.string(), 0, 0},
                   fmt::format("a reference belongs to one model, but {} are compared", command.models.size()));
}

/// `names`: those of the models that were compared.
std::vector<ReportedCase> reported_cases(const std::vector<std::filesystem::path>& files, const std::vector<int>& codes,
                                         const std::vector<std::optional<Case>>& cases,
                                         const std::vector<std::string>& troubles, std::set<std::string> names) {
  std::vector<ReportedCase> all;
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (cases[k]) {
      all.push_back({cases[k]->verdict.name, &cases[k]->model, &cases[k]->verdict, ""});
      continue;
    }
    std::string name = files[k].stem().string();
    if (!names.insert(name).second) name = files[k].string();
    all.push_back({name, nullptr, nullptr, troubles[k], codes[k] == kBadInput});
  }
  return all;
}

/// Of a single model that is refused nothing is written.
void write_json(const std::filesystem::path& file, const std::vector<ReportedCase>& cases) {
  if (cases.size() > 1) return write_file(file, format_json(cases));
  if (!cases.front().is_bad_input) write_file(file, format_json(cases.front()));
}

/// A file of its own among the results of a folder would replace one of theirs.
void refuse_name_of_result(const std::filesystem::path& target, const std::filesystem::path& out) {
  if (target.empty() || out.empty() || !is_same_file(std::filesystem::absolute(target).parent_path(), out)) return;
  const std::string name = target.filename().string();
  for (const std::string& ending : result_file_names(Model{}, {"cartesian", "relative"})) {
    if (!name.ends_with(ending)) continue;
    throw InputError({target.string(), 0, 0},
                     fmt::format("cannot be written: files of --out end in {}, choose another name", ending));
  }
}

/// Refuses what cannot be written, and removes what an earlier run wrote there.
void prepare_outputs(const CompareCommand& command, const InputFiles& inputs) {
  check_outputs({command.json, command.junit, command.report}, inputs);
  for (const auto& target : {command.json, command.junit, command.report}) refuse_name_of_result(target, command.out);
  if (!command.out.empty()) check_target_folder(command.out);
  for (const auto& stale : {command.json, command.junit, command.report}) {
    if (!stale.empty()) std::filesystem::remove(stale);
  }
}

void tell(const std::vector<std::string>& notes, const Console& console) {
  for (const std::string& note : notes) console.out << fmt::format("note: {}\n", note);
}

/// A run by one solver alone.
struct DoneRun {
  std::string_view solver;
  Trajectory trajectory;
  RunCheck check;
};

/// Integrates and prints; `given`: the model as it was read.
DoneRun run_by(Solver& solver, const RunCommand& command, const Model& given, const std::optional<int>& axes,
               const StartedMachine& machine, const Console& console) {
  const Model& model = machine.model();
  RunOptions run = run_options(model, command.options);
  run.integrator = chosen_integrator(model, solver, command.integrator);
  DoneRun done{solver.name(), {}, {}};
  Trajectory& trajectory = done.trajectory;
  MadeBy made_by;
  {
    ProgressLine line(console);
    const auto show = [&](double t) {
      line.show(fmt::format("{}: {} {} %", model.name, solver.name(), percent(t / run.until)));
    };
    trajectory = integrate_or_switch(solver, run, command.integrator.empty(), show, made_by);
    run.integrator = made_by.integrator;
  }
  console.out << fmt::format("{}: {} by {}, {:g} s, {} samples, rtol {:g}, {} steps, {} evaluations\n\n", model.name,
                             solver.name(), run.integrator, run.until, trajectory.samples.size(), run.rtol,
                             trajectory.statistics.steps, trajectory.statistics.evaluations);
  std::vector<std::string> notes = machine.notes();
  if (!made_by.note.empty()) notes.push_back(made_by.note);
  tell(notes, console);
  const QuantityLayout layout(model);
  done.check = check_run(layout, solver, trajectory, run);
  trajectory = machine.back(std::move(trajectory));
  console.out << format_peaks(given, trajectory, &done.check.unique, axes)
              << format_run_check(layout, solver.name(), done.check);
  console.err << fmt::format("{}: wall time {:.2f} s\n", model.name, trajectory.statistics.wall_s);
  return done;
}

}  // namespace

int compare_models(const CompareCommand& command, const SolverMakers& makers, const Console& console) {
  const InputFiles inputs = inputs_of(command);
  const int prepared = guarded(console, [&] { prepare_outputs(command, inputs); });
  if (prepared != kAgree) return prepared;
  std::vector<int> codes;
  std::vector<std::optional<Case>> cases(command.models.size());
  std::vector<std::string> troubles(command.models.size());
  std::set<std::string> names;
  for (std::size_t k = 0; k < command.models.size(); ++k) {
    if (k > 0) console.out << '\n';
    codes.push_back(guarded_aloud(console, troubles[k], [&] {
      require_one_model(command);
      cases[k] = compare_one(command.models[k], command, inputs, makers, console, names);
      return exit_code(cases[k]->verdict.outcome);
    }));
  }
  if (command.models.size() > 1) console.out << '\n' << shown(console, format_summary(command.models, codes, cases));
  const auto reported = reported_cases(command.models, codes, cases, troubles, names);
  if (!command.json.empty()) {
    codes.push_back(guarded(console, [&] { write_json(command.json, reported); }));
  }
  if (!command.report.empty()) {
    codes.push_back(guarded(console, [&] { write_file(command.report, page::format_page(reported)); }));
  }
  if (!command.junit.empty()) {
    codes.push_back(guarded(console, [&] { write_file(command.junit, format_junit(reported)); }));
  }
  return *std::max_element(codes.begin(), codes.end());
}

int run_model(const RunCommand& command, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    const bool is_one = !command.solver.empty();
    if (!is_one && !command.integrator.empty()) {
      throw InputError({"--integrator", 0, 0}, "is one solver's own: name that by --solver cartesian or relative");
    }
    if (!command.out.empty()) check_target_folder(command.out);
    const Model given = read_model(command.model);
    const std::optional<int> axes = axes_of(command.axes, given, command.model);
    const StartedMachine machine(given, makers);
    check_results(command.out, result_file_names(given, {"cartesian", "relative"}), {command.model});
    std::vector<DoneRun> runs;
    int code = kAgree;
    for (const Who who : kBothSolvers) {
      if (is_one && command.solver != machine.solver(who).name()) continue;
      if (!runs.empty()) console.out << '\n';
      const int its_code = guarded(console, [&] {
        runs.push_back(run_by(machine.solver(who), command, given, axes, machine, console));
        return static_cast<int>(runs.back().check.holds() ? kAgree : kCouldNotFinish);
      });
      code = std::max(code, its_code);
    }
    if (code != kAgree || command.out.empty()) return code;
    std::vector<NamedRun> named;
    for (const DoneRun& run : runs) named.push_back({run.solver, &run.trajectory, &run.check.unique, axes});
    write_runs(command.out, given, named);
    return code;
  });
}

namespace {

/// At the start.
RedundancyView redundancy_of(const Model& model, const State& start, const std::array<SolverView, 2>& views) {
  RedundancyView found;
  if (const auto open = open_reactions(model, start, {views[0].rank, views[1].rank})) {
    found.planar = planar_loops(model, start, *open);
  }
  found.cures = find_cures(model, start);
  return found;
}

}  // namespace

int show_info(const std::filesystem::path& file, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    const Model given = read_model(file);
    const StartedMachine machine(given, makers);
    std::array<SolverView, 2> views;
    State start;
    for (const Who who : kBothSolvers) {
      Solver& solver = machine.solver(who);
      start = solver.assemble();
      views[index(who)] = {std::string(solver.name()), solver.cut_joints(), solver.integrators(), solver.rank(start)};
    }
    console.out << format_info(machine.model(), views, redundancy_of(machine.model(), start, views));
    if (const auto told = start_of(given, machine, makers, SeekPoses::of_all)) {
      console.out << '\n' << format_start(given, *told, true);
    }
    tell(machine.notes(), console);
  });
}

}  // namespace concord::compare
