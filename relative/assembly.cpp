#include "relative/assembly.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/decompositions.h"

namespace concord::relative {

namespace {

constexpr int kMostIterations = 60;
constexpr double kRankThreshold = 1e-10;  // of the largest singular value, or of 1, the size of a row, if all vanish
constexpr double kClosed = 1e-13;         // of the largest coordinate or speed, at least of 1
constexpr double kNearlyClosed = 1e-7;    // a position residual that does not change Phi_u enough to matter for speeds
constexpr double kNoRoundOff = 1e-9;      // of the largest speed: a velocity residual that no dependent row explains
constexpr double kRoundOffOfSpeed = 1e-15;     // of the largest speed
constexpr double kRoundOffOfPosition = 1e-15;  // of the largest coordinate, at least of 1: nothing to take away
/// A modal coordinate moves in a projection as if its column were this part of itself.
constexpr double kModesMove = 1e-3;
constexpr double kLargestStep = 0.5;  // in machine units: half a radian, half the length

double largest(const VecX& values) { return values.size() == 0 ? 0.0 : values.cwiseAbs().maxCoeff(); }

Eigen::Index rank_of(const MatX& scaled) {
  if (scaled.size() == 0) return 0;
  const VecX sigma = singular_values(scaled);
  return (sigma.array() > kRankThreshold * std::max(sigma(0), 1.0)).count();
}

MatX select_columns(const MatX& matrix, const std::vector<int>& columns) {
  MatX selected(matrix.rows(), columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c) selected.col(c) = matrix.col(columns[c]);
  return selected;
}

const char* name_of(Assembly::Rows rows) { return rows == Assembly::Rows::of_positions ? "coordinates" : "speeds"; }

std::string degrees(int n) { return fmt::format("{} degree{} of freedom", n, n == 1 ? "" : "s"); }

/// By how much coordinates of the tree are moved in search of a general pose: their units, modes a twentieth of it.
VecX exploring_steps(const Scales& scales, const Topology& topology) {
  VecX steps = scales.speeds();
  for (const Span& modes : topology.modes) steps.segment(modes.first_u, modes.n_u) *= 0.05;
  return steps;
}

}  // namespace

Assembly::Assembly(Equations& equations)
    : equations_(&equations),
      scales_(equations.model(), equations.topology()),
      all_columns_(moving_columns(equations.driven(), Modes::moving)),
      rate_(machine_rate(equations.model())),
      coordinate_units_(scales_.coordinates(equations.model(), equations.topology())) {
  weights_of_joints_ = weights_of_all_ = VecX::Ones(static_cast<Eigen::Index>(all_columns_.size()));
  const std::vector<int> joint_columns = moving_columns(equations.driven(), Modes::kept);
  for (std::size_t c = 0; c < all_columns_.size(); ++c) {
    if (std::binary_search(joint_columns.begin(), joint_columns.end(), all_columns_[c])) continue;
    weights_of_joints_(static_cast<Eigen::Index>(c)) = kModesMove;
  }
}

std::vector<int> Assembly::moving_columns(const PrescribedMask& prescribed, Modes modes) const {
  std::vector<char> moves(equations_->topology().n_tree_u, 1);
  for (std::size_t c = 0; c < moves.size(); ++c) moves[c] = prescribed[c] == 0 ? 1 : 0;
  if (modes == Modes::kept) {
    for (const Span& span : equations_->topology().modes) {
      std::fill_n(moves.begin() + span.first_u, span.n_u, static_cast<char>(0));
    }
  }
  std::vector<int> columns;
  for (std::size_t c = 0; c < moves.size(); ++c) {
    if (moves[c] != 0) columns.push_back(static_cast<int>(c));
  }
  return columns;
}

/// Moves the tree's coordinates by a finite step along the speeds (n_tree_u numbers).
void Assembly::advance(VecX& q, const VecX& step) const {
  const Topology& topology = equations_->topology();
  for (const Link& link : topology.links) {
    const Span& joint = topology.joints[link.joint];
    equations_->kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data() + joint.first_u);
    const Span& modes = topology.modes[link.body];
    q.segment(modes.first_q, modes.n_q) += step.segment(modes.first_u, modes.n_u);
  }
}

/// Moves the machine and measures its cut joints with a closure of its own; returns the largest position residual in
/// machine units.
double Assembly::measure(Coordinates& coordinates, Closure& closure) {
  equations_->move(coordinates.t, coordinates.q, coordinates.u);
  closure.measure(coordinates.q, coordinates.u);
  return largest(closure.position_residual().cwiseQuotient(closure.row_units().head(closure.n_position_rows())));
}

