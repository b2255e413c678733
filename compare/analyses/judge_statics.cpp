#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "compare/analyses/judge_steps.h"
#include "compare/audit/digits.h"
#include "compare/audit/joint_motion.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"
#include "compare/report/text_table.h"
#include "compare/states/branch.h"
#include "compare/states/chart.h"
#include "compare/verdict/refinement.h"

namespace concord::compare::analyses {

namespace {

/// A body that deflects less, of the machine's length, is compared with this: it may be straight but for round-off.
constexpr double kLeastDeflection = 1e-6;

/// Calls `use` with name, unit, scale and number of every joint coordinate and modal coordinate, and with whether whole
/// turns of it change nothing. Of the two sets of Euler parameters of an orientation the one nearer to that of `like`.
template <class Use>
void for_each_coordinate(const Model& model, const State& state, const State& like, const Use& use) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const JointMotion motion = motion_of(model, k, state);
    const std::vector<std::string> names = speed_names(*joint.type);
    const std::vector<bool> turns = turning_speeds(*joint.type);
    for (std::size_t word = 0; word < joint.type->permits.size(); ++word) {
      const int q = first_q(*joint.type, static_cast<int>(word));
      if (is_orientation(joint.type->permits[word])) {
        const Vec4 p = motion.q.segment<4>(q);
        const double sign = p.dot(motion_of(model, k, like).q.segment<4>(q)) < 0.0 ? -1.0 : 1.0;
        for (int c = 0; c < 4; ++c)
          use(fmt::format("euler_parameter_{} of {}", c, joint.name), "1", 1.0, sign * p(c), false);
        continue;
      }
      const int u = first_u(*joint.type, static_cast<int>(word));
      for (int c = 0; c < n_u(joint.type->permits[word]); ++c) {
        const bool turn = turns[static_cast<std::size_t>(u + c)];
        use(fmt::format("{} of {}", names[static_cast<std::size_t>(u + c)], joint.name), turn ? "rad" : "m",
            turn ? std::max(1.0, std::abs(motion.q(q + c))) : model.length_scale(), motion.q(q + c),
            whole_turns_change_nothing(model, k, static_cast<int>(word), c));
      }
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const VecX& a = state.bodies[i].a;
    if (a.size() == 0) continue;
    const VecX least = kLeastDeflection * model.length_scale() * largest_deflections(model.bodies[i]).cwiseInverse();
    for (Eigen::Index mode = 0; mode < a.size(); ++mode) {
      use(fmt::format("a_{} of {}", mode + 1, model.bodies[i].name), "1",
          std::max(a.cwiseAbs().maxCoeff(), least(mode)), a(mode), false);
    }
  }
}

/// What double precision leaves of a joint's coordinate where bodies are far from the origin: digits of the machine's
/// length, or of a radian.
double digits_of_places(const Model& model, const State& state) {
  double farthest = 0.0;
  for (const BodyState& body : state.bodies) farthest = std::max(farthest, body.r.norm());
  const double round_off = std::numeric_limits<double>::epsilon() * farthest / model.length_scale();
  return matching_digits(kWithinResolution * round_off, 1.0);
}

/// Coordinates of two states, judged; and their values at the start in the text's table.
std::string judge_coordinates(const Model& model, const State& start, const std::array<const State*, 2>& found,
                              AnalysisVerdict& result) {
  std::array<std::vector<double>, 3> values;
  const std::array<const State*, 3> states{&start, found[0], found[1]};
  for (std::size_t k = 0; k < states.size(); ++k) {
    for_each_coordinate(model, *states[k], *found[0], [&](const std::string&, const char*, double, double value, bool) {
      values[k].push_back(value);
    });
  }
  Lines lines{{"coordinate", "start", "cartesian", "relative", "unit", "digits"}};
  const double of_places = digits_of_places(model, *found[0]);
  std::size_t row = 0;
  for_each_coordinate(
      model, *found[0], *found[0],
      [&](const std::string& name, const char* unit, double scale, double, bool turns_change_nothing) {
        if (turns_change_nothing) values[2][row] = with_turns_of(values[1][row], values[2][row]);
        result.numbers.push_back(number(name, unit, values[1][row], values[2][row], scale, result.own_need));
        if (of_places < result.own_need) result.numbers.back().resolvable = of_places;
        lines.push_back({name, fmt::format("{:.6g}", values[0][row]), fmt::format("{:.10g}", values[1][row]),
                         fmt::format("{:.10g}", values[2][row]), unit, format_digits(result.numbers.back().digits)});
        ++row;
      });
  return lines.size() > 1 ? format_table(lines, {false, true, true, true, false, true}) : "";
}

constexpr const char* kNotUniqueMark = "*";

std::vector<std::string> wrench_cells(const std::string& name, const std::string& body, const Wrench& wrench) {
  std::vector<std::string> line{name, body};
  for (const double value : wrench.vector()) line.push_back(fmt::format("{:.6g}", value));
  return line;
}

/// Whether a component of a reaction is one of those that balance alone does not determine.
bool is_not_unique(const Verdict& verdict, int joint, Side side, int component) {
  return std::any_of(verdict.rows.begin(), verdict.rows.end(), [&](const QuantityRow& row) {
    const Quantity& one = row.quantity;
    return !row.unique && one.kind == Kind::reaction && one.owner == joint && one.side == side &&
           one.component == component;
  });
}

/// Reactions on both sides and element wrenches on their ends, as one solver gives them; what is not unique is marked.
std::string wrench_text(const Model& model, const Evaluation& evaluation, const Verdict& verdict) {
  bool has_marks = false;
  Lines lines{{"joint or element", "on", "F_x [N]", "F_y", "F_z", "T_x [N m]", "T_y", "T_z"}};
  for (const Side side : {Side::parent, Side::child}) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      lines.push_back(wrench_cells(model.joints[k].name, model.bodies[model.joints[k].on(side).body].name,
                                   evaluation.joints[k].reaction_on(side).in_C));
      for (int component = 0; component < 6; ++component) {
        if (!is_not_unique(verdict, static_cast<int>(k), side, component)) continue;
        lines.back()[static_cast<std::size_t>(2 + component)] = kNotUniqueMark;
        has_marks = true;
      }
    }
    for (std::size_t k = 0; k < model.elements.size(); ++k) {
      const Attachment* end = end_of(model.elements[k], side);
      if (end == nullptr) continue;
      lines.push_back(wrench_cells(model.elements[k].name, model.bodies[end->body].name,
                                   evaluation.elements[k].on_side(side).in_C));
    }
  }
  std::stable_sort(lines.begin() + 1, lines.end(), [](const auto& a, const auto& b) { return a.front() < b.front(); });
  return "reactions and element wrenches by cartesian, in the frames of their sides:\n" +
         format_table(lines, {false, false, true, true, true, true, true, true}) +
         (has_marks ? "* not unique: another share of the same sum balances the machine as well\n" : "");
}

