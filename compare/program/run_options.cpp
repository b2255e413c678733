#include "compare/program/run_options.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "common/reading/magnitude.h"
#include "compare/program/command_line.h"

namespace concord::compare {

namespace {

/// The ranges of CLI11 let NaN through.
const CLI::Validator kNumber(
    [](std::string& text) {
      double value = 0.0;
      const bool is_number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
      if (!is_number) return fmt::format("{} is not a finite number", text);
      return has_usable_size(value) ? std::string() : fmt::format("the number {}", complaint_about_size(value));
    },
    "");

/// A number in a range, said as a person writes it.
CLI::Validator number_in(double least, double most) {
  return CLI::Validator(
      [=](std::string& text) {
        std::string complaint = kNumber(text);
        if (!complaint.empty()) return complaint;
        const double value = std::stod(text);
        return value >= least && value <= most ? std::string()
                                               : fmt::format("{} is not between {:g} and {:g}", text, least, most);
      },
      "");
}

const CLI::Validator kPositive(
    [](std::string& text) {
      std::string complaint = kNumber(text);
      if (!complaint.empty()) return complaint;
      return std::stod(text) > 0.0 ? std::string() : fmt::format("{} is not above zero", text);
    },
    "");

}  // namespace

void add_run_options(CLI::App& command, VerifyOptions& options) {
  command.add_option("--until", options.until, "End of the run [s]; default: what the model says")->check(kPositive);
  command
      .add_option(
          "--rtol", options.rtol,
          "Relative tolerance of the integrators; default: what the model says, else 1e-11 rigid, 1e-9 flexible")
      ->check(number_in(kTightestTolerance, kLoosestTolerance));
  command
      .add_option("--samples", options.samples,
                  "Equal intervals of the output grid; default: what the model says, else 300; `compare` takes a "
                  "multiple that gives at least 200 states")
      ->check(whole_number_from(1, 1000000));
}

}  // namespace concord::compare
