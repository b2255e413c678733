#include "compare/random_machines/trial.h"

#include <cstdio>
#include <optional>

#include "common/reading/model_file.h"
#include "compare/report/files.h"
#include "compare/states/branch.h"

namespace concord::compare::fuzz {

namespace {

/// Fewer than for a model of a user: many machines with few states find more than one machine with many.
constexpr int kStates = 16;

void tell_check(std::string_view check) {
  std::fprintf(stderr, "check: %.*s\n", static_cast<int>(check.size()), check.data());
}

/// Messages name the model's file, whose folder belongs to one run.
std::string without_folder(std::string text, const std::filesystem::path& folder) {
  const std::string name = folder.string() + '/';
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) text.erase(at, name.size());
  return text;
}

std::optional<Model> read_text(const ModelText& text, const std::filesystem::path& folder, Outcome& outcome) {
  try {
    for (const auto& [name, content] : text.beside) write_file(folder / name, content);
    return parse_model(text.model, folder / "machine.toml");
  } catch (const InputError& error) {
    outcome = outcome_of_input_error(without_folder(error.what(), folder), false);
    return std::nullopt;
  }
}

}  // namespace

Outcome try_machine(const ModelText& text, const std::filesystem::path& folder, const SolverMakers& makers,
                    bool refines) {
  Outcome outcome;
  tell_check("reading");
  std::optional<Model> model = read_text(text, folder, outcome);
  if (!model) return outcome;
  try {
    tell_check("start");
    std::string note;
    const auto [cartesian, relative] = make_solvers_on_one_branch(*model, makers, note);
    VerifyOptions options;
    options.states = kStates;
    options.samples = kStates - 1;
    options.refines = refines;
    options.explains = false;  // a machine that is made small differs hundreds of times
    std::string last;
    options.progress = [&](std::string_view check, const std::array<double, 2>&) {
      if (check == last) return;
      last = check;
      tell_check(check);
    };
    return outcome_of(verify(*model, *cartesian, *relative, options));
  } catch (const InputError& error) {
    return outcome_of_input_error(without_folder(error.what(), folder), true);
  }
}

}  // namespace concord::compare::fuzz
