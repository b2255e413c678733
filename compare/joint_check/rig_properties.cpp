#include "compare/joint_check/rig_properties.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cartesian/equations.h"
#include "cartesian/solver.h"
#include "compare/audit/balance.h"
#include "compare/joint_check/rig.h"
#include "compare/verdict/agreement.h"
#include "compare/verdict/align.h"
#include "compare/verdict/needs.h"
#include "relative/equations.h"
#include "relative/solver.h"
#include "relative/states.h"

namespace concord::compare::joint_check {

namespace {

constexpr double kNeed = 12.0;       // digits of wrenches, accelerations and their audit, rigid and flexible
constexpr double kStateNeed = 12.0;  // of closed states and of coordinates read back
constexpr double kVanishes = 1e-11;  // of the weight: a component that a joint cannot carry
constexpr double kAppears = 1e-6;    // of the weight: a component that it can

// Who is asked about what --------------------------------------------------------------------------------------------

/// Each solver with the joint in the tree, and in a loop that is cut at it.
enum Opinion : std::size_t { cartesian_open, tree_open, cut_idle, cartesian_loop, tree_loop, cut_loop };
constexpr std::size_t kOpinions = 6;
constexpr std::array<const char*, kOpinions> kOpinionNames{
    "cartesian, open rig",   "relative, tree joint, open rig",   "relative, cut joint, open rig with an idle loop",
    "cartesian, closed rig", "relative, tree joint, closed rig", "relative, cut joint, closed rig"};

constexpr bool in_loop(std::size_t who) { return who >= cartesian_loop; }

const Model& model_of(const Rig& rig, std::size_t who) {
  switch (who) {
    case cut_idle:
      return rig.idle_loop();
    case cartesian_loop:
    case cut_loop:
      return rig.loop_cut_at_tested();
    case tree_loop:
      return rig.loop_cut_at_ball();
    default:
      return rig.open();
  }
}

State state_of(const Rig& rig, std::size_t who, const State& open) {
  if (in_loop(who)) return rig.in_loop(open);
  return who == cut_idle ? Rig::in_idle_loop(open) : open;
}

std::unique_ptr<Solver> solver_of(const Rig& rig, std::size_t who) {
  const bool is_cartesian = who == cartesian_open || who == cartesian_loop;
  return is_cartesian ? cartesian::make_solver(model_of(rig, who)) : relative::make_solver(model_of(rig, who));
}

/// The same poses through all of them.
struct Opinions {
  std::vector<int> poses;
  std::array<std::vector<State>, kOpinions> states;
  std::array<std::vector<Evaluation>, kOpinions> evaluations;
  std::array<AuditReport, kOpinions> audits;

  [[nodiscard]] int pose_at(double t) const {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      if (states[cartesian_open][k].t == t) return poses[k];
    }
    return -1;
  }
};

Opinions ask_all(Rig& rig, const std::vector<int>& poses) {
  Opinions opinions;
  opinions.poses = poses;
  std::vector<State> open;
  for (const int pose : poses) open.push_back(rig.state(pose));
  for (std::size_t who = 0; who < kOpinions; ++who) {
    const std::unique_ptr<Solver> solver = solver_of(rig, who);
    Auditor auditor(model_of(rig, who));
    for (const State& at : open) {
      const State& state = opinions.states[who].emplace_back(state_of(rig, who, at));
      opinions.evaluations[who].push_back(solver->evaluate(state));
      auditor.add(state, opinions.evaluations[who].back());
    }
    opinions.audits[who] = auditor.report();
  }
  return opinions;
}

// Wrenches -----------------------------------------------------------------------------------------------------------

/// Agreement of two opinions on all of the joint under test and on all accelerations. A wrench is compared with the
/// joint's peak, and at least against the weight of the rig.
void compare_opinions(const Rig& rig, const Opinions& opinions, Opinion one, Opinion other, const std::string& context,
                      Property& property) {
  // The joint that makes an idle loop is nothing that the open rig has.
  const Model& model = model_of(rig, one);
  std::vector<SharedState> shared;
  for (std::size_t k = 0; k < opinions.poses.size(); ++k) {
    SharedState both{opinions.states[one][k], {opinions.evaluations[one][k], opinions.evaluations[other][k]}};
    both.evaluations[1].joints.resize(model.joints.size());
    shared.push_back(std::move(both));
  }
  const QuantityLayout layout(model);
  const std::vector<Measured> measured = measure(layout, align(layout, shared));
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    double scale = measured[row].scale;
    if (quantity.kind != Kind::acceleration) {
      if (quantity.kind != Kind::body_sum && quantity.owner != Rig::kTested) continue;
      scale = std::max(scale, rig.weight() * (unit_of(model, quantity) == "N" ? 1.0 : model.length_scale()));
    }
    property.note(measured[row].difference / scale, opinions.poses[measured[row].worst], [&] {
      return fmt::format("{}: {}, {}: {} {:.9g}, {} {:.9g}, scale {:.3g}", context, describe_owner(model, quantity),
                         describe_component(quantity), kOpinionNames[one], measured[row].values[0],
                         kOpinionNames[other], measured[row].values[1], scale);
    });
  }
}

