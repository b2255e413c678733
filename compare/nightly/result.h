#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/workers/pool.h"

/// What became of one case, small enough to be kept for ever.
namespace concord::compare::nightly {

enum class Ending {
  agree,
  differ,
  failed,     // no verdict: a solver stopped, a number is missing, nothing could be judged
  bad_input,  // the model, or what the suite says of it, is refused
  crashed,
  hung,
  out_of_memory,
  not_run  // the time of the night was up, or the case was interrupted
};

/// "agree", "differ", "no verdict", "bad input", "crashed", "hung", "out of memory", "not run"; and back (throws
/// std::runtime_error for anything else).
std::string to_string(Ending ending);
Ending ending_of(const std::string& text);

/// One number on which two solvers agree to some digits. Digits are missing where a check did not judge it.
struct Component {
  std::string name;  // "joint D on slider, F_x"
  std::optional<double> same_state;
  std::optional<double> resolvable;  // of the same state
  std::optional<double> same_run;
  std::optional<double> refined;
  std::array<double, 3> need{};  // of same state, same run, refined
  std::optional<double> peak;    // largest size along the run; of one sample the number itself
  double scale = 0.0;            // what differences and the peak are compared with
};

struct Cost {
  std::string integrator;
  long steps = 0;
  long evaluations = 0;
};

struct Result {
  std::string id;
  std::string work;
  std::string definition;  // what the case was asked; empty: not known
  Ending ending = Ending::not_run;
  std::string words;  // findings, failures or last words
  int judged = 0;
  int total = 0;
  std::array<Cost, 2> cost;           // Cartesian, relative
  std::vector<Component> components;  // sorted by name, each name once
  double wall_s = 0.0;                // shown, never judged
  double processor_s = 0.0;

  [[nodiscard]] bool is_green() const { return ending == Ending::agree; }
};

/// Sorts the components, and numbers those whose name another one has.
void put_in_order(std::vector<Component>& components);

/// Worst digits of a check, nothing if it judged nothing; and those of same state, same run and refined.
std::optional<double> worst_of(const Result& result, std::optional<double> Component::*check);
std::array<std::optional<double>, 3> worst_digits(const Result& result);

/// Code of the program for a case of this ending.
int exit_code(Ending ending);

/// For the library: `document = result`, `document.get<Result>()`, which throws nlohmann::json::exception or
/// std::runtime_error if it is no such document.
void to_json(nlohmann::ordered_json& document, const Result& result);
void from_json(const nlohmann::ordered_json& document, Result& result);

/// Of a worker's report: what a task answered is the text of its result as JSON. A worker that somebody ended by SIGINT
/// or SIGTERM did not crash: the case was not run.
Result result_of(const std::string& id, const std::string& work, const workers::Report& report);

}  // namespace concord::compare::nightly
