#include "compare/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <set>
#include <sstream>

#include "common/model_file.h"
#include "compare/analyses/judge.h"
#include "compare/digits.h"
#include "compare/files.h"
#include "compare/guarded.h"
#include "compare/info.h"
#include "compare/junit.h"
#include "compare/plots.h"
#include "compare/reference.h"
#include "compare/report_json.h"
#include "compare/result_files.h"
#include "compare/table.h"

namespace concord::compare {

namespace {

/// One line on a terminal that tells how far a run is; wiped when it goes.
class ProgressLine {
 public:
  explicit ProgressLine(const Console& console) : console_(console) {}
  ~ProgressLine() {
    if (!shown_.empty()) console_.err << "\r\033[K" << std::flush;
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& text) {
    if (!console_.progress || text == shown_) return;
    shown_ = text;
    console_.err << "\r\033[K" << text << std::flush;
  }

 private:
  const Console& console_;
  std::string shown_;
};

int percent(double done) { return static_cast<int>(100.0 * std::clamp(done, 0.0, 1.0)); }

/// A model that was read, and what was found about it.
struct Case {
  Model model;
  Verdict verdict;
};

/// What an earlier comparison wrote for this machine: beside the table of a failed one it would pass for its results.
void remove_results(const std::filesystem::path& folder, const Case& one) {
  const auto remove = [&](const std::string& name) {
    std::error_code ignored;
    std::filesystem::remove(folder / name, ignored);
  };
  for (const SolverSummary& solver : one.verdict.solvers) {
    for (const char* ending : {"nc", "motion.csv", "reactions.csv", "elements.csv"}) {
      remove(fmt::format("{}.{}.{}", one.model.name, solver.name, ending));
    }
  }
  for (const Joint& joint : one.model.joints) remove(fmt::format("{}.reaction_{}.svg", one.model.name, joint.name));
}

void write_results(const std::filesystem::path& folder, const Case& one, const std::string& table,
                   const Console& console) {
  make_folder(folder);
  remove_results(folder, one);
  write_file(folder / (one.model.name + ".table.txt"), table);
  const auto& runs = one.verdict.trajectories;
  const std::array<std::string_view, 2> names{one.verdict.solvers[0].name, one.verdict.solvers[1].name};
  for (std::size_t who = 0; who < 2; ++who) {
    if (runs[who]) write_run(folder, one.model, names[who], *runs[who]);
  }
  if (!runs[0] || !runs[1]) return;
  if (const auto reason = plot_reactions(folder, one.model, names, *runs[0], *runs[1])) {
    console.err << fmt::format("{}: {}\n", one.model.name, *reason);
  }
}

void tell_wall_times(const Verdict& verdict, const Console& console) {
  console.err << fmt::format("{}: wall time of the same run", verdict.name);
  for (const SolverSummary& solver : verdict.solvers) {
    console.err << fmt::format(", {} {:.2f} s in {} steps, {} evaluations", solver.name, solver.statistics.wall_s,
                               solver.statistics.steps, solver.statistics.evaluations);
  }
  console.err << '\n';
}

/// `names` holds the models compared so far.
Case compare_one(const std::filesystem::path& file, const CompareCommand& command, const SolverMakers& makers,
                 const Console& console, std::set<std::string>& names) {
  Case one{read_model(file), {}};
  if (!names.insert(one.model.name).second) {
    throw InputError({file.string(), 0, 0},
                     fmt::format("a model called '{}' was compared already: give one of them another name = \"...\"",
                                 one.model.name));
  }
  std::optional<Reference> reference;
  if (!command.reference.empty()) {
    reference = read_reference(command.reference, one.model);
    check_times(*reference, run_options(one.model, command.options));
  }
  std::string note;
  one.model = analyses::as_it_starts(one.model, makers, note);
  const auto cartesian = makers.cartesian(one.model);
  const auto relative = makers.relative(one.model);
  VerifyOptions options = command.options;
  {
    ProgressLine line(console);
    options.progress = [&](std::string_view rung, const std::array<double, 2>& done) {
      line.show(fmt::format("{}: {}, cartesian {} %, relative {} %", one.model.name, rung, percent(done[0]),
                            percent(done[1])));
    };
    one.verdict = verify(one.model, *cartesian, *relative, options);
  }
  if (!note.empty()) one.verdict.notes.push_back(note);
  if (reference) judge_reference(one.model, *reference, one.verdict);
  const std::string table = format_verdict(one.model, one.verdict, command.all_rows);
  console.out << table << std::flush;
  if (one.verdict.trajectories[0] || one.verdict.trajectories[1]) tell_wall_times(one.verdict, console);
  if (!command.out.empty()) write_results(command.out, one, table, console);
  return one;
}

std::string meaning(int code) {
  switch (code) {
    case kAgree:
      return "agree";
    case kDiffer:
      return "differ";
    case kBadInput:
      return "bad input";
    default:
      return "could not finish";
  }
}

std::string summary_digits(const RungSummary& rung) { return rung.digits ? format_digits(*rung.digits) : "-"; }

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
    lines.push_back({verdict.name, fmt::format("{} of {}", verdict.judged, verdict.total),
                     summary_digits(verdict.same_state), summary_digits(verdict.same_run),
                     summary_digits(verdict.refined), summary_digits(verdict.audit), meaning(codes[k])});
  }
  return format_table(lines, {false, true, true, true, true, true, false});
}

