#include "compare/verdict/two_readings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/reading/model_file.h"
#include "compare/attribution/attribution.h"
#include "compare/verdict/verify.h"

namespace concord::compare {

namespace {

std::string describe(const StatedValue& value, const std::string& file) {
  const std::string line = value.line > 0 ? fmt::format(" in line {}", value.line) : "";
  const std::string how =
      value.text.empty() ? fmt::format("off by {:.2e}, of {:.3g}", value.residual, value.scale) : value.text;
  return fmt::format("{}, {}: was not read as {} says{}: {}", value.where, value.key,
                     value.file.empty() ? file : value.file, line, how);
}

Attribution cause_of(const StatedValue& value) {
  const char* page = value.key == "type" ? ", at the page of the joint type in common/joints" : "";
  return {2, Term::statement, value.where,
          fmt::format("two readings of the file differ on \"{}\", before any solver is asked: look at common/reading{} "
                      "and at compare/reread",
                      value.key, page)};
}

std::string text_of(const Model& model, const SecondReading& reading) {
  constexpr std::size_t kMost = 5;
  std::vector<std::string> lines;
  for (const StatedValue& value : reading.differing) {
    if (lines.size() == kMost) break;
    lines.push_back(fmt::format("FAIL {}: {}", model.name, describe(value, model.file)));
  }
  if (reading.differing.size() > kMost) {
    lines.push_back(fmt::format("FAIL {}: and {} more values", model.name, reading.differing.size() - kMost));
  }
  lines.push_back("note: to blame: " + compare::describe(cause_of(reading.differing.front())));
  return fmt::format("{}", fmt::join(lines, "\n"));
}

Model held(Model model, SecondReading reading) {
  if (!reading.differing.empty()) throw MisreadModel(std::move(model), std::move(reading));
  return model;
}

}  // namespace

MisreadModel::MisreadModel(Model model, SecondReading reading)
    : std::runtime_error(text_of(model, reading)), model_(std::move(model)), reading_(std::move(reading)) {}

Model read_twice(const std::filesystem::path& file, const std::map<std::string, double>& parameters) {
  Model model = parameters.empty() ? read_model(file) : read_model(file, parameters);
  SecondReading reading = read_again(model, file, parameters);
  return held(std::move(model), std::move(reading));
}

Model parse_twice(std::string_view text, const std::filesystem::path& file) {
  Model model = parse_model(text, file);
  SecondReading reading = read_again_text(model, text, file);
  return held(std::move(model), std::move(reading));
}

Verdict verdict_on(const MisreadModel& misread) {
  Verdict verdict;
  verdict.name = misread.model().name;
  verdict.bodies = static_cast<int>(misread.model().bodies.size()) - 1;
  verdict.joints = static_cast<int>(misread.model().joints.size());
  verdict.solvers[0].name = "cartesian";
  verdict.solvers[1].name = "relative";
  verdict.run = run_options(misread.model(), {});
  for (const StatedValue& value : misread.reading().differing) {
    verdict.findings.push_back({describe(value, misread.model().file), "the model is not what its file says"});
  }
  verdict.attribution = cause_of(misread.reading().differing.front());
  verdict.notes.push_back("to blame: " + compare::describe(*verdict.attribution));
  verdict.outcome = Outcome::differ;
  return verdict;
}

}  // namespace concord::compare
