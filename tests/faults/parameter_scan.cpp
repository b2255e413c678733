#include "tests/faults/parameter_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cartesian/solver.h"
#include "common/error.h"
#include "compare/audit/digits.h"
#include "compare/resolution/weighed_states.h"
#include "compare/states/states.h"
#include "compare/verdict/refinement.h"
#include "relative/solver.h"

namespace concord::compare {

namespace {

constexpr double kUntil = 0.2;  // s, of a run that is longer
constexpr int kSamples = 20;
/// Sizes on the grid are 10^(-k / kPerDecade), from kLargest to kSmallest decades.
constexpr int kPerDecade = 4;
constexpr int kLargest = 2;
constexpr int kSmallest = 16;

std::array<std::unique_ptr<Solver>, 2> make_solvers(const Model& cartesian, const Model& relative) {
  return {cartesian::make_solver(cartesian), relative::make_solver(relative)};
}

/// A fault is a change of one parameter by a relative size.
void scale(double& value, double size) { value *= 1.0 + size; }

void collect_of_law(const std::string& name, const std::function<ForceLaw&(Model&)>& law_of, const ForceLaw& law,
                    std::vector<ParameterFault>& faults) {
  const auto add = [&](const char* what, double ForceLaw::*value) {
    if (law.*value == 0.0) return;
    faults.push_back({fmt::format("{} of {}", what, name),
                      [law_of, value](Model& model, double size) { scale(law_of(model).*value, size); }});
  };
  add("stiffness", &ForceLaw::stiffness);
  add("damping", &ForceLaw::damping);
  add("free length", &ForceLaw::free);
  add("preload", &ForceLaw::preload);
}

void collect_of_bodies(const Model& model, std::vector<ParameterFault>& faults) {
  const double length = model.length_scale();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const auto add = [&](const char* what, std::function<void(Body&, double)> change) {
      faults.push_back(
          {fmt::format("{} of {}", what, body.name),
           [i, change = std::move(change)](Model& changed, double size) { change(changed.bodies[i], size); }});
    };
    if (!body.modal) {
      add("mass", [](Body& b, double size) { scale(b.mass, size); });
      add("centre of mass",
          [length](Body& b, double size) { b.center_of_mass_L += size * length * Vec3(0.48, -0.6, 0.64); });
      add("inertia",
          [](Body& b, double size) { b.inertia_L += size * Vec3(1.0, 0.4, -0.3).asDiagonal() * b.inertia_L.trace(); });
      continue;
    }
    add("mass", [](Body& b, double size) { b.modal->G *= 1.0 + size; });
    if (body.n_modes() == 0) continue;
    add("modal mass", [](Body& b, double size) {
      b.modal->G.middleRows<3>(4) *= 1.0 + size;
      b.modal->G.middleCols<3>(4) *= 1.0 + size;
    });
    add("modal stiffness", [](Body& b, double size) { b.modal->stiffness *= 1.0 + size; });
    if (!body.modal->damping.isZero())
      add("modal damping", [](Body& b, double size) { b.modal->damping *= 1.0 + size; });
  }
}

void collect_of_elements(const Model& model, std::vector<ParameterFault>& faults) {
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    const ForceElement& element = model.elements[e];
    const auto add = [&](const char* what, std::function<void(ForceElement&, double)> change) {
      faults.push_back(
          {fmt::format("{} of {}", what, element.name),
           [e, change = std::move(change)](Model& changed, double size) { change(changed.elements[e], size); }});
    };
    if (std::holds_alternative<Load>(element.what)) {
      add("load", [](ForceElement& one, double size) {
        std::get<Load>(one.what).force *= 1.0 + size;
        std::get<Load>(one.what).torque *= 1.0 + size;
      });
    } else if (std::holds_alternative<LineSpring>(element.what)) {
      collect_of_law(
          element.name, [e](Model& m) -> ForceLaw& { return std::get<LineSpring>(m.elements[e].what).law; },
          std::get<LineSpring>(element.what).law, faults);
    } else if (std::holds_alternative<TurnSpring>(element.what)) {
      collect_of_law(
          element.name, [e](Model& m) -> ForceLaw& { return std::get<TurnSpring>(m.elements[e].what).law; },
          std::get<TurnSpring>(element.what).law, faults);
    } else if (std::holds_alternative<Bushing>(element.what)) {
      add("stiffness", [](ForceElement& one, double size) { std::get<Bushing>(one.what).stiffness *= 1.0 + size; });
      add("damping", [](ForceElement& one, double size) { std::get<Bushing>(one.what).damping *= 1.0 + size; });
    } else if (std::holds_alternative<Tire>(element.what)) {
      add("stiffness", [](ForceElement& one, double size) { scale(std::get<Tire>(one.what).stiffness, size); });
      add("radius", [](ForceElement& one, double size) { scale(std::get<Tire>(one.what).radius, size); });
      add("slip stiffness",
          [](ForceElement& one, double size) { scale(std::get<Tire>(one.what).slip_stiffness, size); });
    }
    if (!std::holds_alternative<Tire>(element.what)) {
      const double length = model.length_scale();
      add("place", [length](ForceElement& one, double size) {
        const auto move = [&](auto& what) {
          using What = std::decay_t<decltype(what)>;
          if constexpr (std::is_same_v<What, Load>)
            what.at.point_L += size * length * Vec3(0.48, -0.6, 0.64);
          else if constexpr (!std::is_same_v<What, Tire>)
            what.ends[1].point_L += size * length * Vec3(0.48, -0.6, 0.64);
        };
        std::visit(move, one.what);
      });
    }
  }
}

}  // namespace

