#include "compare/attribution/correction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/decompositions.h"
#include "common/error.h"
#include "compare/attribution/reports.h"

namespace concord::compare {

namespace {

constexpr std::size_t kStates = 4;
/// Loads are sought in so many directions at most, each of which asks the solver anew.
constexpr int kDirections = 12;
constexpr double kClosedWell = 1e-13;

/// A load on a body at its origin, in its axes, that does not touch the modes.
ForceElement load_on(const Model& model, int body, const Vec3& force, const Vec3& torque) {
  const int m = model.bodies[body].n_modes();
  Load load;
  load.at.body = body;
  load.at.Psi_t_L = Mat3X::Zero(3, m);
  load.at.Psi_r_L = Mat3X::Zero(3, m);
  load.axes = LoadAxes::body;
  load.force = force;
  load.torque = torque;
  return {"correction", load, {}};
}

/// Adds generalized forces on the modes of a body and nothing else: forces that cancel, one of them at a place that
/// moves along it with the modes, and likewise torques, half of the whole by each.
void add_modal(Model& model, int body, const VecX& forces, double size) {
  if (forces.size() == 0 || forces.isZero(0.0)) return;
  const Vec3 along = Vec3::UnitX();
  for (const double sign : {1.0, -1.0}) {
    ForceElement by_force = load_on(model, body, sign * size * along, Vec3::Zero());
    ForceElement by_torque = load_on(model, body, Vec3::Zero(), sign * size * along);
    if (sign > 0.0) {
      const Mat3X shape = along * (0.5 / size * forces).transpose();
      std::get<Load>(by_force.what).at.Psi_t_L = shape;
      std::get<Load>(by_torque.what).at.Psi_r_L = shape;
    }
    model.elements.push_back(std::move(by_force));
    model.elements.push_back(std::move(by_torque));
  }
}

/// Largest difference of two answers: accelerations, and total wrenches of joints that are unique, each in parts of the
/// largest.
double apart(const Evidence& evidence, const Evaluation& one, const Evaluation& other) {
  const double length = evidence.model.length_scale();
  struct Kind {
    double difference = 0.0;
    double size = 0.0;
    void take(const VecX& a, const VecX& b) {
      difference = std::max(difference, (a - b).norm());
      size = std::max({size, a.norm(), b.norm()});
    }
    [[nodiscard]] double ratio() const { return size > 0.0 ? difference / size : 0.0; }
  };
  Kind rigid;
  Kind wrench;
  double largest = 0.0;
  for (std::size_t i = 1; i < one.bodies.size(); ++i) {
    const auto stacked = [&](const BodyAcceleration& rates) {
      return (Vec6() << rates.vdot, length * rates.omegadot).finished();
    };
    rigid.take(stacked(one.bodies[i]), stacked(other.bodies[i]));
    Kind modal;
    modal.take(one.bodies[i].addot, other.bodies[i].addot);
    largest = std::max(largest, modal.ratio());
  }
  for (std::size_t k = 0; k < one.joints.size(); ++k) {
    if (k < evidence.ambiguous.size() && evidence.ambiguous[k]) continue;
    const auto stacked = [&](const JointWrenches& joint) {
      Vec6 total = joint.total_on(Side::child).in_global.vector();
      total.head<3>() *= length;
      return total;
    };
    wrench.take(stacked(one.joints[k]), stacked(other.joints[k]));
  }
  return std::max({largest, rigid.ratio(), wrench.ratio()});
}

/// The blamed solver's answer in one state, with loads added.
class CorrectedSolver {
 public:
  CorrectedSolver(const Evidence& evidence, const SolverMaker& maker, const EvaluatedState& at, int solver)
      : evidence_(evidence), maker_(maker), at_(at), solver_(solver), auditor_(evidence.model) {}

  [[nodiscard]] const EvaluatedState& at() const { return at_; }
  [[nodiscard]] double apart_now() const { return apart(evidence_, *at_.by[solver_], *at_.by[1 - solver_]); }

  [[nodiscard]] double apart_with(const Model& model) const {
    return apart(evidence_, ask(model), *at_.by[1 - solver_]);
  }

  /// What the bodies leave over without the loads that were added, forces times the length beside torques.
  [[nodiscard]] VecX left_over(const std::vector<int>& bodies, const Evaluation& evaluation) const {
    std::vector<double> all;
    for (const int body : bodies) {
      VecX rows = auditor_.out_of_balance(body, *at_.state, evaluation).rows;
      rows.head<3>() *= evidence_.model.length_scale();
      all.insert(all.end(), rows.data(), rows.data() + rows.size());
    }
    return Eigen::Map<const VecX>(all.data(), static_cast<Eigen::Index>(all.size()));
  }
  [[nodiscard]] VecX left_over(const std::vector<int>& bodies) const { return left_over(bodies, *at_.by[solver_]); }
  [[nodiscard]] VecX left_over(const std::vector<int>& bodies, const Model& model) const {
    return left_over(bodies, ask(model));
  }

