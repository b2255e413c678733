#include "compare/nightly/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <stdexcept>

#include "compare/nightly/record.h"
#include "compare/report/console.h"

namespace concord::compare::nightly {

CONCORD_RECORD(Component, name, same_state, resolvable, same_run, refined, need, peak, scale)
CONCORD_RECORD(Cost, integrator, steps, evaluations)

namespace {

constexpr std::array<std::string_view, 8> kEndings{"agree",   "differ", "no verdict",    "bad input",
                                                   "crashed", "hung",   "out of memory", "not run"};

}  // namespace

std::string to_string(Ending ending) { return std::string(kEndings.at(static_cast<std::size_t>(ending))); }

Ending ending_of(const std::string& text) {
  const auto found = std::find(kEndings.begin(), kEndings.end(), text);
  if (found == kEndings.end()) throw std::runtime_error(fmt::format("no case ends with '{}'", text));
  return static_cast<Ending>(found - kEndings.begin());
}

int exit_code(Ending ending) {
  switch (ending) {
    case Ending::agree:
      return kAgree;
    case Ending::differ:
      return kDiffer;
    case Ending::bad_input:
      return kBadInput;
    default:
      return kCouldNotFinish;
  }
}

void put_in_order(std::vector<Component>& components) {
  std::map<std::string, int> met;
  for (Component& one : components) {
    const int count = ++met[one.name];
    if (count > 1) one.name += fmt::format(" #{}", count);
  }
  std::sort(components.begin(), components.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
}

std::optional<double> worst_of(const Result& result, std::optional<double> Component::*check) {
  std::optional<double> worst;
  for (const Component& one : result.components) {
    const std::optional<double>& digits = one.*check;
    if (digits && (!worst || *digits < *worst)) worst = digits;
  }
  return worst;
}

std::array<std::optional<double>, 3> worst_digits(const Result& result) {
  return {worst_of(result, &Component::same_state), worst_of(result, &Component::same_run),
          worst_of(result, &Component::refined)};
}

void to_json(Json& document, const Result& result) {
  document = {{"case", result.id},
              {"work", result.work},
              {"definition", result.definition},
              {"ending", to_string(result.ending)},
              {"words", result.words},
              {"judged", result.judged},
              {"total", result.total},
              {"solvers", {{"cartesian", result.cost[0]}, {"relative", result.cost[1]}}},
              {"wall_s", result.wall_s},
              {"processor_s", result.processor_s},
              {"components", result.components}};
}

void from_json(const Json& document, Result& result) {
  result.id = document.at("case");
  result.work = document.at("work");
  result.definition = document.value("definition", "");
  result.ending = ending_of(document.at("ending"));
  result.words = document.at("words");
  result.judged = document.at("judged");
  result.total = document.at("total");
  result.cost = {document.at("solvers").at("cartesian"), document.at("solvers").at("relative")};
  result.wall_s = document.at("wall_s");
  result.processor_s = document.at("processor_s");
  for (Json one : document.at("components")) {
    if (one.at("scale").is_null()) one["scale"] = 0.0;  // it was no number
    result.components.push_back(one);
  }
  put_in_order(result.components);
}

namespace {

/// The last stage that a task told and what it said in it, which is what is shown in one line; then what it said
/// before.
std::string last_stage_first(const std::string& words) {
  const std::size_t at = words.rfind("\nstage: ");
  if (at == std::string::npos) return words;
  const std::string last = words.substr(at + 1);
  return fmt::format("{}{}before: {}", last, last.back() == '\n' ? "" : "\n", words.substr(0, at));
}

}  // namespace

Result result_of(const std::string& id, const std::string& work, const workers::Report& report) {
  Result result;
  const bool is_interrupted = report.signal == SIGINT || report.signal == SIGTERM || report.signal == SIGHUP;
  if (report.end == workers::End::answered) {
    result = Json::parse(report.answer).get<Result>();
  } else if (is_interrupted) {
    result.words = fmt::format("interrupted by signal {}", report.signal);
  } else {
    result.ending = report.end == workers::End::threw           ? Ending::failed
                    : report.end == workers::End::crashed       ? Ending::crashed
                    : report.end == workers::End::out_of_memory ? Ending::out_of_memory
                                                                : Ending::hung;
    const bool is_hung = report.end != workers::End::threw && result.ending == Ending::hung;
    const std::string signal = is_hung
                                   ? fmt::format("its time was up, after {:.0f} s of processor time; ", report.seconds)
                               : report.signal != 0 ? fmt::format("signal {}; ", report.signal)
                                                    : "";
    result.words = report.end == workers::End::threw ? report.answer
                   : report.last_words.empty()       ? signal + "no last words"
                                                     : signal + "last words: " + last_stage_first(report.last_words);
  }
  result.id = id;
  result.work = work;
  result.processor_s = report.seconds;
  return result;
}

}  // namespace concord::compare::nightly