void note_audits(const Opinions& opinions, const std::string& context, Properties& rules) {
  for (std::size_t who = 0; who < kOpinions; ++who) {
    for (std::size_t rule = 0; rule < rules.size(); ++rule) {
      const AuditFinding& finding = opinions.audits[who].rules[rule];
      if (finding.row.empty()) continue;
      rules[rule].note(std::pow(10.0, -finding.digits), opinions.pose_at(finding.t),
                       [&] { return fmt::format("{}: {}: {}", context, kOpinionNames[who], finding.text()); });
    }
  }
}

/// Largest reaction components on each side, in its joint frame, relative to the weight.
using Largest = std::array<Vec6, 2>;

void note_largest(const Rig& rig, const Opinions& opinions, Largest& largest) {
  for (const auto& evaluations : opinions.evaluations) {
    for (const Evaluation& evaluation : evaluations) {
      for (const Side side : {Side::parent, Side::child}) {
        Vec6 reaction = evaluation.joints[Rig::kTested].reaction_on(side).in_C.vector() / rig.weight();
        reaction.tail<3>() /= rig.open().length_scale();
        largest[index(side)] = largest[index(side)].cwiseMax(reaction.cwiseAbs());
      }
    }
  }
}

bool says_nothing_of_components(const JointType& type) {
  return type.nonholonomic_rows() > 0 ||
         std::any_of(type.permits.begin(), type.permits.end(),
                     [](const joints::Permit& word) { return std::holds_alternative<joints::ByMotion>(word); });
}

/// Of a type by functions, or one that forbids velocities alone, the page does not say which components vanish: every
/// one may appear, none must.
void require_carried(const JointType& type, const Largest& largest, Property& property) {
  for (const Side side : {Side::parent, Side::child}) {
    for (int component = 0; component < 6; ++component) {
      const double found = largest[index(side)](component);
      const bool said = joints::carries(type, side, component);
      const bool right = said ? found > kAppears || says_nothing_of_components(type) : found < kVanishes;
      property.require(right, -1, [&] {
        return fmt::format("{} on the {} is {} be carried, but reaches {:.3g} of the rig's weight",
                           component_names()[component], side == Side::parent ? "parent" : "child",
                           said ? "said to" : "not said to", found);
      });
    }
  }
}

// States, turns, rank ------------------------------------------------------------------------------------------------

/// Largest closure residual of a state in the Cartesian solver's own equations: positions, and velocities relative to
/// the largest.
double residual_of(cartesian::Equations& equations, const State& state) {
  VecX q = VecX::Zero(equations.layout().n_q());
  VecX Y = VecX::Zero(equations.layout().n_Y());
  equations.layout().unpack(state, q, Y);
  equations.update(state.t, q, Y);
  if (equations.residual().size() == 0) return 0.0;
  return std::max(equations.residual().lpNorm<Eigen::Infinity>(),
                  equations.velocity_residual().lpNorm<Eigen::Infinity>() / (1.0 + Y.lpNorm<Eigen::Infinity>()));
}

/// The outer body pushed and turned out of its place.
State disturbed(State state, Numbers& numbers) {
  BodyState& body = state.bodies[2];
  body.r += numbers.vector(0.05);
  body.v += numbers.vector(0.3);
  body.omega += numbers.vector(0.3);
  body.p = (body.p + Vec4(numbers.vector(4, 0.05))).normalized();
  return state;
}