/// The same; infinite where the machine has no such pose.
double Assembly::try_to_measure(Coordinates& coordinates, Closure& closure) {
  try {
    return measure(coordinates, closure);
  } catch (const SolverError&) {
    return HUGE_VAL;
  }
}

/// The smallest step (n_tree_u numbers, in machine units) of the given columns that takes the misfit, of as many rows
/// as it has, away to first order; directions in which the rows are dependent are left alone, those with singular
/// values below the damping hardly used (R65).
VecX Assembly::smallest_step(const Closure& closure, const std::vector<int>& columns, const VecX& misfit,
                             double damping) const {
  const MatX Phi = select_columns(scales_.scaled(closure.Phi_u(), closure).topRows(misfit.size()), columns);
  VecX step = VecX::Zero(equations_->topology().n_tree_u);
  if (Phi.size() == 0) return step;
  const Eigen::JacobiSVD<MatX> svd(Phi, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VecX scaled = misfit.cwiseQuotient(closure.row_units().head(misfit.size()));
  const VecX& sigma = svd.singularValues();
  VecX filter = VecX::Zero(sigma.size());
  for (Eigen::Index i = 0; i < sigma.size(); ++i) {
    if (sigma(i) > kRankThreshold * std::max(sigma(0), 1.0))
      filter(i) = sigma(i) / (sigma(i) * sigma(i) + damping * damping);
  }
  const VecX solution = -(svd.matrixV() * filter.asDiagonal() * svd.matrixU().transpose() * scaled);
  for (std::size_t c = 0; c < columns.size(); ++c) step(columns[c]) = solution(c);
  return step;
}

/// Newton's method with damping and halved steps, until round-off stops it.
bool Assembly::close_positions(Coordinates& coordinates, const PrescribedMask& prescribed, Modes modes) {
  Closure closure(equations_->kinematics(), prescribed);
  if (closure.n_position_rows() == 0) return true;
  const std::vector<int> columns = moving_columns(prescribed, modes);
  double residual = measure(coordinates, closure);
  for (int iteration = 0; iteration < kMostIterations && residual > 0.0; ++iteration) {
    VecX step = smallest_step(closure, columns, closure.position_residual(), std::min(1e-3, residual));
    step *= std::min(1.0, kLargestStep / std::max(largest(step), 1e-300));
    step = step.cwiseProduct(scales_.speeds().head(step.size()));
    bool improved = false;
    for (int halvings = 0; halvings < 12 && !improved; ++halvings) {
      Coordinates trial = coordinates;
      advance(trial.q, step);
      const double trial_residual = try_to_measure(trial, closure);
      improved = trial_residual < residual;
      step *= 0.5;
      if (!improved) continue;
      coordinates = std::move(trial);
      residual = trial_residual;
    }
    if (!improved) break;
  }
  measure(coordinates, closure);
  // Round-off adds up along a loop, which has at most all links.
  const double longest = 0.01 * static_cast<double>(equations_->topology().links.size());
  return residual < kClosed * std::max({1.0, size_of_q(coordinates.q), longest});
}

bool Assembly::close_velocities(Coordinates& coordinates, const PrescribedMask& prescribed, Modes modes) {
  Closure closure(equations_->kinematics(), prescribed);
  if (closure.n_rows() == 0) return true;
  const std::vector<int> columns = moving_columns(prescribed, modes);
  const double size = std::max(rate_, size_of_u(coordinates.u));
  double residual = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    measure(coordinates, closure);
    residual = largest(closure.velocity_residual().cwiseQuotient(closure.row_units()));
    const VecX step = smallest_step(closure, columns, closure.velocity_residual(), 0.0);
    coordinates.u.head(step.size()) += step.cwiseProduct(scales_.speeds().head(step.size()));
  }
  measure(coordinates, closure);
  residual = std::min(residual, largest(closure.velocity_residual().cwiseQuotient(closure.row_units())));
  return residual <= kClosed * std::max(size, size_of_u(coordinates.u));
}

/// Joints alone close a machine as far as its loops leave the modes free; others must move too. In a pose
/// that is not closed, dependent rows look independent, so that the ranks must be taken in a closed one.
void Assembly::decide_modes(const Coordinates& closed) {
  const auto rank = [&](Modes modes) { return closure_rank(closed, Rows::of_velocities, modes); };
  const bool restricted = equations_->model().is_flexible() && rank(Modes::moving) > rank(Modes::kept);
  closing_modes_ = restricted ? Modes::moving : Modes::kept;
}

