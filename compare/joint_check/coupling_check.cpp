#include "compare/joint_check/coupling_check.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "cartesian/solver.h"
#include "common/joints/catalogue.h"
#include "compare/audit/balance.h"
#include "compare/joint_check/parts.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/quantities/needs.h"
#include "relative/dynamics/equations.h"
#include "relative/solver.h"
#include "relative/start/states.h"

namespace concord::compare::joint_check {

namespace {

constexpr double kCouplingDigits = 12.0;

enum GearJoint : int { kHolder, kPlanet, kSun, kRack };

enum class Actor { none, spring, driver };

struct GearRig {
  bool bends = false;
  Actor actor = Actor::none;
};

std::string in_words(const GearRig& rig) {
  const char* actor = rig.actor == Actor::spring   ? ", hinge sprung"
                      : rig.actor == Actor::driver ? ", slide driven"
                                                   : "";
  return fmt::format("{} bodies{}", rig.bends ? "flexible" : "rigid", actor);
}

/// A free carrier; a planet that turns and slides on it, a sun that the carrier turns on (the joint's child is the
/// carrier), a rack that slides on the planet.
Model build(const GearRig& rig, std::uint32_t seed) {
  Numbers numbers(seed, streams::kRig);
  Model model;
  model.name = "couplings";
  model.file = "couplings";
  model.gravity = Vec3(2.3, -8.9, 3.7);
  model.bodies.emplace_back();
  model.bodies.front().name = "ground";
  for (const char* name : {"carrier", "planet", "sun", "rack"}) {
    const int modes = static_cast<int>(model.bodies.size()) % 3 + 1;
    model.bodies.push_back(rig.bends ? flexible_body(name, modes, numbers) : rigid_body(name, numbers));
  }
  const auto add = [&](const char* name, const char* type, int parent, int child, StartRole role) {
    const joints::JointType& found = *joints::find(type);
    const VecX q = found.name == "free" ? free_q(numbers) : VecX(VecX::Zero(found.n_q()));
    model.joints.push_back(joint(model, name, found, parent, child, q, VecX::Zero(found.n_u()), role, numbers));
  };
  add("holder", "free", kGround, 1, StartRole::keep);
  add("planet", "cylindrical", 1, 2, StartRole::keep);
  add("sun", "revolute", 3, 1, StartRole::guess);
  add("rack", "translational", 2, 4, StartRole::guess);
  model.couplings = {{"gear", {{kPlanet, 1, 0, 1.3}, {kSun, 0, 0, -0.8}}, 0.35, {}},
                     {"mixer", {{kPlanet, 0, 0, 2.1}, {kSun, 0, 0, 0.4}, {kRack, 0, 0, 1.7}}, -0.2, {}}};
  if (rig.actor == Actor::spring) {
    ForceLaw law;
    law.stiffness = 7.0;
    law.damping = 1.5;
    law.free = 0.4;
    model.joints[kSun].springs.push_back({0, law, 0});
  }
  if (rig.actor == Actor::driver) {
    model.joints[kPlanet].drivers.push_back({0, Harmonic{0.1, 0.15, 3.0, 0.7}, 0});
    model.joints[kPlanet].start[0].role_q = StartRole::unsaid;
    model.joints[kPlanet].start[0].role_u = StartRole::unsaid;
  }
  return model;
}

/// The same with the hinge cut: a free joint, which carries nothing, holds the sun.
Model with_idle_loop(Model model, std::uint32_t seed) {
  Numbers numbers(seed, streams::kMedian);
  model.joints[kSun].named_as_cut = true;
  const VecX unmoved = (VecX(7) << 0, 0, 0, 1, 0, 0, 0).finished();
  model.joints.push_back(
      joint(model, "closer", *joints::find("free"), kGround, 3, unmoved, VecX::Zero(6), StartRole::guess, numbers));
  return model;
}

/// Place of a term among the coordinates and speeds of its joint (none of these joints has a ball).
int index_of(const Model& model, const CouplingTerm& term) {
  return first_u(*model.joints[term.joint].type, term.word) + term.component;
}

/// Gives the last coordinate of each coupling the value that the others leave it.
void obey(const Model& model, std::vector<VecX>& values, bool rates) {
  for (const Coupling& coupling : model.couplings) {
    double sum = rates ? 0.0 : -coupling.offset;
    const CouplingTerm& last = coupling.terms.back();
    for (const CouplingTerm& term : coupling.terms) {
      if (&term != &last) sum += term.factor * values[term.joint](index_of(model, term));
    }
    values[last.joint](index_of(model, last)) = -sum / last.factor;
  }
}

/// Sum of factor times speed, relative to its largest term, and likewise power over the sum of its parts.
struct CouplingWork {
  double rate = 0.0;
  double power = 0.0;
};

CouplingWork work_of(const Model& model, const Coupling& coupling, double force, const State& state) {
  double sum = 0.0;
  double size = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    const double rate = term.factor * state.u[term.joint](index_of(model, term));
    sum += rate;
    size += std::abs(rate);
  }
  return {sum / size, force * sum / (std::abs(force) * size)};
}

class CouplingCheck {
 public:
  explicit CouplingCheck(const SheetOptions& options) : options_(options) {
    // The last rule, on modal data, is one of beams, of which no rig is made.
    for (int rule = 0; rule < static_cast<int>(AuditRule::modal_data); ++rule) {
      const auto which = static_cast<AuditRule>(rule);
      audits_.emplace_back(fmt::format("audit: {}", name_of(which)),
                           need_of(which) < kAudit ? need_of(which) : kCouplingDigits);
    }
  }

