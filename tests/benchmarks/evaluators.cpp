#include "tests/benchmarks/evaluators.h"

#include <algorithm>
#include <cmath>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/reactions.h"
#include "relative/dynamics/equations.h"
#include "relative/start/states.h"

namespace concord::benchmarks {

namespace {

class Cartesian : public Evaluator {
 public:
  explicit Cartesian(const Machine& machine)
      : model_(machine.model),
        equations_(machine.model),
        dynamics_(equations_),
        q_(VecX::Zero(equations_.layout().n_q())),
        Y_(VecX::Zero(equations_.layout().n_Y())),
        wrenches_(model_.joints.size()) {
    equations_.layout().unpack(machine.state, q_, Y_);
    dynamics_.solve_at(0.0, q_, Y_, cartesian::Pivots::fresh);
  }

  void evaluate() override {
    const cartesian::Solution& solution = dynamics_.solve_at(0.0, q_, Y_, cartesian::Pivots::kept);
    for (const cartesian::JointIndex k : cartesian::indices_of(model_.joints)) {
      const cartesian::JointEquations& joint = equations_.moving_constraints().joint(k);
      const auto lambda = solution.lambda().segment(joint.first_row.value, joint.n_rows);
      cartesian::write_wrenches(model_.joints[k.value], joint, lambda, nullptr, wrenches_[k.value]);
    }
  }
  [[nodiscard]] std::optional<Wrench> reaction(std::size_t k) const override {
    return wrenches_[k].reaction_on(Side::child).in_global;
  }

 private:
  const Model& model_;
  cartesian::Equations equations_;
  cartesian::Dynamics dynamics_;
  VecX q_;
  VecX Y_;
  std::vector<JointWrenches> wrenches_;
};

class Relative : public Evaluator {
 public:
  explicit Relative(const Machine& machine) : equations_(machine.model) {
    relative::StateMisfit misfit;
    coordinates_ = relative::States(equations_).read(machine.state, misfit);
  }

  void evaluate() override {
    const auto& evaluated = equations_.compute_accelerations(coordinates_.t, coordinates_.q, coordinates_.u);
    reactions_ = &equations_.compute_reactions(evaluated);
  }
  [[nodiscard]] std::optional<Wrench> reaction(std::size_t k) const override {
    return reactions_->joints[k].reaction_on(Side::child).in_global;
  }

 private:
  relative::Equations equations_;
  relative::Coordinates coordinates_;
  const relative::JointReactions* reactions_ = nullptr;
};

}  // namespace

std::unique_ptr<Evaluator> make_cartesian(const Machine& machine) { return std::make_unique<Cartesian>(machine); }
std::unique_ptr<Evaluator> make_relative(const Machine& machine) { return std::make_unique<Relative>(machine); }

double matching_digits(const Machine& machine, const Evaluator& one, const Evaluator& other) {
  double largest = 0.0;  // force; a torque counts as its force at the machine's length
  double apart = 0.0;
  const double length = machine.model.length_scale();
  const auto size_of = [length](const Vec3& force, const Vec3& torque) {
    return std::max(force.norm(), torque.norm() / length);
  };
  for (std::size_t k = 0; k < machine.model.joints.size(); ++k) {
    const std::optional<Wrench> a = one.reaction(k);
    const std::optional<Wrench> b = other.reaction(k);
    if (!a || !b) continue;
    largest = std::max(largest, size_of(a->force, a->torque));
    const double difference = size_of(a->force - b->force, a->torque - b->torque);
    if (!std::isfinite(difference)) return 0.0;
    apart = std::max(apart, difference);
  }
  return std::clamp(-std::log10(apart / largest), 0.0, 16.0);
}

}  // namespace concord::benchmarks