bool Assembly::close(Coordinates& coordinates) {
  if (equations_->model().is_flexible()) decide_rank(coordinates);
  equations_->prescribe(coordinates.t, coordinates.q, coordinates.u);
  const PrescribedMask& driven = equations_->driven();
  return close_positions(coordinates, driven, closing_modes_) && close_velocities(coordinates, driven, closing_modes_);
}

/// Factors the closure rows here, in the units of the machine: those for positions by themselves, and all.
void Assembly::take_projection() {
  const Closure& closure = equations_->closure();
  const MatX Phi =
      select_columns(scales_.scaled(closure.Phi_u(), closure), all_columns_) * projection_weights().asDiagonal();
  const bool positions_are_all = closure.n_position_rows() == closure.n_rows();
  row_factors_.compute(Phi);
  if (!positions_are_all) position_factors_.compute(Phi.topRows(closure.n_position_rows()));
}

/// The smallest step of the free columns in the units of the machine that takes away the misfit of the independent rows
/// of this pose among those that it has; the others follow.
VecX Assembly::projection_step(const VecX& misfit) const {
  const Closure& closure = equations_->closure();
  const VecX scaled = misfit.cwiseQuotient(closure.row_units().head(misfit.size()));
  const VecX solution = (misfit.size() < closure.n_rows() ? position_factors_ : row_factors_).smallest_step(scaled);
  VecX step = VecX::Zero(equations_->topology().n_tree_u);
  const VecX& weights = projection_weights();
  for (std::size_t c = 0; c < all_columns_.size(); ++c) {
    const int column = all_columns_[c];
    step(column) =
        solution(static_cast<Eigen::Index>(c)) * weights(static_cast<Eigen::Index>(c)) * scales_.speeds()(column);
  }
  return step;
}

/// Moves the machine and completes the coordinates by what follows there.
void Assembly::move(Coordinates& coordinates) {
  equations_->move(coordinates.t, coordinates.q, coordinates.u);
  coordinates.q = equations_->q();
  coordinates.u = equations_->u();
}

double Assembly::position_residual_in_units() const {
  const Closure& closure = equations_->closure();
  return largest(closure.position_residual().cwiseQuotient(closure.row_units().head(closure.n_position_rows())));
}

double Assembly::velocity_residual_in_units() const {
  return largest(equations_->closure().velocity_residual().cwiseQuotient(equations_->closure().row_units()));
}

/// Largest coordinate and speed in the units of the machine.
double Assembly::size_of_q(const VecX& q) const { return largest(q.cwiseQuotient(coordinate_units_)); }
double Assembly::size_of_u(const VecX& u) const { return largest(u.cwiseQuotient(scales_.speeds())); }

/// Newton's method to round-off; Phi_u is kept while each step takes away nine tenths of the residual.
void Assembly::project_positions(Coordinates& coordinates) {
  const Closure& closure = equations_->closure();
  const double allowed = kClosed * std::max(1.0, size_of_q(coordinates.q));
  double residual = position_residual_in_units();
  if (residual <= kRoundOffOfPosition * std::max(1.0, size_of_q(coordinates.q))) return;
  bool is_fresh = true;
  for (int iteration = 0; iteration < 8; ++iteration) {
    advance(coordinates.q, projection_step(closure.position_residual()));
    move(coordinates);
    if (!closure.position_residual().allFinite()) break;
    const double reached = position_residual_in_units();
    const bool stands = reached >= 0.5 * residual;
    const bool is_slow = reached >= 0.1 * residual;
    residual = std::min(residual, reached);
    if (reached < 0.1 * allowed || (stands && is_fresh && reached < allowed)) break;
    if (stands && iteration > 3) break;
    is_fresh = is_slow;
    if (is_slow) take_projection();
  }
  residual = position_residual_in_units();
  if (closure.position_residual().allFinite() && residual <= allowed) return;
  throw SolverError(fmt::format(
      "{} will not close: position residual {:.1e} in parts of the machine's length and rad, allowed {:.0e}; it was "
      "closed at the start: tighten the tolerance",
      closure.worst_place(
          closure.position_residual().cwiseQuotient(closure.row_units().head(closure.position_residual().size()))),
      residual, allowed));
}