  void look_at(const GearRig& rig) {
    context_ = in_words(rig);
    const Model open = build(rig, options_.seed);
    const Model cut = with_idle_loop(open, options_.seed);
    relative::Equations equations(open);
    relative::States states(equations);
    std::vector<State> in_open;
    std::vector<State> in_cut;
    for (const int pose : options_.poses) {
      in_open.push_back(draw(open, equations, states, pose));
      in_cut.push_back(in_open.back());
      in_cut.back().q.emplace_back((VecX(7) << 0, 0, 0, 1, 0, 0, 0).finished());
      in_cut.back().u.emplace_back(VecX::Zero(6));
    }
    const auto cartesian = cartesian::make_solver(open);
    const auto tree = relative::make_solver(open);
    const auto in_loop = relative::make_solver(cut);
    for (const auto* solver : {&cartesian, &tree}) require_rank(open, **solver, in_open.front());
    require_rank(open, *in_loop, in_cut.front());
    const std::vector<Evaluation> by_cartesian = ask(open, *cartesian, in_open, "cartesian");
    const std::vector<Evaluation> by_tree = ask(open, *tree, in_open, "relative, hinge in the tree");
    const std::vector<Evaluation> by_cut = ask(cut, *in_loop, in_cut, "relative, hinge cut");
    compare(open, in_open, by_cartesian, by_tree, "relative, hinge in the tree");
    compare(open, in_open, by_cartesian, by_cut, "relative, hinge cut");
  }

  [[nodiscard]] Properties findings() const {
    Properties all{rank_, rate_, power_, wrenches_};
    all.insert(all.end(), audits_.begin(), audits_.end());
    return all;
  }

 private:
  State draw(const Model& model, relative::Equations& equations, relative::States& states, int pose) const {
    Numbers numbers(options_.seed, streams::kFirstState + static_cast<std::uint32_t>(pose));
    const double t = 0.4 + 0.3 * numbers();
    std::vector<VecX> q;
    std::vector<VecX> u;
    for (const Joint& one : model.joints) {
      q.push_back(one.type->name == "free" ? free_q(numbers) : numbers.vector(one.type->n_q(), 0.4));
      u.push_back(numbers.vector(one.type->n_u(), 1.6));
      for (const Driver& driver : one.drivers) {
        const TimeFunctionValue law = evaluate(driver.law, t);
        q.back()(first_q(*one.type, driver.word)) = law.f;
        u.back()(first_u(*one.type, driver.word)) = law.fdot;
      }
    }
    q[kPlanet](1) *= 20.0;  // turns
    obey(model, q, false);
    obey(model, u, true);
    const relative::Topology& topology = equations.topology();
    VecX all_q = VecX::Zero(topology.n_q);
    VecX all_u = VecX::Zero(topology.n_u);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      all_q.segment(topology.joints[k].first_q, q[k].size()) = q[k];
      all_u.segment(topology.joints[k].first_u, u[k].size()) = u[k];
    }
    for (const relative::Span& modes : topology.modes) {
      all_q.segment(modes.first_q, modes.n_q) = numbers.vector(modes.n_q, 0.1);
      all_u.segment(modes.first_u, modes.n_u) = numbers.vector(modes.n_u, 1.0);
    }
    return states.write(equations.move(t, all_q, all_u), {});
  }

