#include "relative/closure/joint_measure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "relative/bodies/exponential_map.h"
#include "relative/bodies/six_columns.h"

namespace concord::relative {

namespace {

constexpr double kNewtonIsQuadratic = 1e-7;  // one more step from here ends at round-off
constexpr int kMostNewtonSteps = 30;
constexpr int kMostHalvings = 8;
constexpr double kLongestStep = 1.0;  // rad or Mobilizer::length
constexpr double kMisfitOfAnotherBranch = 1e-6;
constexpr double kClearlyBetter = 0.1;  // of the misfit on the branch that the guess means
constexpr double kStillBetter = 0.9;    // of the best misfit so far

Vec6 position_error(const JointMotion& motion, const JointPoint& parent, const JointPoint& child) {  // (R39)
  Vec6 error;
  error.head<3>() = parent.A.transpose() * (child.r - parent.r) - motion.d;
  error.tail<3>() = rotation_vector(parent.A.transpose() * child.A * motion.R.transpose());
  return error;
}

/// At most those of a joint without forbidden directions.
using JointCoordinates = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 7, 1>;

/// Rows `first_row` .. + 2 of the chosen columns of S.
Mat3 three_rows(const Mat6& S, const std::vector<int>& columns, int first_row) {
  Mat3 chosen = Mat3::Zero();
  for (std::size_t c = 0; c < columns.size(); ++c) chosen.col(c) = S.col(columns[c]).segment<3>(first_row);
  return chosen;
}

}  // namespace

PrescribedMask driven_speeds(const Model& model, const Topology& topology) {
  PrescribedMask prescribed(topology.n_u, 0);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Driver& driver : model.joints[k].drivers) {
      prescribed[topology.joints[k].first_u + first_u(*model.joints[k].type, driver.word) + driver.component] = 1;
    }
  }
  return prescribed;
}

JointMeasure::JointMeasure(const Mobilizer& mobilizer, const char* prescribed) : mobilizer_(&mobilizer) {
  for (int c = 0; c < mobilizer.n_u(); ++c) {
    (prescribed[c] != 0 ? prescribed_ : free_).push_back(c);
    if (prescribed[c] == 0 && !mobilizer.couples())
      (mobilizer.kind(c).displaces ? displacing_ : rotating_).push_back(c);
  }
}

/// Displacements as parts of Mobilizer::length, so that they weigh against rotations in any unit.
Vec6 JointMeasure::weighed(const Vec6& motion) const {
  Vec6 result = motion;
  result.head<3>() /= mobilizer_->length();
  return result;
}

/// Radian or Mobilizer::length: what speed or coordinate c is counted in where it weighs against others.
double JointMeasure::unit(int c) const { return mobilizer_->kind(c).is_length ? mobilizer_->length() : 1.0; }

/// Weighed motion by a unit of each free speed.
JointColumns JointMeasure::free_columns() const {
  JointColumns S(6, free_.size());
  for (std::size_t c = 0; c < free_.size(); ++c) S.col(c) = unit(free_[c]) * weighed(at_.S.col(free_[c]));
  return S;
}

/// The free speeds (n_u numbers, zero where prescribed) whose motion S u comes closest to the given one (R40).
JointVector JointMeasure::fit(const Vec6& motion) const {
  JointVector speeds = JointVector::Zero(mobilizer_->n_u());
  if (mobilizer_->couples()) {
    fit_together(motion, speeds);
  } else {
    fit_separately(motion, speeds);
  }
  return speeds;
}

/// Each speed either displaces or rotates: the two spaces never weigh against each other.
void JointMeasure::fit_separately(const Vec6& motion, JointVector& speeds) const {
  const Vec3 slides = displacements_.fit(motion.head<3>());
  const Vec3 turns = rotations_.fit(motion.tail<3>());
  for (std::size_t c = 0; c < displacing_.size(); ++c) speeds(displacing_[c]) = slides(c);
  for (std::size_t c = 0; c < rotating_.size(); ++c) speeds(rotating_[c]) = turns(c);
}

void JointMeasure::fit_together(const Vec6& motion, JointVector& speeds) const {
  if (free_.empty()) return;
  const JointColumns S = free_columns();
  const JointSquare normal = S.transpose() * S;
  const JointVector fitted = normal.ldlt().solve(S.transpose() * weighed(motion));
  for (std::size_t c = 0; c < free_.size(); ++c) speeds(free_[c]) = unit(free_[c]) * fitted(c);
}

