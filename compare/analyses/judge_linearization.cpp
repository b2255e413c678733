#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "compare/analyses/judge_steps.h"
#include "compare/analyses/linearize.h"
#include "compare/audit/digits.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/machine_size.h"
#include "compare/audit/places.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"
#include "compare/report/text_table.h"

namespace concord::compare::analyses {

namespace {

/// A shape that is resolved to less than a digit is not judged: of two motions of one frequency any mixture is one.
constexpr double kAnyMixture = 0.1;

std::string eigenvalue_text(const Mode& mode) {
  return mode.oscillates() ? fmt::format("{:.8g} +- {:.10g}i", mode.eigenvalue.real(), mode.eigenvalue.imag())
                           : fmt::format("{:.10g}", mode.eigenvalue.real());
}

/// Nothing is known of it but that it is small.
bool is_unresolved(const Mode& mode) {
  return !mode.is_free && std::abs(mode.eigenvalue) <= kWithinResolution * mode.eigenvalue_resolution;
}

/// Below it a solver's differences tell nothing from zero [1/s]: what is slower is called free.
double slowest_told_by(const Linearization& found) { return std::max(found.resolution, found.slowest); }

std::string free_text(const Linearization& one, const Linearization& other) {
  const auto has_free = [](const Linearization& found) {
    return std::ranges::any_of(found.modes, [](const Mode& mode) { return mode.is_free; });
  };
  if (!has_free(one) && !has_free(other)) return "";
  return fmt::format(
      "free: differences of cartesian tell no rate below {:.2g} 1/s from zero, those of relative none below "
      "{:.2g}\n",
      slowest_told_by(one), slowest_told_by(other));
}

/// Judges one mode after the other, and makes the lines of the table.
class ModeJudge {
 public:
  ModeJudge(const Linearization& one, const Linearization& other, AnalysisVerdict& result)
      : one_(one), other_(other), slowest_(std::max(one.slowest, other.slowest)), result_(result) {}

  void judge() {
    result_.numbers.push_back(count("number of modes", [](const Mode&) { return true; }));
    result_.numbers.push_back(count("number of free modes", [](const Mode& mode) { return mode.is_free; }));
    const bool is_decided = decides_what_is_free();
    for (NumberRow& row : result_.numbers) {
      if (!is_decided) row.resolvable = 0.0;
    }
    if (!is_decided) result_.text += "note: differences do not decide how many modes are free\n";
    if (!decides_how_many()) result_.numbers.front().resolvable = 0.0;
    const ModePairs pairs = pair_modes(one_.modes, other_.modes, slowest_);
    for (const auto& [k, partner] : pairs.both) judge_pair(k, partner);
    for (const std::size_t k : pairs.alone[0]) judge_alone("cartesian", one_.modes[k], {abs_of(one_.modes[k]), kNone});
    for (const std::size_t k : pairs.alone[1]) {
      judge_alone("relative", other_.modes[k], {kNone, abs_of(other_.modes[k])});
    }
    result_.text += '\n' + format_table(lines_, {true, true, true, true, true, true, false});
    if (!unresolved_.empty()) {
      result_.text += fmt::format("note: fewer than {:g} digits are resolved of the eigenvalues of mode{} {}\n",
                                  kFewDigits, unresolved_.size() > 1 ? "s" : "", fmt::join(unresolved_, ", "));
    }
  }

 private:
  static constexpr double kFewDigits = 3.0;
  static constexpr double kHalfADigit = 0.5;
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  static double abs_of(const Mode& mode) { return std::abs(mode.eigenvalue); }

  /// Not where each solver's number is among those that the other one finds by asking for more or less, or that
  /// eigenvalues may add of which nothing is resolved, or which the other one does not tell from zero.
  [[nodiscard]] bool decides_what_is_free() const {
    const auto free_of = [](const Linearization& found) {
      return static_cast<int>(
          std::count_if(found.modes.begin(), found.modes.end(), [](const Mode& mode) { return mode.is_free; }));
    };
    const auto may_have = [](const Linearization& found, int count, const Linearization& other) {
      const int more = count_unresolved(found) + count_slower(found, slowest_told_by(other));
      return found.free_range[0] <= count && count <= found.free_range[1] + more;
    };
    if (free_of(one_) == free_of(other_)) return true;
    return !may_have(other_, free_of(one_), one_) && !may_have(one_, free_of(other_), other_);
  }

  /// Eigenvalues up to this rate, two of a pair, of those that are resolved.
  static int count_slower(const Linearization& found, double rate) {
    int count = 0;
    for (const Mode& mode : found.modes) {
      const bool is_slower = !mode.is_free && !is_unresolved(mode) && abs_of(mode) <= rate;
      if (is_slower) count += mode.oscillates() ? 2 : 1;
    }
    return count;
  }