void exchange_states(Rig& rig, std::uint32_t seed, const std::vector<int>& poses, const std::string& context,
                     Property& property) {
  cartesian::Equations cartesian_equations(rig.open());
  relative::Equations relative_equations(rig.open());
  relative::States relative_states(relative_equations);
  const std::unique_ptr<Solver> cartesian = cartesian::make_solver(rig.open());
  for (const int pose : poses) {
    const State state = rig.state(pose);
    const double residual = residual_of(cartesian_equations, state);
    property.note(residual, pose, [&] {
      return fmt::format("{}: a state made by relative is {:.3g} (m, rad) open in cartesian", context, residual);
    });
    Numbers numbers(seed, streams::kFirstDisturbance + static_cast<std::uint32_t>(pose));
    const std::optional<State> closed = cartesian->close(disturbed(state, numbers));
    property.require(closed.has_value(), pose,
                     [&] { return fmt::format("{}: cartesian does not close a disturbed state", context); });
    if (!closed) continue;
    relative::StateMisfit misfit;
    (void)relative_states.read(*closed, misfit);
    property.note(misfit.largest, pose, [&] {
      return fmt::format("{}: a state closed by cartesian misfits {} by {:.3g} in relative", context, misfit.where,
                         misfit.largest);
    });
  }
}

/// Coordinates along a way from two and a half turns back to three turns ahead, `s` from 0 to 1; an orientation turns
/// about an axis of no frame; what cannot turn goes to and fro.
VecX coordinates_along(const JointType& type, double s) {
  const double turned = (5.5 * s - 2.5) * 2.0 * std::numbers::pi;
  VecX q(type.n_q());
  for (std::size_t k = 0; k < type.permits.size(); ++k) {
    if (!std::holds_alternative<joints::Ball>(type.permits[k])) continue;
    const Vec3 axis = Vec3(1.0, -2.0, 0.7).normalized();
    q.segment<4>(first_q(type, static_cast<int>(k))) << std::cos(0.5 * turned), std::sin(0.5 * turned) * axis;
  }
  for (const Coordinate& coordinate : coordinates_of(type)) {
    const double middle = 0.5 * (coordinate.greatest + coordinate.least);
    const double reach = 0.5 * (coordinate.greatest - coordinate.least);
    const bool goes_round = coordinate.is_turn && reach > 3.0 * 2.0 * std::numbers::pi;
    q(coordinate.q) =
        goes_round ? turned / (1.0 + 0.4 * coordinate.u) : middle + 0.8 * reach * std::sin(0.3 * turned + coordinate.u);
  }
  return q;
}

void follow_turns(Rig& rig, Property& property) {
  constexpr int kSteps = 60;
  const JointType& type = *rig.open().joints[Rig::kTested].type;
  for (const Opinion who : {cartesian_open, tree_open, cut_idle}) {
    const std::unique_ptr<Solver> solver = solver_of(rig, who);
    VecX known = coordinates_along(type, 0.0);
    for (int step = 0; step <= kSteps; ++step) {
      const VecX q = coordinates_along(type, static_cast<double>(step) / kSteps);
      State state = rig.state_at(q);
      state.q[Rig::kTested] = known;
      const std::optional<State> closed = solver->close(state_of(rig, who, state));
      property.require(closed.has_value(), -1, [&] {
        return fmt::format("{}: step {} of {} does not close", kOpinionNames[who], step, kSteps);
      });
      if (!closed) return;
      known = closed->q[Rig::kTested];
      const double error = (known - q).norm();
      property.note(error / (1.0 + q.norm()), -1, [&] {
        return fmt::format("{}: step {} of {}: coordinates {:.3g} (m, rad) off", kOpinionNames[who], step, kSteps,
                           error);
      });
    }
  }
}

