#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "compare/analyses/judge_steps.h"
#include "compare/analyses/linearize.h"
#include "compare/audit/digits.h"
#include "compare/report/text_table.h"
#include "compare/verdict/align.h"

namespace concord::compare::analyses {

namespace {

/// How far two mode shapes point the same way: what of one is not along the other.
double shape_digits(const Mode& one, const Mode& other) {
  const std::complex<double> along = other.scaled_shape.dot(one.scaled_shape);
  return matching_digits((one.scaled_shape - along * other.scaled_shape).norm(), 1.0);
}

/// Whether no other eigenvalue is so near that the shapes of both mix; one below `least` is near to those of free
/// modes.
bool stands_alone(const std::vector<Mode>& modes, std::size_t k, double least) {
  const std::complex<double> own = modes[k].eigenvalue;
  if (modes[k].is_free || std::abs(own) < least) return false;
  for (std::size_t other = 0; other < modes.size(); ++other) {
    if (other != k && std::abs(own - modes[other].eigenvalue) < 1e-3 * std::abs(own)) return false;
  }
  return true;
}

/// Derivatives are good to 1e-12 of the largest, which moves an eigenvalue by that times its condition: it has the
/// eight digits that are needed only above this part of the fastest one times its condition; below, that is its scale.
constexpr double kResolved = 1e-4;

std::string eigenvalue_text(const Mode& mode) {
  return mode.oscillates() ? fmt::format("{:.8g} +- {:.10g}i", mode.eigenvalue.real(), mode.eigenvalue.imag())
                           : fmt::format("{:.10g}", mode.eigenvalue.real());
}

/// Judges one mode after the other, and makes the lines of the table.
class ModeJudge {
 public:
  ModeJudge(const Linearization& one, const Linearization& other, AnalysisVerdict& result)
      : one_(one), other_(other), result_(result) {
    for (const Mode& mode : one.modes) fastest_ = std::max(fastest_, std::abs(mode.eigenvalue));
  }

  void judge() {
    result_.numbers.push_back(count("number of modes", [](const Mode&) { return true; }));
    result_.numbers.push_back(count("number of free modes", [](const Mode& mode) { return mode.is_free; }));
    const ModePairs pairs = pair_modes(one_, other_);
    for (const auto& [k, partner] : pairs.both) judge_pair(k, partner);
    for (const std::size_t k : pairs.alone[0]) judge_alone("cartesian", one_.modes[k], {abs_of(one_.modes[k]), kNone});
    for (const std::size_t k : pairs.alone[1]) {
      judge_alone("relative", other_.modes[k], {kNone, abs_of(other_.modes[k])});
    }
    result_.text += '\n' + format_table(lines_, {true, true, true, true, true, true, false});
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  static double abs_of(const Mode& mode) { return std::abs(mode.eigenvalue); }

  template <class Counts>
  NumberRow count(const char* name, const Counts& counts) {
    const auto number_of = [&](const std::vector<Mode>& modes) {
      return static_cast<double>(std::count_if(modes.begin(), modes.end(), counts));
    };
    return number(name, "", number_of(one_.modes), number_of(other_.modes), 1.0, kMostDigits);
  }

  void judge_pair(std::size_t k, std::size_t partner) {
    const Mode& mode = one_.modes[k];
    const Mode& other = other_.modes[partner];
    const double condition = std::max(mode.condition, other.condition);
    const double scale = std::max({abs_of(mode), one_.resolution, kResolved * fastest_ * condition});
    const double digits = matching_digits(std::abs(mode.eigenvalue - other.eigenvalue), scale);
    NumberRow row{fmt::format("eigenvalue {}", k + 1), "1/s", {abs_of(mode), abs_of(other)}, digits, kEigenvalue};
    const bool alone = stands_alone(one_.modes, k, kResolved * fastest_);
    const double shape = shape_digits(mode, other);
    if (alone) row.digits = std::min(row.digits, shape);
    add_line(mode, format_digits(digits), alone ? format_digits(shape) : "-", "");
    result_.numbers.push_back(std::move(row));
  }

  void judge_alone(const char* solver, const Mode& mode, const std::array<double, 2>& values) {
    add_line(mode, format_digits(0.0), "-", fmt::format(" (found by {} alone)", solver));
    result_.numbers.push_back(
        {fmt::format("eigenvalue {} of {} alone", lines_.size() - 1, solver), "1/s", values, 0.0, kEigenvalue});
  }

  void add_line(const Mode& mode, std::string digits, std::string shape_digits, const std::string& remark) {
    lines_.push_back({fmt::format("{}", lines_.size()), fmt::format("{:.10g}", mode.frequency()),
                      fmt::format("{:.6g}", mode.damping_ratio()), eigenvalue_text(mode), std::move(digits),
                      std::move(shape_digits), (mode.is_free ? "free: " : "") + mode.motion + remark});
  }

  const Linearization& one_;
  const Linearization& other_;
  AnalysisVerdict& result_;
  double fastest_ = 0.0;
  Lines lines_{{"mode", "frequency [Hz]", "damping ratio", "eigenvalue [1/s]", "digits", "shape digits", "motion"}};
};

/// About a motion that is not steady, modes say how the machine behaves as if it stayed as it is now.
std::string steadiness_text(const Model& model, Solver& solver, const Linearization& found) {
  constexpr double kChanges = 1e-3;
  const Steadiness steadiness = steadiness_of(model, solver, found);
  if (steadiness.accelerates) {
    return "note: the machine accelerates in this state: modes are those of the machine frozen in it\n";
  }
  if (steadiness.change <= kChanges) return "";
  return fmt::format(
      "note: the motion is not steady: in a radian of it the matrices change by {:.2g} of the fastest rate; modes are "
      "those of the machine frozen in this state\n",
      steadiness.change);
}

}  // namespace

AnalysisVerdict judge_linearization(const Model& model, const SolverMakers& makers, bool at_equilibrium) {
  Model held = at_equilibrium ? held_at_start(model) : model;
  AnalysisVerdict result;
  result.analysis = "linearize";
  const Solvers solvers = make_solvers(held, makers, result);
  std::array<Trajectory, 2> states;
  for (const Who who : kBothSolvers) {
    Solver& solver = *solvers[index(who)];
    if (at_equilibrium) {
      const Equilibrium found = find_equilibrium(held, solver);
      result.text += equilibrium_text(found, solver.name());
      states[index(who)] = one_sample(found.state, found.evaluation);
    } else {
      const State start = solver.assemble();
      states[index(who)] = one_sample(start, solver.evaluate(start));
    }
    result.linearizations[index(who)] = linearize(held, solver, states[index(who)].samples[0].state);
  }
  judge_wrenches(held, solvers, states, at_equilibrium, result);
  result.text += steadiness_text(held, *solvers[0], *result.linearizations[0]);
  result.text += fmt::format("modes about the {}, by cartesian:\n", at_equilibrium ? "equilibrium" : "start");
  ModeJudge(*result.linearizations[0], *result.linearizations[1], result).judge();
  conclude(result);
  return result;
}

}  // namespace concord::compare::analyses