/// guarded(), and keeps what was said.
template <class Work>
int guarded_aloud(const Console& console, std::string& said, const Work& work) {
  std::ostringstream heard;
  const int code = guarded({console.out, heard, console.progress}, work);
  said = heard.str();
  console.err << said;
  return code;
}

void require_one_model(const CompareCommand& command) {
  if (command.reference.empty() || command.models.size() == 1) return;
  throw InputError({command.reference.string(), 0, 0},
                   fmt::format("a reference belongs to one model, but {} are compared", command.models.size()));
}

std::vector<JunitCase> junit_cases(const std::vector<std::filesystem::path>& files,
                                   const std::vector<std::optional<Case>>& cases,
                                   const std::vector<std::string>& troubles) {
  std::vector<JunitCase> all;
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (cases[k]) {
      all.push_back({cases[k]->verdict.name, &cases[k]->model, &cases[k]->verdict, ""});
    } else {
      all.push_back({files[k].stem().string(), nullptr, nullptr, troubles[k]});
    }
  }
  return all;
}

void write_json(const std::filesystem::path& file, const std::vector<std::optional<Case>>& cases) {
  if (cases.size() == 1) {
    if (cases[0]) write_file(file, format_json(cases[0]->model, cases[0]->verdict));
    return;
  }
  std::vector<std::pair<const Model*, const Verdict*>> found;
  for (const auto& one : cases) {
    if (one) found.emplace_back(&one->model, &one->verdict);
  }
  if (!found.empty()) write_file(file, format_json(found));
}

}  // namespace

void write_run(const std::filesystem::path& folder, const Model& model, std::string_view solver,
               const Trajectory& trajectory) {
  make_folder(folder);
  const auto path = [&](const char* ending) { return folder / fmt::format("{}.{}.{}", model.name, solver, ending); };
  write_netcdf(path("nc"), model, solver, trajectory);
  write_motion_csv(path("motion.csv"), model, trajectory);
  write_reaction_csv(path("reactions.csv"), model, trajectory);
  if (!model.elements.empty()) write_element_csv(path("elements.csv"), model, trajectory);
}

int compare_models(const CompareCommand& command, const SolverMakers& makers, const Console& console) {
  std::vector<int> codes;
  std::vector<std::optional<Case>> cases(command.models.size());
  std::vector<std::string> troubles(command.models.size());
  std::set<std::string> names;
  for (std::size_t k = 0; k < command.models.size(); ++k) {
    if (k > 0) console.out << '\n';
    codes.push_back(guarded_aloud(console, troubles[k], [&] {
      require_one_model(command);
      cases[k] = compare_one(command.models[k], command, makers, console, names);
      return exit_code(cases[k]->verdict.outcome);
    }));
  }
  if (command.models.size() > 1) console.out << '\n' << format_summary(command.models, codes, cases);
  if (!command.json.empty()) {
    codes.push_back(guarded(console, [&] {
      write_json(command.json, cases);
      return static_cast<int>(kAgree);
    }));
  }
  if (!command.junit.empty()) {
    codes.push_back(guarded(console, [&] {
      write_file(command.junit, format_junit(junit_cases(command.models, cases, troubles)));
      return static_cast<int>(kAgree);
    }));
  }
  return *std::max_element(codes.begin(), codes.end());
}

int run_model(const RunCommand& command, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    std::string note;
    const Model model = analyses::as_it_starts(read_model(command.model), makers, note);
    const auto solver = (command.is_cartesian ? makers.cartesian : makers.relative)(model);
    RunOptions run = run_options(model, command.options);
    run.integrator = chosen_integrator(model, *solver, command.options.integrators[command.is_cartesian ? 0 : 1]);
    Trajectory trajectory;
    {
      ProgressLine line(console);
      trajectory = solver->integrate(run, [&](double t) {
        line.show(fmt::format("{}: {} {} %", model.name, solver->name(), percent(t / run.until)));
      });
    }
    console.out << fmt::format("{}: {} by {}, {:g} s, {} samples, rtol {:g}, {} steps, {} evaluations\n\n", model.name,
                               solver->name(), run.integrator, run.until, trajectory.samples.size(), run.rtol,
                               trajectory.statistics.steps, trajectory.statistics.evaluations)
                << format_peaks(model, trajectory);
    if (!note.empty()) console.out << fmt::format("note: {}\n", note);
    if (!command.out.empty()) {
      write_run(command.out, model, solver->name(), trajectory);
    }
    console.err << fmt::format("{}: wall time {:.2f} s\n", model.name, trajectory.statistics.wall_s);
    return static_cast<int>(kAgree);
  });
}

int show_info(const std::filesystem::path& file, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    const Model model = read_model(file);
    std::array<SolverView, 2> views;
    for (int who = 0; who < 2; ++who) {
      const auto solver = (who == 0 ? makers.cartesian : makers.relative)(model);
      const State start = solver->assemble();
      views[who] = {std::string(solver->name()), solver->cut_joints(), solver->integrators(), solver->rank(start)};
    }
    console.out << format_info(model, views);
    return static_cast<int>(kAgree);
  });
}

}  // namespace concord::compare