void require_rank(Rig& rig, const Arrangement& arrangement, int pose, Property& property) {
  const auto& joint = rig.open().joints[Rig::kTested];
  const int drivers = static_cast<int>(joint.drivers.size());
  const int modes = rig.open().bodies[1].n_modes() + rig.open().bodies[2].n_modes();
  const State open = rig.state(pose);
  for (std::size_t who = 0; who < kOpinions; ++who) {
    const int ball = in_loop(who) ? 3 : 0;
    const int rows = joint.type->rows() + joint.type->nonholonomic_rows() + drivers + ball;
    const int freedom = 6 + joint.type->n_u() - joint.type->nonholonomic_rows() - drivers - ball + modes;
    const RankReport report = solver_of(rig, who)->rank(state_of(rig, who, open));
    bool unique = true;
    for (const auto& side : report.joints[Rig::kTested].unique) {
      unique = unique && std::all_of(side.begin(), side.end(), [](bool component) { return component; });
    }
    const bool right = report.constraints == rows && report.rank == rows && report.degrees_of_freedom == freedom &&
                       !report.undecided && unique;
    property.require(right, pose, [&] {
      return fmt::format("{}: {}: {} constraints of rank {}, {} degrees of freedom, {}; expected {}, {}, {}, unique",
                         describe(arrangement), kOpinionNames[who], report.constraints, report.rank,
                         report.degrees_of_freedom, report.undecided ? "undecided" : (unique ? "unique" : "not unique"),
                         rows, rows, freedom);
    });
  }
}

// All of it ----------------------------------------------------------------------------------------------------------

/// Whether so many coordinates of a type can be driven, and a start be said for the rest: no more than there are
/// speeds, and where only some of a ball's speeds are possible none, because a start keeps all three or no one.
bool can_be_driven(const JointType& type, std::size_t driven) {
  const bool has_ball = std::any_of(type.permits.begin(), type.permits.end(), [](const joints::Permit& word) {
    return std::holds_alternative<joints::Ball>(word);
  });
  if (type.nonholonomic_rows() > 0 && has_ball) return false;
  return static_cast<int>(driven) <= type.n_u() - type.nonholonomic_rows();
}

/// Loads of all coordinates, for one column of the table; several where the driven coordinate is one of many.
std::vector<std::vector<Load>> loads_of(std::size_t column, const JointType& type) {
  const std::size_t coordinates = coordinates_of(type).size();
  if (column == 0) return {std::vector<Load>(coordinates, Load::none)};
  if (coordinates == 0) return {};
  if (column == 1) return {std::vector<Load>(coordinates, Load::spring)};
  if (column == 2) return {std::vector<Load>(coordinates, Load::motor)};
  if (!can_be_driven(type, column == 3 ? coordinates : 1)) return {};
  if (column == 3) return {std::vector<Load>(coordinates, Load::driver)};
  std::vector<std::vector<Load>> mixed;
  for (std::size_t driven = 0; driven < coordinates && coordinates > 1; ++driven) {
    mixed.emplace_back(coordinates, Load::spring)[driven] = Load::driver;
  }
  return mixed;
}

std::string plain_name(AuditRule rule) {
  switch (rule) {
    case AuditRule::free_body:
      return "audit: every body moves as the wrenches on it say";
    case AuditRule::workless:
      return "audit: the reaction is workless";
    case AuditRule::both_sides:
      return "audit: both sides are in balance";
    case AuditRule::two_frames:
      return "audit: joint frame and global axes say the same";
    case AuditRule::drivers:
      return "audit: what drivers, springs and motors add is their coordinate wrench";
    case AuditRule::force_law:
      return "audit: springs and motors obey their laws";
    case AuditRule::kinematics:
      return "audit: places, velocities and accelerations are such as the joint permits";
    case AuditRule::driver_law:
      return "audit: driven coordinates follow their laws";
    case AuditRule::derivatives:
      return "audit: derivatives of functions are those by differences";
    default:
      return fmt::format("audit: {}", name_of(rule));
  }
}