/// Until round-off stands; Phi_u is taken anew where a step takes away less than nine tenths of the residual.
void Assembly::project_velocities(Coordinates& coordinates) {
  const Closure& closure = equations_->closure();
  double residual = velocity_residual_in_units();
  if (residual <= kRoundOffOfSpeed * size_of_u(coordinates.u)) return;
  bool is_fresh = false;
  for (int iteration = 0; iteration < 4 && residual > 0.0; ++iteration) {
    coordinates.u.head(equations_->topology().n_tree_u) += projection_step(closure.velocity_residual());
    move(coordinates);
    const double reached = velocity_residual_in_units();
    const bool is_slow = reached >= 0.1 * residual;
    residual = std::min(residual, reached);
    if (reached <= kRoundOffOfSpeed * size_of_u(coordinates.u) || (is_slow && is_fresh)) break;
    if (is_slow) take_projection();
    is_fresh = is_slow;
  }
  residual = velocity_residual_in_units();
  const double allowed = kNoRoundOff * std::max(rate_, size_of_u(coordinates.u));
  if (closure.velocity_residual().allFinite() && residual <= allowed) return;
  throw SolverError(fmt::format(
      "{} does not obey the velocity constraints: residual {:.1e} in parts of the machine's length and rad per s, "
      "allowed "
      "{:.0e}; it obeyed them at the start: tighten the tolerance",
      closure.worst_place(closure.velocity_residual().cwiseQuotient(closure.row_units())), residual, allowed));
}

void Assembly::normalize(VecX& q) const {
  const Topology& topology = equations_->topology();
  for (std::size_t k = 0; k < topology.joints.size(); ++k) {
    equations_->kinematics().mobilizer(static_cast<int>(k)).normalize(q.data() + topology.joints[k].first_q);
  }
}

/// Round-off of a loop, put into a stiff mode, would be a force, so that modes take next to no part where joints alone
/// can close; near a pose in which these cannot, modes move (R66).
void Assembly::project(Coordinates& coordinates) {
  normalize(coordinates.q);
  projecting_ = closing_modes_;
  move(coordinates);
  const Closure& closure = equations_->closure();
  if (closure.n_rows() == 0) return;
  const bool was_near = position_residual_in_units() < kNearlyClosed;
  take_projection();
  project_positions(coordinates);
  if (!was_near) take_projection();
  project_velocities(coordinates);
}

double Assembly::misfit(const Coordinates& coordinates) {
  equations_->move(coordinates.t, coordinates.q, coordinates.u);
  const double residual = velocity_residual_in_units();
  return std::max(position_residual_in_units() / std::max(1.0, size_of_q(coordinates.q)),
                  residual > 0.0 ? residual / std::max(rate_, size_of_u(coordinates.u)) : 0.0);
}

int Assembly::closure_rank(const Coordinates& coordinates, Rows rows, Modes modes) {
  equations_->move(coordinates.t, coordinates.q, coordinates.u);
  const Closure& closure = equations_->closure();
  const MatX Phi =
      select_columns(scales_.scaled(closure.Phi_u(), closure), moving_columns(equations_->driven(), modes));
  return static_cast<int>(
      rank_of(Phi.topRows(rows == Rows::of_positions ? closure.n_position_rows() : closure.n_rows())));
}

/// The rank may be lower at the start, in a folded pose or with undeformed bodies than it is in general: poses
/// nearby, reached with the drivers released, decide.
void Assembly::decide_rank_near(const Coordinates& coordinates) {
  const int n_rows = equations_->closure().n_rows();
  Coordinates best = coordinates;
  int rank = closure_rank(coordinates, Rows::of_velocities, Modes::moving);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> spread(-0.2, 0.2);
  const PrescribedMask nothing(equations_->topology().n_u, 0);
  Closure free(equations_->kinematics(), nothing);
  const std::vector<int> columns = moving_columns(nothing, Modes::moving);
  const VecX steps = exploring_steps(scales_, equations_->topology());
  decide_modes(coordinates);
  for (int trial = 0; trial < 4 && rank < n_rows; ++trial) {
    Coordinates nearby = coordinates;
    VecX step = VecX::Zero(equations_->topology().n_tree_u);
    for (const int c : columns) step(c) = spread(random) * steps(c);
    advance(nearby.q, step);
    if (try_to_measure(nearby, free) == HUGE_VAL || !close_positions(nearby, nothing, Modes::moving)) continue;
    const int found = closure_rank(nearby, Rows::of_velocities, Modes::moving);
    if (found <= rank) continue;
    rank = found;
    best = std::move(nearby);
    decide_modes(best);
  }
  rank_is_decided_ = true;
  equations_->loops().set_rank(rank);
}

/// From the start, so that it does not depend on the states that came before; if the machine has none, from here.
void Assembly::decide_rank(const Coordinates& coordinates) {
  if (rank_is_decided_ || equations_->closure().n_rows() == 0) return;
  const VecX turns = equations_->kinematics().turns();
  try {
    (void)start();
  } catch (const std::runtime_error&) {  // a start that contradicts itself, or that cannot be evaluated
  }
  equations_->count_turns(turns);
  if (!rank_is_decided_) decide_rank_near(coordinates);
}

