#include "compare/report/result_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "common/error.h"
#include "common/reading/model_file.h"
#include "compare/report/files.h"
#include "compare/report/result_files.h"

namespace concord::compare {

namespace {

/// The files of one solver's run of a model.
std::vector<std::string> run_file_names(const Model& model, std::string_view solver) {
  std::vector<std::string> names;
  for (const char* ending : {"nc", "motion.csv", "reactions.csv", "elements.csv"}) {
    names.push_back(fmt::format("{}.{}.{}", model.name, solver, ending));
  }
  return names;
}

}  // namespace

std::vector<std::string> result_file_names(const Model& model, const std::vector<std::string_view>& solvers) {
  std::vector<std::string> names{model.name + ".table.txt", model.name + ".result.json"};
  for (const std::string_view solver : solvers) {
    for (std::string& name : run_file_names(model, solver)) names.push_back(std::move(name));
  }
  for (const Joint& joint : model.joints) names.push_back(fmt::format("{}.reaction_{}.svg", model.name, joint.name));
  return names;
}

void write_run_files(const std::filesystem::path& folder, const Model& model, const NamedRun& run) {
  const auto path = [&](const char* ending) {
    return folder / fmt::format("{}.{}.{}", model.name, run.solver, ending);
  };
  write_netcdf(path("nc"), model, run.solver, *run.trajectory, run.unique, run.axes);
  write_motion_csv(path("motion.csv"), model, *run.trajectory);
  write_reaction_csv(path("reactions.csv"), model, *run.trajectory, run.unique, run.axes);
  if (!model.elements.empty()) write_element_csv(path("elements.csv"), model, *run.trajectory, run.axes);
}

namespace {

template <class Files>
void refuse_if_among(const std::filesystem::path& target, const Files& files, const char* what) {
  const auto is_it = [&](const std::filesystem::path& file) { return is_same_file(target, file); };
  if (std::any_of(files.begin(), files.end(), is_it)) {
    throw InputError({target.string(), 0, 0}, fmt::format("cannot be written: it is {} of this run", what));
  }
}

}  // namespace

const std::set<std::filesystem::path>& InputFiles::all() const {
  if (all_) return *all_;
  all_.emplace();
  for (const std::filesystem::path& input : inputs_) {
    if (input.empty()) continue;
    for (std::filesystem::path& file : files_of_model(input)) all_->insert(std::move(file));
  }
  return *all_;
}

void check_results(const std::filesystem::path& folder, const std::vector<std::string>& names,
                   const InputFiles& inputs) {
  if (folder.empty()) return;
  check_target_folder(folder);
  for (const std::string& name : names) {
    check_target(folder / name);
    refuse_if_among(folder / name, inputs.all(), "an input");
  }
}

void write_runs(const std::filesystem::path& folder, const Model& model, const std::vector<NamedRun>& runs) {
  StagedFolder staged(folder);
  std::vector<std::string_view> solvers;
  for (const NamedRun& run : runs) {
    write_run_files(staged.path(), model, run);
    solvers.push_back(run.solver);
  }
  staged.finish(result_file_names(model, solvers));
}

bool is_same_file(const std::filesystem::path& one, const std::filesystem::path& other) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  return fs::equivalent(one, other, unknown) ||
         fs::weakly_canonical(fs::absolute(one), unknown) == fs::weakly_canonical(fs::absolute(other), unknown);
}

void check_output(const std::filesystem::path& target, const InputFiles& inputs) { check_outputs({target}, inputs); }

void check_outputs(const std::vector<std::filesystem::path>& targets, const InputFiles& inputs) {
  std::vector<std::filesystem::path> earlier;
  for (const std::filesystem::path& target : targets) {
    if (target.empty()) continue;
    check_target(target);
    refuse_if_among(target, inputs.all(), "an input");
    refuse_if_among(target, earlier, "another output");
    earlier.push_back(target);
  }
}

}  // namespace concord::compare