std::vector<ParameterFault> parameter_faults(const Model& model) {
  std::vector<ParameterFault> faults;
  if (model.gravity.norm() > 0.0) faults.push_back({"gravity", [](Model& m, double size) { m.gravity *= 1.0 + size; }});
  collect_of_bodies(model, faults);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (std::size_t s = 0; s < model.joints[k].springs.size(); ++s) {
      collect_of_law(
          "joint " + model.joints[k].name, [k, s](Model& m) -> ForceLaw& { return m.joints[k].springs[s].law; },
          model.joints[k].springs[s].law, faults);
    }
  }
  collect_of_elements(model, faults);
  return faults;
}

ParameterScan::ParameterScan(const Model& model) : model_(model), solvers_(make_solvers(model, model)) {
  RunOptions run;
  run.until = std::min(model.run.until, kUntil);
  run.rtol = 1e-9;
  run.samples = kSamples;
  const Trajectory trajectory = solvers_[1]->integrate(run, {});
  std::vector<OwnedState> owned;
  for (const Sample& sample : trajectory.samples) owned.push_back({sample.state, Who::relative});
  const std::array<Solver*, 2> both{solvers_[0].get(), solvers_[1].get()};
  for (const SharedState& shared : share_random(model_, both, owned, kSeed).states) {
    if (states_.size() < kSamples) states_.push_back({shared.state, Who::relative});
  }
  states_.insert(states_.end(), owned.begin(), owned.end());
}

std::string ParameterScan::ratios() {
  const QuantityLayout layout(model_);
  const std::array<Solver*, 2> both{solvers_[0].get(), solvers_[1].get()};
  const WeighedStates weighed = weigh(layout, both, share(both, states_).states, kSeed);
  const MatX difference = (weighed.series.values[0] - weighed.series.values[1]).cwiseAbs();
  std::vector<double> ratios;
  for (Eigen::Index row = 0; row < difference.rows(); ++row) {
    for (Eigen::Index state = 0; state < difference.cols(); ++state) {
      const double resolution = weighed.resolution.both(row, state);
      if (weighed.mask(row, state) && resolution > 0.0) ratios.push_back(difference(row, state) / resolution);
    }
  }
  std::sort(ratios.begin(), ratios.end());
  Verdict verdict;
  make_rows(layout, verdict);
  const std::vector<Measured> measured = measure(layout, weighed.series, weighed.budget());
  record(layout, measured, Check::same_state, verdict);
  double resolvable = kMostDigits;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (row.quantity.kind != Kind::reaction && row.quantity.kind != Kind::element) continue;
      if (is_judged(row))
        resolvable = std::min(resolvable, detail_of(row, Check::same_state).resolvable.value_or(16.0));
    }
  }
  if (ratios.empty()) return model_.name + ": nothing to judge";
  return fmt::format("{}: {} component-states, ratio median {:.2g}, 99 % {:.2g}, largest {:.3g}; resolvable {:.1f}",
                     model_.name, ratios.size(), ratios[ratios.size() / 2], ratios[ratios.size() * 99 / 100],
                     ratios.back(), resolvable);
}

bool ParameterScan::is_seen(const ParameterFault& fault, Who faulty, double size) {
  Model changed = model_;
  fault.change(changed, size);
  const std::unique_ptr<Solver> other =
      faulty == Who::cartesian ? cartesian::make_solver(changed) : relative::make_solver(changed);
  std::array<Solver*, 2> both{solvers_[0].get(), solvers_[1].get()};
  both[index(faulty)] = other.get();
  try {
    return differs_at_same_state(model_, both, states_);
  } catch (const InputError&) {
    return true;
  } catch (const SolverError&) {
    return true;
  }
}

std::optional<double> ParameterScan::smallest_seen(const ParameterFault& fault, Who faulty) {
  const auto size_of = [](int k) { return std::pow(10.0, -static_cast<double>(k) / kPerDecade); };
  int seen = kLargest * kPerDecade;
  if (!is_seen(fault, faulty, size_of(seen))) return std::nullopt;
  int unseen = kSmallest * kPerDecade + 1;
  while (unseen - seen > 1) {
    const int middle = (seen + unseen) / 2;
    (is_seen(fault, faulty, size_of(middle)) ? seen : unseen) = middle;
  }
  return size_of(seen);
}

}  // namespace concord::compare