void Assembly::require_general_rank(const Coordinates& coordinates) {
  // Pivots in the metric of the inverse inertia are squares of sines between rows: above this no row depends.
  constexpr double kSurelyIndependent = 1e-10;
  if (equations_->closure().n_rows() == 0 || equations_->loops().least_pivot() > kSurelyIndependent) return;
  if (closure_rank(coordinates, Rows::of_velocities, Modes::moving) < rank()) throw_singular(coordinates, "");
}

void Assembly::require_agreeing_rows(const Coordinates& coordinates) const {
  constexpr double kContradiction = 1e-7;  // of the machine's accelerations
  const Loops& loops = equations_->loops();
  if (loops.rank() == equations_->closure().n_rows()) return;
  const auto speeds = coordinates.u.cwiseQuotient(scales_.speeds()).cwiseAbs();
  const auto rates = equations_->udot().cwiseQuotient(scales_.speeds()).cwiseAbs();
  double largest = rate_ * rate_;
  if (speeds.size() > 0) largest = std::max({largest, speeds.maxCoeff() * speeds.maxCoeff(), rates.maxCoeff()});
  const int row = loops.contradicted_row(kContradiction * largest);
  if (row < 0) return;
  const Closure& closure = equations_->closure();
  throw SingularPose(fmt::format(
      "relative: at t = {:.6g} s no accelerations close everything: rows at {} depend on others in this pose "
      "and contradict them: the pose is singular, or a driver moves what the loops hold",
      coordinates.t, closure.worst_place(VecX::Unit(closure.n_rows(), row))));
}

void Assembly::throw_singular(const Coordinates& coordinates, const std::string& passing) {
  equations_->move(coordinates.t, coordinates.q, coordinates.u);
  const Closure& closure = equations_->closure();
  RowFactors factors;
  factors.compute(select_columns(scales_.scaled(closure.Phi_u(), closure), all_columns_));
  throw SingularPose(fmt::format(
      "relative: at t = {:.6g} s the {} closure rows{} {}lose rank: {} of {} at {}: the pose is singular and the "
      "motion "
      "may branch",
      coordinates.t, closure.n_rows(),
      closure.speed_constraints().empty() ? "" : " of loops, couplings and rolling contacts", passing,
      std::min(factors.rank(), rank() - 1), rank(), closure.worst_place(factors.weakest_combination(rank()))));
}

double Assembly::factor_rows(Coordinates& coordinates, MatX& Phi) {
  move(coordinates);
  const Closure& closure = equations_->closure();
  Phi = select_columns(scales_.scaled(closure.Phi_u(), closure), all_columns_);
  RowFactors factors;
  factors.compute(Phi);
  return factors.singular_value(rank());
}

bool Assembly::close_positions_nearby(Coordinates& coordinates) {
  try {
    normalize(coordinates.q);
    projecting_ = closing_modes_;
    move(coordinates);
    take_projection();
    project_positions(coordinates);
    return true;
  } catch (const SolverError&) {
    return false;
  }
}

// The start ----------------------------------------------------------------------------------------------------------

/// The driven speeds and those of every word with role `keep`.
PrescribedMask Assembly::kept(StartRole WordStart::*role) const {
  PrescribedMask prescribed = equations_->driven();
  const Model& model = equations_->model();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      if (joint.start[word].*role != StartRole::keep) continue;
      const int first = equations_->topology().joints[k].first_u + first_u(*joint.type, static_cast<int>(word));
      std::fill_n(prescribed.begin() + first, n_u(joint.type->permits[word]), static_cast<char>(1));
    }
  }
  return prescribed;
}

/// Coordinates of the joints between the guessed poses of the bodies.
void Assembly::measure_unsaid(Coordinates& coordinates) const {
  const Model& model = equations_->model();
  const std::vector<Pose> poses = guess_poses(model);
  std::vector<BodyState> bodies(model.bodies.size());
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const Span& modes = equations_->topology().modes[i];
    const Eigen::Quaterniond p(poses[i].A);
    bodies[i].r = poses[i].r;
    bodies[i].p << p.w(), p.x(), p.y(), p.z();
    bodies[i].a = coordinates.q.segment(modes.first_q, modes.n_q);
    bodies[i].adot = coordinates.u.segment(modes.first_u, modes.n_u);
  }
  Kinematics kinematics(model);
  kinematics.place(bodies);
  const PrescribedMask nothing(equations_->topology().n_u, 0);
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    JointMeasure measured(kinematics.mobilizer(k), nothing.data());
    measured.find_q(kinematics.point(k, Side::parent), kinematics.point(k, Side::child),
                    coordinates.q.data() + equations_->topology().joints[k].first_q, JointMeasure::Restart::if_better);
  }
}