  /// The model with such loads.
  [[nodiscard]] Model loaded(const std::vector<int>& bodies, const VecX& loads) const {
    Model model = evidence_.model;
    const double length = evidence_.model.length_scale();
    Eigen::Index next = 0;
    for (const int body : bodies) {
      const Eigen::Index m = model.bodies[body].n_modes();
      const VecX own = loads.segment(next, 6 + m);
      model.elements.push_back(load_on(model, body, own.head<3>() / length, own.segment<3>(3)));
      // As large as what it acts beside, and so that the place of the load moves little.
      const double size =
          std::max(own.head(6).norm() / length, 100.0 * std::abs(own.tail(m).dot(at_.state->bodies[body].a)));
      add_modal(model, body, own.tail(m), std::max(size, own.tail(m).norm()));
      next += 6 + m;
    }
    return model;
  }

 private:
  [[nodiscard]] Evaluation ask(const Model& model) const {
    const std::unique_ptr<Solver> solver = maker_(model);
    (void)solver->assemble();
    return solver->evaluate(*at_.state);
  }

  const Evidence& evidence_;
  const SolverMaker& maker_;
  EvaluatedState at_;
  int solver_;
  Auditor auditor_;
};

/// Loads on the bodies with which nothing is left over. Answers are affine in them, so that few directions do, each the
/// remainder that those before leave.
VecX balancing_loads(const CorrectedSolver& solver, const std::vector<int>& bodies) {
  const VecX first = solver.left_over(bodies);
  const double size = first.norm();
  MatX directions(first.size(), 0);
  MatX responses(first.size(), 0);
  VecX shares;
  VecX rest = first;
  for (int k = 0; k < kDirections && k < first.size(); ++k) {
    VecX direction = rest - directions * (directions.transpose() * rest);
    direction -= directions * (directions.transpose() * direction);
    if (!(direction.norm() > 1e-14 * size)) break;
    direction.normalize();
    const VecX response = (solver.left_over(bodies, solver.loaded(bodies, size * direction)) - first) / size;
    directions.conservativeResize(Eigen::NoChange, k + 1);
    responses.conservativeResize(Eigen::NoChange, k + 1);
    directions.col(k) = direction;
    responses.col(k) = response;
    shares = least_squares(responses, -first);
    rest = first + responses * shares;
    if (!(rest.norm() > kClosedWell * size)) break;
  }
  return shares.size() > 0 ? VecX(directions * shares) : VecX::Zero(first.size());
}

/// States in which the solvers differ most, among those spread over all that there are.
std::vector<EvaluatedState> states_to_try(const Evidence& evidence) {
  std::vector<EvaluatedState> all = evidence.states;
  all.insert(all.end(), evidence.drawn.begin(), evidence.drawn.end());
  std::vector<EvaluatedState> chosen;
  const std::size_t stride = std::max<std::size_t>(1, all.size() / kStates);
  for (std::size_t k = 0; k < all.size() && chosen.size() < kStates; k += stride) {
    const auto end = all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), k + stride));
    chosen.push_back(*std::max_element(
        all.begin() + static_cast<std::ptrdiff_t>(k), end, [&](const EvaluatedState& a, const EvaluatedState& b) {
          return apart(evidence, *a.by[0], *a.by[1]) < apart(evidence, *b.by[0], *b.by[1]);
        }));
  }
  return chosen;
}

/// The smallest number of digits by which a way to correct closes the difference in some states.
template <class Correct>
std::optional<double> digits_closed(const Evidence& evidence, int solver, const SolverMaker& maker,
                                    const Correct& correct) {
  constexpr double kMost = 16.0;
  constexpr double kRoundOff = 1e-16;
  std::optional<double> digits;
  for (const EvaluatedState& one : states_to_try(evidence)) {
    try {
      const CorrectedSolver corrected(evidence, maker, one, solver);
      const double before = corrected.apart_now();
      if (!(before > 0.0)) continue;
      const double after = corrected.apart_with(correct(corrected));
      const double closed = std::log10(before / std::max(after, kRoundOff));
      digits = std::min(digits.value_or(kMost), std::isfinite(closed) ? closed : 0.0);
    } catch (const std::runtime_error&) {  // it does not accept its own model with loads
      continue;
    }
  }
  return digits;
}

