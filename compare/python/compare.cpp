#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "compare/equilibrium/started_machine.h"
#include "compare/python/bindings.h"
#include "compare/python/interruptible.h"
#include "compare/python/options.h"
#include "compare/python/run.h"
#include "compare/report/report_json.h"
#include "compare/report/table.h"
#include "compare/resolution/run_check.h"
#include "compare/states/stiff_choice.h"
#include "compare/verdict/reference.h"

/// The commands `compare` and `run` of the program, with results in memory.
namespace concord::compare::python {

namespace {

/// A verdict in the words of the program.
struct Compared {
  std::string json;
  std::string table;
  std::string table_of_all;
  std::vector<std::pair<std::string, std::string>> findings;
  std::vector<std::string> notes;
  std::vector<std::string> failures;
  std::array<std::shared_ptr<Run>, 2> runs;
};

void take_words(const Model& model, const Verdict& verdict, Compared& compared) {
  compared.json = format_json(model, verdict);
  compared.table = format_verdict(model, verdict, false);
  compared.table_of_all = format_verdict(model, verdict, true);
  for (const Finding& finding : verdict.findings) compared.findings.emplace_back(finding.what, finding.symptom);
  compared.notes = verdict.notes;
  compared.failures = verdict.failures;
}

/// Takes the trajectories out of the verdict.
void take_runs(const std::shared_ptr<Model>& model, Verdict& verdict, Compared& compared) {
  for (std::size_t who = 0; who < 2; ++who) {
    if (!verdict.trajectories[who]) continue;
    const SolverSummary& solver = verdict.solvers[who];
    compared.runs[who] = std::make_shared<Run>(Run{model, solver.name, solver.integrator, verdict.run.rtol,
                                                   std::move(*verdict.trajectories[who]), verdict.unique, ""});
  }
}

/// As the program does it.
Compared compare_model(const Model& model, const VerifyOptions& options, const std::optional<Reference>& reference,
                       const SolverMakers& makers) {
  const StartedMachine machine(model, makers);
  VerifyOptions own = options;
  own.makers = &makers;
  Verdict verdict = verify(machine.model(), machine.solver(Who::cartesian), machine.solver(Who::relative), own);
  verdict.notes.insert(verdict.notes.end(), machine.notes().begin(), machine.notes().end());
  verdict.start = start_of(model, machine, makers, SeekPoses::of_few_joints);
  verdict.trajectories = machine.back(std::move(verdict.trajectories));
  if (reference) judge_reference(model, *reference, verdict);
  Compared compared;
  take_words(machine.model(), verdict, compared);
  take_runs(std::make_shared<Model>(model), verdict, compared);
  return compared;
}

Compared compare(const std::shared_ptr<Model>& model, std::optional<double> until, std::optional<double> rtol,
                 std::optional<long> samples, const std::string& cartesian, const std::string& relative,
                 std::optional<std::uint64_t> seed, const std::optional<std::filesystem::path>& reference) {
  VerifyOptions options = verify_options(*model, {until, rtol, samples}, {cartesian, relative});
  if (seed) options.seed = *seed;
  std::optional<Reference> outside;
  if (reference) {
    outside = read_reference(*reference, *model);
    check_times(*outside, run_options(*model, options));
  }
  StopFlag stop{false};
  const SolverMakers makers = stoppable_makers(stop);
  return interruptibly(stop, [&] { return compare_model(*model, options, outside, makers); });
}

/// As the program does it: a run that its own audit refutes is no result.
std::shared_ptr<Run> run_model(const Model& model, const std::string& name, const VerifyOptions& options,
                               const std::string& integrator, const SolverMakers& makers) {
  const StartedMachine machine(model, makers);
  Solver& solver = machine.solver(is_cartesian(model, name) ? Who::cartesian : Who::relative);
  RunOptions run = run_options(machine.model(), options);
  run.integrator = chosen_integrator(machine.model(), solver, integrator);
  MadeBy made_by;
  Trajectory trajectory = integrate_or_switch(solver, run, integrator.empty(), {}, made_by);
  run.integrator = made_by.integrator;
  auto found = std::make_shared<Run>(
      Run{std::make_shared<Model>(model), name, run.integrator, run.rtol, std::move(trajectory), std::nullopt, ""});
  const QuantityLayout layout(machine.model());
  RunCheck check = check_run(layout, solver, found->trajectory, run);
  found->check = format_run_check(layout, name, check);
  if (!check.holds()) throw SolverError(found->check);
  found->trajectory = machine.back(std::move(found->trajectory));
  std::vector<std::string> notes = machine.notes();
  if (!made_by.note.empty()) notes.push_back(made_by.note);
  for (const std::string& one : notes) {
    found->check += fmt::format("note: {}\n", one);
  }
  found->unique = std::move(check.unique);
  return found;
}

std::shared_ptr<Run> run(const std::shared_ptr<Model>& model, const std::string& solver, std::optional<double> until,
                         std::optional<double> rtol, std::optional<long> samples, const std::string& integrator) {
  const VerifyOptions options = verify_options(*model, {until, rtol, samples}, {});
  is_cartesian(*model, solver);
  StopFlag stop{false};
  const SolverMakers makers = stoppable_makers(stop);
  return interruptibly(stop, [&] { return run_model(*model, solver, options, integrator, makers); });
}

py::list texts_of(const std::vector<std::string>& texts) {
  py::list all;
  for (const std::string& text : texts) all.append(text_of(text));
  return all;
}

}  // namespace

void bind_compare(py::module_& module) {
  py::class_<Compared>(module, "Compared", "What a comparison found.")
      .def_property_readonly("json", [](const Compared& one) { return text_of(one.json); })
      .def(
          "table", [](const Compared& one, bool all) { return text_of(all ? one.table_of_all : one.table); },
          py::arg("all") = false)
      .def_property_readonly("findings",
                             [](const Compared& one) {
                               py::list all;
                               for (const auto& [what, symptom] : one.findings) {
                                 all.append(py::make_tuple(text_of(what), text_of(symptom)));
                               }
                               return all;
                             })
      .def_property_readonly("notes", [](const Compared& one) { return texts_of(one.notes); })
      .def_property_readonly("failures", [](const Compared& one) { return texts_of(one.failures); })
      .def_property_readonly("runs", [](const Compared& one) {
        return py::dict(py::arg("cartesian") = one.runs[0], py::arg("relative") = one.runs[1]);
      });
  module.def("compare", compare, py::arg("model").none(false), py::kw_only(), py::arg("until") = py::none(),
             py::arg("rtol") = py::none(), py::arg("samples") = py::none(), py::arg("cartesian") = "",
             py::arg("relative") = "", py::arg("seed") = py::none(), py::arg("reference") = py::none());
  module.def("run", run, py::arg("model").none(false), py::arg("solver"), py::kw_only(), py::arg("until") = py::none(),
             py::arg("rtol") = py::none(), py::arg("samples") = py::none(), py::arg("integrator") = "");
}

}  // namespace concord::compare::python