/// What the model says of the start; where it says nothing, what the guessed poses give.
Coordinates Assembly::guess_start() const {
  const Model& model = equations_->model();
  const Topology& topology = equations_->topology();
  Coordinates start{0.0, equations_->home(), VecX::Zero(topology.n_u)};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const Span& modes = topology.modes[i];
    if (body.a_start.size() > 0) start.q.segment(modes.first_q, modes.n_q) = body.a_start;
    if (body.adot_start.size() > 0) start.u.segment(modes.first_u, modes.n_u) = body.adot_start;
  }
  const auto say = [&](bool unsaid_too) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Joint& joint = model.joints[k];
      for (std::size_t word = 0; word < joint.start.size(); ++word) {
        const WordStart& said = joint.start[word];
        const int iq = topology.joints[k].first_q + first_q(*joint.type, static_cast<int>(word));
        const int iu = topology.joints[k].first_u + first_u(*joint.type, static_cast<int>(word));
        if (said.q.size() > 0 && (unsaid_too || said.role_q != StartRole::unsaid)) {
          start.q.segment(iq, said.q.size()) = said.q;
        }
        if (said.u.size() > 0 && said.role_u != StartRole::unsaid) start.u.segment(iu, said.u.size()) = said.u;
      }
    }
  };
  say(true);
  measure_unsaid(start);
  say(false);
  equations_->prescribe(0.0, start.q, start.u);
  return start;
}

std::string Assembly::names_of_kept(const PrescribedMask& prescribed) const {
  const Model& model = equations_->model();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Span& span = equations_->topology().joints[k];
    int count = 0;
    for (int c = span.first_u; c < span.first_u + span.n_u; ++c) {
      if (prescribed[c] != 0 && equations_->driven()[c] == 0) ++count;
    }
    if (count > 0) names.push_back(fmt::format("{} of joint '{}'", count, model.joints[k].name));
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

SourceLocation Assembly::where_kept(const PrescribedMask& prescribed) const {
  const Model& model = equations_->model();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Span& span = equations_->topology().joints[k];
    for (int c = span.first_u; c < span.first_u + span.n_u; ++c) {
      if (prescribed[c] != 0 && equations_->driven()[c] == 0) return model.joints[k].where;
    }
  }
  return {model.file, 0, 0};
}

/// The couplings that relate nothing but kept and driven values, for the end of a message about the former.
std::string Assembly::couplings_of_kept(const PrescribedMask& prescribed) const {
  const Model& model = equations_->model();
  std::string text;
  for (const Coupling& coupling : model.couplings) {
    std::vector<std::string> names;
    for (const CouplingTerm& term : coupling.terms) {
      const Joint& joint = model.joints[term.joint];
      const int place = first_u(*joint.type, term.word) + term.component;
      if (prescribed[equations_->topology().joints[term.joint].first_u + place] == 0) break;
      names.push_back(fmt::format("'{}'", joint.name));
    }
    if (names.size() < coupling.terms.size()) continue;
    text += fmt::format("; coupling '{}' relates those of joints {}", coupling.name, fmt::join(names, ", "));
  }
  return text;
}

/// As many kept values as degrees of freedom, modes and drivers not counted. `coordinates` are closed.
void Assembly::require_number_of_kept(const Coordinates& coordinates, const PrescribedMask& prescribed, Rows rows) {
  const auto n_free = static_cast<int>(moving_columns(equations_->driven(), Modes::kept).size());
  const int freedom = n_free - closure_rank(coordinates, rows, Modes::kept);
  int n_kept = 0;
  for (std::size_t c = 0; c < prescribed.size(); ++c)
    n_kept += prescribed[c] != 0 && equations_->driven()[c] == 0 ? 1 : 0;
  if (n_kept == freedom) return;
  throw InputError(
      where_kept(prescribed),
      fmt::format("start: the machine has {} beside its drivers and modes, so {} joint {} must be kept, but "
                  "{} are ({}){}",
                  degrees(freedom), freedom, name_of(rows), n_kept, names_of_kept(prescribed),
                  couplings_of_kept(prescribed)));
}