/// "body hub and 2 others"
std::string count_of(const std::string& first, std::size_t n) {
  if (n == 1) return first;
  return fmt::format("{} and {} other{}", first, n - 1, n > 2 ? "s" : "");
}

/// The other solver's wrenches of some force elements in place of its own.
Model with_others_wrenches(const Evidence& evidence, const EvaluatedState& at, int solver,
                           const std::vector<int>& elements) {
  Model model = evidence.model;
  for (const int element : elements) {
    for (const Side side : kSides) {
      const Attachment* end = end_of(evidence.model.elements[element], side);
      if (end == nullptr) continue;
      const Wrench& own = at.by[solver]->elements[element].on_side(side).in_global;
      const Wrench& other = at.by[1 - solver]->elements[element].on_side(side).in_global;
      Load load;
      load.at = *end;
      load.force = other.force - own.force;
      load.torque = other.torque - own.torque;
      model.elements.push_back({"correction", load, {}});
    }
  }
  return model;
}

/// First the place that is named, then all of its kind: what is wrong may be wrong in all of them.
template <class Attempt>
std::optional<Trial> try_places(std::vector<int> all, std::optional<int> named, const std::string& first,
                                const Attempt& attempt) {
  std::optional<Trial> best;
  const auto take = [&](const std::vector<int>& places) {
    const std::optional<double> digits = attempt(places);
    if (digits && (!best || *digits > best->digits)) best = Trial{*digits, count_of(first, places.size())};
  };
  if (named) {
    take({*named});
    if (best && best->confirms()) return best;
  }
  if (!all.empty() && (all.size() > 1 || !named)) take(all);
  return best;
}

}  // namespace

std::optional<Trial> try_correction(const Evidence& evidence, const Attribution& blame, const SolverMaker& maker) {
  if (blame.solver > 1 || !maker) return std::nullopt;
  switch (blame.term) {
    case Term::inertia:
    case Term::gyroscopic:
    case Term::modal_coupling:
    case Term::elastic:
    case Term::damping:
    case Term::applied:
    case Term::reaction:
      break;
    default:
      return std::nullopt;
  }
  const Model& model = evidence.model;
  const int solver = blame.solver;
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    if (blame.where != "force element " + model.elements[k].name) continue;
    return try_places(elements_against_law(evidence, solver), static_cast<int>(k), blame.where,
                      [&](const std::vector<int>& elements) {
                        return digits_closed(evidence, solver, maker, [&](const CorrectedSolver& corrected) {
                          return with_others_wrenches(evidence, corrected.at(), solver, elements);
                        });
                      });
  }
  const std::vector<int> bodies = bodies_out_of_balance(evidence, solver);
  if (bodies.empty()) return std::nullopt;
  const auto named = std::find_if(bodies.begin(), bodies.end(),
                                  [&](int body) { return blame.where == "body " + model.bodies[body].name; });
  const std::string first = "body " + model.bodies[named != bodies.end() ? *named : bodies.front()].name;
  return try_places(bodies, named != bodies.end() ? std::optional(*named) : std::nullopt, first,
                    [&](const std::vector<int>& some) {
                      return digits_closed(evidence, solver, maker, [&](const CorrectedSolver& corrected) {
                        return corrected.loaded(some, balancing_loads(corrected, some));
                      });
                    });
}

std::optional<Attribution> find_confirmed_cause(const Evidence& evidence, const std::array<SolverMaker, 2>& makers) {
  if (evidence.states.empty() || move_alike(evidence.states)) return find_cause(evidence);
  std::optional<Attribution> untried;
  std::optional<Attribution> refuted;
  for (Attribution& cause : find_causes(evidence)) {
    const auto trial = cause.solver < 2 ? try_correction(evidence, cause, makers[cause.solver]) : std::nullopt;
    if (!trial) {
      if (!untried) untried = std::move(cause);
      continue;
    }
    cause.closed_digits = trial->digits;
    cause.because += describe(*trial);
    if (trial->confirms()) return cause;
    if (!refuted) refuted = std::move(cause);
  }
  return untried ? untried : refuted;
}

std::string describe(const Trial& trial) {
  if (trial.confirms()) {
    return fmt::format("; confirmed: put right by loads on {}, the difference closes by {:.1f} digits", trial.where,
                       trial.digits);
  }
  return fmt::format("; not confirmed: put right by loads on {}, the difference closes by {:.1f} digits", trial.where,
                     std::max(0.0, trial.digits));
}

}  // namespace concord::compare