class RigCheck {
 public:
  RigCheck(const JointType& type, std::uint32_t seed, const std::vector<int>& poses)
      : type_(type), seed_(seed), poses_(poses) {
    for (int pair = 0; pair < WrenchTable::kPairs; ++pair) {
      for (int load = 0; load < WrenchTable::kLoads; ++load) {
        for (int rig = 0; rig < WrenchTable::kRigs; ++rig) {
          cells_.emplace_back(
              fmt::format("same wrenches and accelerations: {}, {}, {}", WrenchTable::pair_names()[pair],
                          WrenchTable::load_names()[load], WrenchTable::rig_names()[rig]),
              kNeed);
        }
      }
    }
    for (int rule = 0; rule < kAuditRules; ++rule) {
      const auto which = static_cast<AuditRule>(rule);
      audits_.emplace_back(plain_name(which), need_of(which) < kAudit ? need_of(which) : kNeed);
    }
  }

  void run() {
    for (int pair = 0; pair < WrenchTable::kPairs; ++pair) {
      for (const bool against : {false, true}) {
        for (int column = 0; column < WrenchTable::kLoads; ++column) {
          for (const std::vector<Load>& loads : loads_of(column, type_)) {
            build_in({pair >= 2, pair % 2 == 1, against, loads}, pair, column);
          }
        }
      }
    }
    if (finished_.holds()) require_carried(type_, largest_, carried_);
  }

  [[nodiscard]] RigFindings findings() const {
    RigFindings found;
    found.properties = {finished_, exchanged_, turns_, rank_, carried_};
    found.properties.insert(found.properties.end(), audits_.begin(), audits_.end());
    found.wrenches.cells = cells_;
    return found;
  }

 private:
  /// One rig through everything; what a solver throws is a finding.
  void build_in(const Arrangement& arrangement, int pair, int column) {
    try {
      Rig rig(type_, arrangement, seed_);
      look_at(rig, arrangement, pair, column);
      finished_.require(true, -1, [] { return ""; });
    } catch (const std::exception& error) {
      finished_.require(false, -1, [&] { return fmt::format("{}: {}", describe(arrangement), error.what()); });
    }
  }

  void look_at(Rig& rig, const Arrangement& arrangement, int pair, int column) {
    const std::string context = describe(arrangement);
    if (column == 0) exchange_states(rig, seed_, poses_, context, exchanged_);
    if (column == 0 && pair == 3) follow_turns(rig, turns_);
    if (column == 0 || column == 3) require_rank(rig, arrangement, poses_.front(), rank_);
    const Opinions opinions = ask_all(rig, poses_);
    Property* cells = &cells_[(pair * WrenchTable::kLoads + column) * WrenchTable::kRigs];
    for (const Opinion other : {tree_open, cut_idle}) {
      compare_opinions(rig, opinions, cartesian_open, other, context, cells[0]);
    }
    for (const Opinion other : {tree_loop, cut_loop}) {
      compare_opinions(rig, opinions, cartesian_loop, other, context, cells[1]);
    }
    note_audits(opinions, context, audits_);
    note_largest(rig, opinions, largest_);
  }

  const JointType& type_;
  std::uint32_t seed_;
  const std::vector<int>& poses_;
  Property finished_{"both solvers build the rigs and finish", {}};
  Property exchanged_{"each solver accepts the other's states", kStateNeed};
  Property turns_{"turns are counted, in the tree and cut, by both solvers", kStateNeed};
  Property rank_{"constraints have full rank, every reaction is unique", {}};
  Property carried_{"the components that the type carries, and no others, appear", {}};
  Properties audits_;
  std::vector<Property> cells_;
  Largest largest_{Vec6::Zero(), Vec6::Zero()};
};

}  // namespace

const std::array<std::string, WrenchTable::kPairs>& WrenchTable::pair_names() {
  static const std::array<std::string, kPairs> names{"rigid - rigid", "rigid - flexible", "flexible - rigid",
                                                     "flexible - flexible"};
  return names;
}

const std::array<std::string, WrenchTable::kLoads>& WrenchTable::load_names() {
  static const std::array<std::string, kLoads> names{"free", "sprung", "motored", "driven", "one driven, rest sprung"};
  return names;
}

const std::array<std::string, WrenchTable::kRigs>& WrenchTable::rig_names() {
  static const std::array<std::string, kRigs> names{"open", "closed"};
  return names;
}

RigFindings check_in_rigs(const JointType& type, std::uint32_t seed, const std::vector<int>& poses) {
  RigCheck check(type, seed, poses);
  check.run();
  return check.findings();
}

}  // namespace concord::compare::joint_check