void Assembly::require_independent_start(const Coordinates& coordinates, const PrescribedMask& prescribed, Rows rows) {
  Closure closure(equations_->kinematics(), prescribed);
  Coordinates copy = coordinates;
  measure(copy, closure);
  const std::vector<int> columns = moving_columns(prescribed, Modes::kept);
  const int n_rows = rows == Rows::of_positions ? closure.n_position_rows() : closure.n_rows();
  const MatX Phi = select_columns(scales_.scaled(closure.Phi_u(), closure).topRows(n_rows), columns);
  if (rank_of(Phi) == static_cast<Eigen::Index>(columns.size())) return;
  throw InputError(where_kept(prescribed),
                   fmt::format("start: the kept joint {} ({}) depend on each other and leave the rest "
                               "of the machine free: keep others{}",
                               name_of(rows), names_of_kept(prescribed), couplings_of_kept(prescribed)));
}

void Assembly::require_inertia(const Coordinates& coordinates) {
  const auto slack = equations_->find_motion_without_inertia(coordinates.t, coordinates.q, coordinates.u);
  if (!slack) return;
  const Link& link = equations_->topology().links[slack->link];
  const Vec6 twist = equations_->kinematics().joint_motion(link.joint).S.leftCols(slack->u.size()) * slack->u;
  const bool slides = scales_.length() * twist.tail<3>().norm() <= 1e-6 * twist.head<3>().norm();
  Vec3 direction = (slides ? twist.head<3>() : twist.tail<3>()).normalized();
  Eigen::Index largest_entry = 0;
  direction.cwiseAbs().maxCoeff(&largest_entry);
  if (direction(largest_entry) < 0.0) direction = -direction;
  const Vec3 shown = direction.unaryExpr([](double x) { return std::abs(x) < 1e-12 ? 0.0 : x; });
  const Joint& joint = equations_->model().joints[link.joint];
  throw InputError(joint.where,
                   fmt::format("body '{}' and all that it carries in the opened tree have no inertia {} the axis "
                               "({:.4g}, {:.4g}, {:.4g}) of joint '{}' (parent's joint frame): give it inertia or name "
                               "another cut joint",
                               equations_->model().bodies[link.body].name, slides ? "along" : "about", shown.x(),
                               shown.y(), shown.z(), joint.name));
}

void Assembly::throw_not_closing(const PrescribedMask& prescribed) const {
  if (prescribed == equations_->driven()) {
    throw InputError(where_kept(prescribed),
                     fmt::format("start: the loops of {} cannot be closed near the start values: give "
                                 "better guesses of joint coordinates or body poses{}",
                                 equations_->model().name, couplings_of_kept(prescribed)));
  }
  throw InputError(where_kept(prescribed),
                   fmt::format("start: the kept joint coordinates ({}) contradict each other: the "
                               "loops do not close with them{}",
                               names_of_kept(prescribed), couplings_of_kept(prescribed)));
}

/// Whole turns, which change no pose, for couplings that are off by more: on the turn with the smallest factor among
/// those that are not prescribed.
void Assembly::add_turns_of_couplings(Coordinates& coordinates, const PrescribedMask& prescribed) const {
  const Model& model = equations_->model();
  const Topology& topology = equations_->topology();
  for (const Coupling& coupling : model.couplings) {
    const CouplingTerm* least = nullptr;
    for (const CouplingTerm& term : coupling.terms) {
      const int column = first_u(*model.joints[term.joint].type, term.word) + term.component;
      if (prescribed[topology.joints[term.joint].first_u + column] != 0) continue;
      if (!std::holds_alternative<joints::Turn>(model.joints[term.joint].type->permits[term.word])) continue;
      if (least == nullptr || std::abs(term.factor) < std::abs(least->factor)) least = &term;
    }
    if (least == nullptr) continue;
    const double turn = 2.0 * std::numbers::pi * least->factor;
    const double turns =
        std::round(compute_position_residual(coupling, equations_->kinematics(), coordinates.q) / turn);
    const int place = first_q(*model.joints[least->joint].type, least->word) + least->component;
    coordinates.q(topology.joints[least->joint].first_q + place) -= 2.0 * std::numbers::pi * turns;
  }
}