  /// Eigenvalues, two of a pair.
  static int count_unresolved(const Linearization& found) {
    int count = 0;
    for (const Mode& mode : found.modes) {
      if (is_unresolved(mode)) count += mode.oscillates() ? 2 : 1;
    }
    return count;
  }

  /// Round-off decides which of the eigenvalues that are not resolved are pairs and which are real.
  static std::array<int, 2> range_of_modes(const Linearization& found) {
    const auto is_open = [](const Mode& mode) { return is_unresolved(mode) || mode.is_half_of_unresolved_pair; };
    const auto is_half = [](const Mode& mode) { return mode.is_half_of_unresolved_pair && !is_unresolved(mode); };
    const auto resolved = static_cast<int>(found.modes.size() - std::ranges::count_if(found.modes, is_open));
    const int open = count_unresolved(found) + static_cast<int>(std::ranges::count_if(found.modes, is_half));
    return {resolved + (open + 1) / 2, resolved + open};
  }

  [[nodiscard]] bool decides_how_many() const {
    const std::array<int, 2> one = range_of_modes(one_);
    const std::array<int, 2> other = range_of_modes(other_);
    return one_.modes.size() == other_.modes.size() || one[1] < other[0] || other[1] < one[0];
  }

  /// Whether a mode that one solver alone has is more than one of those that round-off decides about in the other.
  [[nodiscard]] bool tells_how_many(const Mode& alone) const {
    if (decides_how_many()) return true;
    return std::ranges::none_of(std::array{&one_, &other_}, [&](const Linearization* found) {
      return std::ranges::any_of(found->modes, [&](const Mode& mode) {
        return (is_unresolved(mode) || mode.is_half_of_unresolved_pair) && abs_of(alone) <= abs_of(mode);
      });
    });
  }

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
    const double scale = std::max(abs_of(mode), slowest_);
    const double least = kWithinResolution * std::max(mode.eigenvalue_resolution, other.eigenvalue_resolution);
    const std::size_t line = lines_.size();
    NumberRow row = number(fmt::format("eigenvalue {}", line), "1/s", abs_of(mode), abs_of(other), scale, kEigenvalue);
    row.digits = matching_digits(std::abs(mode.eigenvalue - other.eigenvalue), scale);
    row.resolvable = matching_digits(least, scale);
    // Of an eigenvalue that may as well be a third of it nothing is known.
    const bool is_known = *row.resolvable >= kHalfADigit && (mode.is_free == other.is_free || decides_what_is_free());
    if (!is_known) row.resolvable = 0.0;
    if (*row.resolvable < kFewDigits)
      unresolved_.push_back(fmt::format("{} ({}: {})", line, mode.motion, format_digits(*row.resolvable)));
    NumberRow shape{fmt::format("shape of mode {}", line), "", kNoValues, kMostDigits, kEigenvalue};
    const double least_of_shape = kWithinResolution * std::max(mode.shape_resolution, other.shape_resolution);
    shape.digits = matching_digits(shape_difference(mode, other), 1.0);
    shape.resolvable = matching_digits(least_of_shape, 1.0);
    const bool has_shape = !mode.is_free && least_of_shape < kAnyMixture;
    add_line(mode, digits_cell(row.digits, row.resolvable),
             has_shape ? digits_cell(shape.digits, shape.resolvable) : "-", "");
    result_.numbers.push_back(row);
    if (!mode.is_free) result_.numbers.push_back(real_part(std::move(row), line, mode, other, least));
    if (has_shape) result_.numbers.push_back(std::move(shape));
  }

  /// Beside the eigenvalue's row, as far as that agrees; `least`: what of it is not resolved [1/s].
  static NumberRow real_part(NumberRow row, std::size_t line, const Mode& mode, const Mode& other, double least) {
    constexpr double kSeenByNights = 1e-4;  // of the scale; what is not resolved is no change
    row.name = fmt::format("real part of eigenvalue {}", line);
    row.values = {mode.eigenvalue.real(), other.eigenvalue.real()};
    row.scale = std::max(abs_of(mode), least / kSeenByNights);
    return row;
  }

  void judge_alone(const char* solver, const Mode& mode, const std::array<double, 2>& values) {
    add_line(mode, format_digits(0.0), "-", fmt::format(" (found by {} alone)", solver));
    NumberRow row{fmt::format("eigenvalue {} of {} alone", lines_.size() - 1, solver), "1/s", values, 0.0, kEigenvalue};
    const bool is_open = is_unresolved(mode) || mode.is_half_of_unresolved_pair || !tells_how_many(mode);
    if (is_open || (mode.is_free && !decides_what_is_free())) row.resolvable = 0.0;
    result_.numbers.push_back(std::move(row));
  }