void compare_stiffness(const std::array<Equilibrium, 2>& found, AnalysisVerdict& result) {
  const auto size = [](const Equilibrium& one) { return static_cast<double>(one.free.size()); };
  result.numbers.push_back(
      number("directions without stiffness", "", size(found[0]), size(found[1]), 1.0, kMostDigits));
  result.numbers.push_back(number("unstable directions", "", found[0].unstable, found[1].unstable, 1.0, kMostDigits));
}

}  // namespace

AnalysisVerdict judge_statics(const Model& model, const SolverMakers& makers) {
  Model held = held_at_start(model);
  AnalysisVerdict result;
  result.analysis = "statics";
  const Solvers solvers = make_solvers(held, makers, result);
  const Rests rests = find_rests(held, solvers);
  const std::array<Equilibrium, 2>& found = rests.found;
  judge_wrenches(held, solvers, rests.states, kind_of(rests), result);
  for (const Who who : kBothSolvers) {
    result.text += equilibrium_text(found[index(who)], solvers[index(who)]->name());
    require_arrived(found[index(who)], solvers[index(who)]->name(), result);
  }
  compare_stiffness(found, result);
  result.text += '\n' + judge_coordinates(held, solvers[0]->assemble(), {&found[0].state, &found[1].state}, result);
  result.text += '\n' + wrench_text(held, found[0].evaluation, result.wrenches);
  const auto agrees = [](const NumberRow& row) { return row.agrees(); };
  if (!std::all_of(result.numbers.begin(), result.numbers.end(), agrees)) {
    refuse_undetermined_rest(held, solvers, rests);
  }
  require_unique(result);
  conclude(result);
  result.machine = std::move(held);
  return result;
}

}  // namespace concord::compare::analyses