/// Gives links without prescribed values their canonical names, and requires that the others are on the branches
/// that the start values choose.
void Assembly::choose_branches(Coordinates& closed, const Coordinates& said, const PrescribedMask& prescribed_q,
                               const PrescribedMask& prescribed_u) const {
  const Model& model = equations_->model();
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    const Span& span = equations_->topology().joints[k];
    const Mobilizer& mobilizer = equations_->kinematics().mobilizer(k);
    if (!mobilizer.has_elevation()) continue;
    bool is_prescribed = false;
    for (int c = span.first_u; c < span.first_u + span.n_u; ++c)
      is_prescribed = is_prescribed || prescribed_q[c] != 0 || prescribed_u[c] != 0;
    if (!is_prescribed) {
      mobilizer.choose_canonical_chart(closed.q.data() + span.first_q);
    } else if (!mobilizer.is_on_branch_of(closed.q.data() + span.first_q, said.q.data() + span.first_q)) {
      throw InputError(model.joints[k].where,
                       fmt::format("start: joint '{}' closes on another branch than its start values say: a link's "
                                   "second turn passes a quarter turn: give other guesses or keep other coordinates",
                                   model.joints[k].name));
    }
  }
}

/// Requires that the start holds the kept values to round-off.
void Assembly::require_kept(const Coordinates& closed, const Coordinates& said) const {
  constexpr double kRoundOffOfKept = 1e-11;
  const Model& model = equations_->model();
  const double rate = std::max(rate_, size_of_u(closed.u));
  const auto require = [&](const Joint& joint, const char* what, const VecX& found, const VecX& kept, double allowed,
                           const VecX& left_out) {
    if ((found - kept).cwiseAbs().maxCoeff() <= allowed) return;
    throw InputError(joint.where, fmt::format("start: joint '{}' keeps the {} ({:.9g}), but the machine closes with "
                                              "({:.9g}): keep others",
                                              joint.name, what, fmt::join(VecX(kept + left_out), ", "),
                                              fmt::join(VecX(found + left_out), ", ")));
  };
  const VecX angles = static_cast<double>(kWholeTurn) * equations_->kinematics().turns();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const Span& span = equations_->topology().joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const WordStart& start = joint.start[word];
      const int iq = span.first_q + first_q(*joint.type, static_cast<int>(word));
      const int iu = span.first_u + first_u(*joint.type, static_cast<int>(word));
      if (start.role_q == StartRole::keep && start.q.size() > 0) {
        const auto n = start.q.size();
        VecX found = closed.q.segment(iq, n);
        VecX kept = said.q.segment(iq, n);
        if (std::holds_alternative<joints::Ball>(joint.type->permits[word])) {
          kept.normalize();
          if (found.dot(kept) < 0.0) kept = -kept;
        }
        const double unit = coordinate_units_(iq);
        require(joint, "coordinates", found, kept, kRoundOffOfKept * std::max(unit, kept.cwiseAbs().maxCoeff()),
                angles.segment(iq, n));
      }
      if (start.role_u == StartRole::keep && start.u.size() > 0) {
        const auto n = start.u.size();
        require(joint, "speeds", closed.u.segment(iu, n), said.u.segment(iu, n),
                kRoundOffOfKept * rate * scales_.speeds()(iu), VecX::Zero(n));
      }
    }
  }
}

Coordinates Assembly::start() {
  equations_->count_turns(VecX::Zero(equations_->topology().n_q));
  Coordinates start = guess_start();
  const PrescribedMask prescribed_q = kept(&WordStart::role_q);
  const PrescribedMask prescribed_u = kept(&WordStart::role_u);
  add_turns_of_couplings(start, prescribed_q);
  equations_->count_turns(equations_->kinematics().whole_turns(start.q));
  start.q = equations_->kinematics().without_turns(start.q);
  Coordinates closed = start;
  const bool kept_agree = close_positions(closed, prescribed_q, Modes::kept);
  if (!kept_agree) closed = start;
  if (kept_agree || close_positions(closed, equations_->driven(), Modes::kept)) {
    require_number_of_kept(closed, prescribed_q, Rows::of_positions);
  }
  if (!kept_agree) throw_not_closing(prescribed_q);
  closed.u = start.u;  // closing the positions has measured the cut joints' speeds, those too that are kept
  choose_branches(closed, start, prescribed_q, prescribed_u);
  require_independent_start(closed, prescribed_q, Rows::of_positions);
  require_number_of_kept(closed, prescribed_u, Rows::of_velocities);
  require_independent_start(closed, prescribed_u, Rows::of_velocities);
  require_inertia(closed);
  if (!close_velocities(closed, prescribed_u, Modes::kept)) {
    throw InputError(where_kept(prescribed_u),
                     fmt::format("start: the kept joint speeds ({}) contradict each other{}",
                                 names_of_kept(prescribed_u), couplings_of_kept(prescribed_u)));
  }
  move(closed);
  require_kept(closed, start);
  if (!rank_is_decided_) decide_rank_near(closed);
  return closed;
}

}  // namespace concord::relative
