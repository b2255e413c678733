#include "compare/analyses/stretched_beams.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "common/decompositions.h"
#include "compare/audit/geometric_stiffness.h"

namespace concord::compare::analyses {

namespace {

/// Axial modes hardly change the forces that stretch them: one step of Newton's method does nearly all.
constexpr int kSteps = 3;
/// Of their accelerations before: what is left of them changes the axial forces by so much.
constexpr double kAtRest = 1e-3;
/// Where loops hold modes, some of their changes are one: slopes are told apart by this part of the largest.
constexpr double kSameDirection = 1e-6;
/// Of the machine's length: beams that stretch by less carry nothing that bending feels.
constexpr double kLeastStretch = 1e-13;

/// The modal coordinates of a machine along which its beams stretch.
class AxialCoordinates {
 public:
  explicit AxialCoordinates(const Model& model) {
    for (std::size_t i = 1; i < model.bodies.size(); ++i) {
      if (!model.bodies[i].modal) continue;
      const ModalData& modal = *model.bodies[i].modal;
      for (const int mode : axial_modes(modal)) places_.push_back(place_of(i, modal, mode));
    }
  }

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(places_.size()); }

  [[nodiscard]] VecX accelerations(const Evaluation& evaluation) const {
    VecX all(size());
    for (Eigen::Index k = 0; k < size(); ++k) all(k) = evaluation.bodies[at(k).body].addot(at(k).mode);
    return all;
  }

  /// By how much a coordinate gives way under a modal force that accelerates it by one unit [s2].
  [[nodiscard]] double flexibility(Eigen::Index k) const { return at(k).flexibility; }

  /// How far such accelerations stretch beams once they are at rest, roughly [m].
  [[nodiscard]] double stretch(const VecX& rates) const {
    double largest = 0.0;
    for (Eigen::Index k = 0; k < size(); ++k) {
      largest = std::max(largest, std::abs(rates(k)) * at(k).flexibility * at(k).displacement);
    }
    return largest;
  }

  void move(Eigen::Index k, double by, State& state) const { state.bodies[at(k).body].a(at(k).mode) += by; }

 private:
  struct Place {
    std::size_t body;
    int mode;
    double flexibility;   // s2
    double displacement;  // of a mass point by a unit, at most
  };

  static Place place_of(std::size_t body, const ModalData& modal, int mode) {
    double mass = 0.0;
    double displacement = 0.0;
    for (const MassPoint& point : modal.mass_points) {
      const double moved = point.Psi_t_L.col(mode).norm();
      mass += point.mass * moved * moved;
      displacement = std::max(displacement, moved);
    }
    return {body, mode, mass / modal.stiffness(mode, mode), displacement};
  }

  [[nodiscard]] const Place& at(Eigen::Index k) const { return places_[static_cast<std::size_t>(k)]; }

  std::vector<Place> places_;
};

/// The closed state near a guess, evaluated; nothing where the solver finds none.
std::optional<Sample> closed_near(Solver& solver, const State& guess) {
  try {
    std::optional<State> state = solver.close(guess);
    if (!state) return std::nullopt;
    Evaluation evaluation = solver.evaluate(*state);
    return Sample{std::move(*state), std::move(evaluation)};
  } catch (const SolverError&) {
    return std::nullopt;
  }
}

/// One step of Newton's method to where the axial modes do not accelerate, derivatives by differences over steps of the
/// size of the answer.
std::optional<Sample> step_to_rest(const AxialCoordinates& axial, Solver& solver, const Sample& from) {
  const VecX rates = axial.accelerations(from.evaluation);
  const double largest = rates.lpNorm<Eigen::Infinity>();
  MatX slopes(axial.size(), axial.size());
  for (Eigen::Index k = 0; k < axial.size(); ++k) {
    const double step = largest * axial.flexibility(k);
    State beside = from.state;
    axial.move(k, step, beside);
    const std::optional<Sample> there = closed_near(solver, beside);
    if (!there) return std::nullopt;
    slopes.col(k) = (axial.accelerations(there->evaluation) - rates) / step;
  }
  const VecX step = smallest_least_squares(slopes, -rates, kSameDirection);
  State next = from.state;
  for (Eigen::Index k = 0; k < axial.size(); ++k) axial.move(k, step(k), next);
  return closed_near(solver, next);
}

}  // namespace

Sample with_beams_stretched(const Model& model, Solver& solver, const Sample& sample) {
  const AxialCoordinates axial(model);
  const VecX rates = axial.accelerations(sample.evaluation);
  if (!(axial.stretch(rates) > kLeastStretch * model.length_scale())) return sample;
  Sample stretched = sample;
  for (int step = 0; step < kSteps; ++step) {
    std::optional<Sample> next = step_to_rest(axial, solver, stretched);
    if (!next) return sample;
    stretched = std::move(*next);
    if (axial.accelerations(stretched.evaluation).norm() <= kAtRest * rates.norm()) return stretched;
  }
  return sample;
}

}  // namespace concord::compare::analyses