double JointMeasure::amplification(int c) const {
  const auto place = std::find(free_.begin(), free_.end(), c);
  if (place == free_.end()) return 0.0;
  const JointColumns S = free_columns();
  const JointSquare normal = S.transpose() * S;
  const JointVector row = normal.ldlt().solve(JointVector::Unit(S.cols(), place - free_.begin()));
  return (S * row).norm();
}

/// Columns that are the same in every pose need this once.
void JointMeasure::decompose_columns() {
  if (mobilizer_->couples()) return;
  const auto decompose = [this](SpatialBasis& basis, const std::vector<int>& columns, int first_row) {
    const auto is_fixed = [this](int c) { return mobilizer_->kind(c).is_fixed; };
    if (is_decomposed_ && std::all_of(columns.begin(), columns.end(), is_fixed)) return;
    basis.decompose(three_rows(at_.S, columns, first_row), static_cast<int>(columns.size()));
  };
  decompose(displacements_, displacing_, 0);
  decompose(rotations_, rotating_, 3);
  is_decomposed_ = true;
}

/// Takes the motion at q and the error there; returns half the square of its size.
double JointMeasure::look(const JointPoint& parent, const JointPoint& child, const double* q) {
  const JointVector still = JointVector::Zero(mobilizer_->n_u());
  mobilizer_->evaluate(q, still.data(), at_);
  position_residual_ = position_error(at_, parent, child);
  return 0.5 * weighed(position_residual_).squaredNorm();
}

/// The same, where fits are to follow.
void JointMeasure::move(const JointPoint& parent, const JointPoint& child, const double* q) {
  look(parent, child, q);
  decompose_columns();
}

/// The part of a step at which the squared error, taken as a parabola, is least; halved until it is less than now. Far
/// from closed, where the error is strongly nonlinear, full steps may overshoot for ever (R41).
double JointMeasure::step_length(const JointPoint& parent, const JointPoint& child, const double* q,
                                 const JointVector& step) {
  const double now = 0.5 * weighed(position_residual_).squaredNorm();
  double slope = 0.0;
  for (const int c : free_) slope -= step(c) * weighed(at_.S.col(c)).dot(weighed(position_residual_));
  JointCoordinates trial(mobilizer_->n_q());
  double length = 1.0;
  for (int halvings = 0; halvings < kMostHalvings; ++halvings) {
    trial = Eigen::Map<const VecX>(q, mobilizer_->n_q());
    const JointVector part = length * step;
    mobilizer_->advance(trial.data(), part.data());
    const double then = look(parent, child, trial.data());
    const double bend = then - now - length * slope;
    const double best = bend > 0.0 ? -0.5 * slope * length * length / bend : 2.0 * length;
    if (then < now) return std::clamp(best, 0.5 * length, 2.0 * length);
    length = std::clamp(best, 0.1 * length, 0.5 * length);
  }
  return length;
}

/// The largest of the steps, in radians and in Mobilizer::length.
double JointMeasure::size_of(const JointVector& step) const {
  double size = 0.0;
  for (const int c : free_) {
    size = std::max(size, std::abs(step(c)) / unit(c));
  }
  return size;
}

/// Size of the error, displacements in parts of the length.
double JointMeasure::misfit() const {
  return std::hypot(position_residual_.head<3>().norm() / mobilizer_->length(), position_residual_.tail<3>().norm());
}

/// Returns the size of the misfit; leaves motion, error at the q found.
double JointMeasure::newton(const JointPoint& parent, const JointPoint& child, double* q) {
  move(parent, child, q);
  has_settled_ = free_.empty();
  for (int step = 0; step < kMostNewtonSteps && !has_settled_; ++step) {
    JointVector correction = fit(position_residual_);
    const double largest = size_of(correction);
    if (mobilizer_->is_curved() && largest > kNewtonIsQuadratic) {
      // A ball finds its own rotation in one whole step, whatever the others do.
      JointVector swing = correction;
      if (mobilizer_->has_ball()) swing.tail<3>().setZero();
      correction -= swing;
      swing *= kLongestStep / std::max(kLongestStep, size_of(swing));
      correction += step_length(parent, child, q, swing) * swing;
    }
    mobilizer_->advance(q, correction.data());
    move(parent, child, q);
    has_settled_ = largest <= kNewtonIsQuadratic;
  }
  return misfit();
}

