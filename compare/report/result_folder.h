#pragma once

#include <array>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/agreement.h"

/// The files that the results of a model are, and how they replace those of an earlier run.
namespace concord::compare {

/// One solver's run.
struct NamedRun {
  std::string_view solver;
  const Trajectory* trajectory = nullptr;
  /// What of it is unique; null: not known.
  const Mask* unique = nullptr;
  /// Of a body in which wrenches are told, see told_axes(); missing: in the frame of each side.
  std::optional<int> axes = {};
};

/// All that a comparison may write for a machine with runs of these solvers: what an earlier one left would pass for
/// results of this one.
std::vector<std::string> result_file_names(const Model& model, const std::vector<std::string_view>& solvers);

/// Writes one solver's run into a folder that is there: `model`.`solver`.nc, .motion.csv, .reactions.csv, and
/// .elements.csv if the model has force elements. Throws InputError if the path cannot be written.
void write_run_files(const std::filesystem::path& folder, const Model& model, const NamedRun& run);

/// Writes solvers' runs into `folder`, see write_run_files(). They replace those of an earlier run together; what a
/// comparison said of that, table, JSON and plots, goes. Throws InputError if the path cannot be written.
void write_runs(const std::filesystem::path& folder, const Model& model, const std::vector<NamedRun>& runs);

/// The inputs of a command; empty paths are none. What models among them include is found once, when it is first asked
/// for: a command that writes nothing need not know.
class InputFiles {
 public:
  InputFiles(std::vector<std::filesystem::path> inputs) : inputs_(std::move(inputs)) {}
  InputFiles(std::initializer_list<std::filesystem::path> inputs) : inputs_(inputs) {}

  /// All files that are read: models, what they include, and others as they are.
  [[nodiscard]] const std::set<std::filesystem::path>& all() const;

 private:
  std::vector<std::filesystem::path> inputs_;
  mutable std::optional<std::set<std::filesystem::path>> all_;
};

/// Throws InputError if something stands in the folder that results of these names cannot replace, one of the inputs
/// among it; an empty path is no folder.
void check_results(const std::filesystem::path& folder, const std::vector<std::string>& names,
                   const InputFiles& inputs);

/// Whether two paths lead to one file, by other names too, or would if the file and its folders were there.
bool is_same_file(const std::filesystem::path& one, const std::filesystem::path& other);

/// Throws InputError unless a file can be written at `target` (an empty one is none) that is none of the `inputs`.
void check_output(const std::filesystem::path& target, const InputFiles& inputs);

/// The same of several targets, of which no two may be one file.
void check_outputs(const std::vector<std::filesystem::path>& targets, const InputFiles& inputs);

}  // namespace concord::compare