  void require_rank(const Model& model, Solver& solver, const State& state) {
    int modes = 0;
    for (const Body& body : model.bodies) modes += body.n_modes();
    const int drivers = static_cast<int>(model.joints[kPlanet].drivers.size());
    const int freedom = 6 + 2 + 1 + 1 - 2 - drivers + modes;
    const RankReport report = solver.rank(state);
    const bool right = report.rank == report.constraints && report.degrees_of_freedom == freedom && !report.undecided;
    rank_.require(right, -1, [&] {
      return fmt::format("{}: {}: {} constraints of rank {}, {} degrees of freedom, expected {}", context_,
                         solver.name(), report.constraints, report.rank, report.degrees_of_freedom, freedom);
    });
  }

  std::vector<Evaluation> ask(const Model& model, Solver& solver, const std::vector<State>& states, const char* who) {
    std::vector<Evaluation> evaluations;
    Auditor auditor(model);
    for (std::size_t k = 0; k < states.size(); ++k) {
      evaluations.push_back(solver.evaluate(states[k]));
      auditor.add(states[k], evaluations.back());
      for (std::size_t c = 0; c < model.couplings.size(); ++c) {
        const CouplingWork work = work_of(model, model.couplings[c], evaluations.back().couplings[c], states[k]);
        const auto describe = [&] {
          return fmt::format("{}: {}: coupling '{}'", context_, who, model.couplings[c].name);
        };
        rate_.note(work.rate, options_.poses[k], describe);
        power_.note(work.power, options_.poses[k], describe);
      }
    }
    const AuditReport report = auditor.report();
    for (std::size_t rule = 0; rule < audits_.size(); ++rule) {
      const AuditFinding& finding = report.rules[rule];
      if (finding.row.empty()) continue;
      audits_[rule].note(std::pow(10.0, -finding.digits), -1,
                         [&] { return fmt::format("{}: {}: {}", context_, who, finding.text()); });
    }
    return evaluations;
  }

  void compare(const Model& model, const std::vector<State>& states, const std::vector<Evaluation>& one,
               const std::vector<Evaluation>& other, const char* who) {
    std::vector<SharedState> shared;
    for (std::size_t k = 0; k < states.size(); ++k) {
      shared.push_back({states[k], {one[k], other[k]}});
      shared.back().evaluations[1].joints.resize(model.joints.size());
    }
    const QuantityLayout layout(model);
    const std::vector<Measured> measured = measure(layout, align(layout, shared));
    for (std::size_t row = 0; row < measured.size(); ++row) {
      const Quantity& quantity = layout.quantities()[row];
      wrenches_.note(measured[row].difference / measured[row].scale, options_.poses[measured[row].worst], [&] {
        return fmt::format("{}: {}, {}: cartesian {:.9g}, {} {:.9g}", context_, describe_owner(model, quantity),
                           describe_component(quantity), measured[row].values[0], who, measured[row].values[1]);
      });
    }
  }

  const SheetOptions& options_;
  std::string context_;
  Property rank_{"rows are independent and take their degrees of freedom", {}};
  Property rate_{"the sum of factor times speed vanishes", kCouplingDigits};
  Property power_{"the forces of a coupling have no power together", kCouplingDigits};
  Property wrenches_{"same forces, wrenches on every body and accelerations by both solvers, tree and cut",
                     kCouplingDigits};
  Properties audits_;
};

}  // namespace

std::vector<std::string> subject_names() {
  std::vector<std::string> names;
  for (const JointType* type : joints::catalogue()) names.push_back(type->name);
  names.emplace_back(kCouplings);
  return names;
}

Sheet check_couplings(const SheetOptions& options) {
  Sheet sheet;
  sheet.joint = kCouplings;
  sheet.rows = 1;
  sheet.coordinates = {"turns and slides of several joints"};
  sheet.options = options;
  CouplingCheck check(sheet.options);
  for (const bool bends : {false, true}) {
    for (const Actor actor : {Actor::none, Actor::spring, Actor::driver}) check.look_at({bends, actor});
  }
  sheet.properties = check.findings();
  return sheet;
}

}  // namespace concord::compare::joint_check