/// Moves the coordinates of a motion by functions to fit the position alone, as far as it determines them: the position
/// counts the turns of a thread, the orientation does not.
void JointMeasure::follow_place(const JointPoint& parent, const JointPoint& child, double* q) {
  constexpr int kMostSteps = 8;
  move(parent, child, q);
  for (int step = 0; step < kMostSteps; ++step) {
    JointColumns S = free_columns();
    S.bottomRows<3>() *= 1e-9;
    Vec6 error = weighed(position_residual_);
    error.tail<3>().setZero();
    const JointVector fitted = smallest_least_squares(S, error);
    JointVector correction = JointVector::Zero(mobilizer_->n_u());
    for (std::size_t c = 0; c < free_.size(); ++c) correction(free_[c]) = unit(free_[c]) * fitted(c);
    if (!correction.allFinite()) return;
    mobilizer_->advance(q, correction.data());
    move(parent, child, q);
  }
}

/// Starts from all combinations of the motion's trial values about `given`, and from the fit of the position; leaves in
/// q the best pose whose misfit is below `least`, else q as it is.
void JointMeasure::search(const JointPoint& parent, const JointPoint& child, double least, const VecX& given,
                          double* q) {
  std::vector<int> tried;  // of scalar words: their places in q and u are the same
  for (const int c : free_) {
    if (mobilizer_->has_trials(c)) tried.push_back(c);
  }
  Eigen::Map<VecX> found(q, mobilizer_->n_q());
  VecX best = found;
  if (mobilizer_->is_by_functions() && !free_.empty()) {
    follow_place(parent, child, q);
    const double misfit = newton(parent, child, q);
    if (misfit < least) {
      least = kStillBetter * misfit;
      best = found;
    }
  }
  for (int trial = 0; trial < std::pow(4, tried.size()); ++trial) {
    found = given;
    int digits = trial;
    for (const int c : tried) {
      found(c) = mobilizer_->trial(c, digits % 4, given(c));
      digits /= 4;
    }
    const double misfit = newton(parent, child, q);
    // Clearly better, or else a start some turns away would win by round-off.
    if (!(misfit < least)) continue;
    least = kStillBetter * misfit;
    best = found;
  }
  found = best;
}

void JointMeasure::find_q(const JointPoint& parent, const JointPoint& child, double* q, Restart restart) {
  bool is_found = false;
  if (restart != Restart::never) {
    const Eigen::Map<const VecX> now(q, mobilizer_->n_q());
    const JointCoordinates given = now;
    const double misfit = newton(parent, child, q);
    is_found = has_settled_ && misfit <= kMisfitOfAnotherBranch;
    if (!(misfit <= kMisfitOfAnotherBranch)) {
      const double share = restart == Restart::if_better ? kStillBetter : kClearlyBetter;
      search(parent, child, std::isfinite(misfit) ? share * misfit : HUGE_VAL, given, q);
    }
    const JointCoordinates found = now;
    if (prescribed_.empty()) mobilizer_->choose_chart(q, given.data());
    is_found = is_found && now == found;
  }
  if (!is_found) newton(parent, child, q);
  compute_complement();
}

void JointMeasure::find_u(const JointPoint& parent, const JointPoint& child, const double* q, double* u) {
  Vec6 rest = relative_velocity(parent, child);
  for (const int c : prescribed_) rest -= at_.S.col(c) * u[c];
  for (const int c : free_) u[c] = 0.0;
  const int rounds = mobilizer_->couples() ? 2 : 1;  // once more for the round-off of the normal equations
  for (int round = 0; round < rounds; ++round) {
    const JointVector fitted = fit(rest);
    for (const int c : free_) {
      u[c] += fitted(c);
      rest -= at_.S.col(c) * fitted(c);
    }
  }
  velocity_residual_ = rest;
  mobilizer_->evaluate(q, u, at_);
}

void JointMeasure::compute_complement() {
  T_.setZero();
  if (mobilizer_->couples()) {
    complete_together();
    return;
  }
  T_.block(0, 0, 3, 3 - displacements_.n()) = displacements_.complement();
  T_.block(3, 3 - displacements_.n(), 3, 3 - rotations_.n()) = rotations_.complement();
}

/// In displacements as parts of the length; the rows are then measured in metres.
void JointMeasure::complete_together() {
  OrthonormalColumns directions;
  for (const int c : free_) directions.add(directions.rest(weighed(at_.S.col(c))));
  directions.complete();
  const int rows = n_rows();
  T_.leftCols(rows) = directions.directions().rightCols(rows);
  T_.bottomRows<3>() *= mobilizer_->length();
}

}  // namespace concord::relative