  void add_line(const Mode& mode, std::string digits, std::string shape_digits, const std::string& remark) {
    lines_.push_back({fmt::format("{}", lines_.size()), fmt::format("{:.10g}", mode.frequency()),
                      fmt::format("{:.6g}", mode.damping_ratio()), eigenvalue_text(mode), std::move(digits),
                      std::move(shape_digits), (mode.is_free ? "free: " : "") + mode.motion + remark});
  }

  const Linearization& one_;
  const Linearization& other_;
  double slowest_;
  AnalysisVerdict& result_;
  std::vector<std::string> unresolved_;
  Lines lines_{{"mode", "frequency [Hz]", "damping ratio", "eigenvalue [1/s]", "digits", "shape digits", "motion"}};
};

/// About a motion that is not steady, modes say how the machine behaves as if it stayed as it is now.
std::string steadiness_text(const Steadiness& steadiness) {
  if (steadiness.is_steady()) return "";
  if (steadiness.accelerates) {
    return "note: the machine accelerates in this state: modes are those of the machine frozen in it\n";
  }
  if (std::isinf(steadiness.change)) {
    return "note: whether the motion is steady is not known, as there is no linearization a little later; modes are "
           "those of the machine frozen in this state\n";
  }
  return fmt::format(
      "note: the motion is not steady: in a radian of it the matrices change by {:.2g} of the fastest rate; modes are "
      "those of the machine frozen in this state, and may be those of no motion\n",
      steadiness.change);
}

std::string axes_text(const Model& model, const TurningLinearization& turning) {
  const TurningAxes& axes = turning.found.axes;
  const auto line = [&](const Vec3& W, const std::string& what) {
    return fmt::format(
        "note: {} axes that turn at ({:.6g}, {:.6g}, {:.6g}) rad/s; deviations of {} are measured in them\n",
        turning.is_steady ? "the motion is steady in"
                          : "the machine accelerates a little, but its matrices do not change, in",
        W(0), W(1), W(2), what);
  };
  std::string text;
  if (axes.of_bodies) text += line(*axes.of_bodies, "all bodies");
  for (std::size_t k = 0; k < axes.rates.size(); ++k) {
    if (axes.rates[k].isZero(0.0)) continue;
    text += line(axes.rates[k], fmt::format("the ball{} of {}", axes.carry_places ? " and the displacements" : "",
                                            model.joints[k].name));
  }
  return text;
}

/// A motion that is not steady in the axes of the joints' sides may be so in others; both solvers then measure in them.
void measure_in_steady_axes(const Model& model, const Solvers& solvers, const std::array<Trajectory, 2>& states,
                            AnalysisVerdict& result) {
  const auto state_of = [&](Who who) -> const State& { return states[index(who)].samples[0].state; };
  const Steadiness steadiness = steadiness_of(model, *solvers[0], *result.linearizations[0]);
  std::optional<TurningLinearization> turning;
  if (!steadiness.is_steady()) turning = linearize_in_steady_axes(model, *solvers[0], state_of(Who::cartesian));
  const auto is_as_constant = [&] { return has_constant_matrices(model, *solvers[0], *result.linearizations[0]); };
  if (!turning || (!turning->is_steady && is_as_constant())) {
    result.text += steadiness_text(steadiness);
    return;
  }
  result.text += axes_text(model, *turning);
  result.linearizations[1] = linearize(model, *solvers[1], state_of(Who::relative), turning->found.axes);
  result.linearizations[0] = std::move(turning->found);
}

/// How far an eigenvalue and its shape are from solving lambda^2 x = A x + lambda B x, as a part of the three terms,
/// beyond what is not resolved of them. Both solvers' modes come from one search, which this does not call.
double misfit_of(const Mode& mode, const Linearization& found) {
  constexpr double kStray = 1e-5;  // equal eigenvalues stray by the root of the round-off
  constexpr double kRoundOff = 1e-11;
  const std::complex<double> lambda = mode.eigenvalue;
  const Eigen::VectorXcd& x = mode.coordinates;
  const Eigen::VectorXcd pull = found.A * x;
  const Eigen::VectorXcd drag = lambda * (found.B * x);
  const double terms = std::norm(lambda) + pull.norm() + drag.norm();
  const double sizes = found.A.norm() + std::abs(lambda) * found.B.norm() + std::norm(lambda);
  // Of half a pair the imaginary part is left out, which may be as large as what is taken for not resolved.
  const double times = mode.is_half_of_unresolved_pair ? kWithinResolution : 1.0;
  const double open = kStray * terms + (kRoundOff + times * mode.shape_resolution) * sizes +
                      times * mode.eigenvalue_resolution * (2.0 * std::abs(lambda) + found.B.norm());
  return std::max(0.0, (lambda * lambda * x - pull - drag).norm() - open) / terms;
}

void require_modes_to_fit(const Linearization& found, std::string_view solver, AnalysisVerdict& result) {
  constexpr double kFits = 1e-4;
  for (const Mode& mode : found.modes) {
    if (mode.is_free || mode.eigenvalue == 0.0 || is_unresolved(mode)) continue;
    const double misfit = misfit_of(mode, found);
    if (misfit <= kFits) continue;
    result.wrenches.findings.push_back(
        {fmt::format(
             "{}: the mode of {} at {:.6g} Hz does not solve the equations that it is a mode of: they are open by "
             "{:.1e} of their terms",
             solver, mode.motion, mode.frequency(), misfit),
         "linearize: eigenvalues or shapes are none of the matrices"});
    return;
  }
}

/// The equilibria that each solver finds, which must be the same rest.
Rests rests(const Model& model, const Solvers& solvers, AnalysisVerdict& result) {
  Rests rests = find_rests(model, solvers);
  const auto& [found, states] = rests;
  for (const Who who : kBothSolvers) {
    result.text += equilibrium_text(found[index(who)], solvers[index(who)]->name());
    require_arrived(found[index(who)], solvers[index(who)]->name(), result);
  }
  if (compare_motions(model, {&states[0], &states[1]}).digits < own_need(model)) {
    refuse_undetermined_rest(model, solvers, rests);
  }
  return rests;
}

std::array<Trajectory, 2> starts(const Solvers& solvers) {
  std::array<Trajectory, 2> states;
  for (const Who who : kBothSolvers) {
    const State start = solvers[index(who)]->assemble();
    states[index(who)] = one_sample(start, solvers[index(who)]->evaluate(start));
  }
  return states;
}

/// Deviations are measured along what is permitted. Where a joint forbids velocities alone and moves, a deviation of
/// the place changes what it permits, too: a skate that turns aside goes aside.
std::string nonholonomic_text(const Model& model, const Trajectory& at) {
  constexpr double kAtRest = 1e-9;
  const double length = model.length_scale();
  const double size = MachineSize(model, at).speed_or();
  std::string text;
  for (const Joint& joint : model.joints) {
    if (joint.type->nonholonomic_rows() == 0) continue;
    const Vec6 v_rel = relative_motion_of(joint, at.samples.front().state).v_rel;
    if (std::max(v_rel.head<3>().norm(), length * v_rel.tail<3>().norm()) <= kAtRest * size) continue;
    text += fmt::format(
        "note: joint '{}' ({}) moves and constrains speeds alone: what it permits changes with the place, which is "
        "left "
        "out here, so that the modes may be those of no motion; read growth and frequencies from a run\n",
        joint.name, joint.type->name);
  }
  return text;
}

}  // namespace

AnalysisVerdict judge_linearization(const Model& model, const SolverMakers& makers, bool at_equilibrium) {
  Model held = at_equilibrium ? held_at_start(model) : model;
  AnalysisVerdict result;
  result.analysis = "linearize";
  const Solvers solvers = make_solvers(held, makers, result);
  Found kind = Found::motion;
  std::array<Trajectory, 2> states;
  if (at_equilibrium) {
    Rests found = rests(held, solvers, result);
    kind = kind_of(found);
    states = std::move(found.states);
  } else {
    states = starts(solvers);
  }
  result.text += nonholonomic_text(held, states[0]);
  for (const Who who : kBothSolvers) {
    result.linearizations[index(who)] = linearize(held, *solvers[index(who)], states[index(who)].samples[0].state);
  }
  judge_wrenches(held, solvers, states, kind, result);
  // Where both have found their equilibrium, what is left of its accelerations is no motion.
  if (!at_equilibrium) measure_in_steady_axes(held, solvers, states, result);
  result.text += free_text(*result.linearizations[0], *result.linearizations[1]);
  result.text += fmt::format("modes about the {}, by cartesian:\n", at_equilibrium ? "equilibrium" : "start");
  ModeJudge(*result.linearizations[0], *result.linearizations[1], result).judge();
  for (const Who who : kBothSolvers) {
    require_modes_to_fit(*result.linearizations[index(who)], solvers[index(who)]->name(), result);
  }
  require_unique(result);
  conclude(result);
  result.machine = std::move(held);
  return result;
}

}  // namespace concord::compare::analyses
