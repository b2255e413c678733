#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "cartesian/run/collocation.h"
#include "cartesian/run/rate_predictor.h"
#include "cartesian/run/step_tolerances.h"
#include "cartesian/run/stepper.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// How many steps go by before vibrations are taken anew: they change little, and an error in them is no error of the
/// motion.
constexpr int kRenewEvery = 8;
/// Sweeps over the points of a step after which its solution should have converged, and after which it is given up.
constexpr int kAimedSweeps = 3;
constexpr int kMostSweeps = 10;
/// By how much an accepted step may be exceeded by the next one: by little, for steps that are rejected cost more.
constexpr double kGrowth = 1.2;
constexpr double kGrowthAtStart = 10.0;
constexpr double kSafety = 0.85;
/// Of changes from sweep to sweep, where they are too small to tell.
constexpr double kUsualContraction = 0.1;

/// Parts of a step that are looked at one by one: a fast motion may make half a turn in a step, and where the ends of a
/// line spring may touch, a cubic must tell.
constexpr int kParts = 4;
constexpr int kPartsForLines = 16;
/// Changes of a line spring's line in a step, as a part of its length, in which its ends cannot meet. Where they do,
/// the change at the rate of the nearest point is as many times larger as that point is nearer than the step is long.
constexpr double kLineStays = 1.0;

class CollocationStepper : public Stepper {
 public:
  CollocationStepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance)
      : Stepper(dynamics, start),
        n_q_(equations_.layout().n_q()),
        n_Y_(equations_.layout().n_Y()),
        until_(tolerance.until),
        tolerances_(dynamics, start, tolerance),
        end_(start),
        interpolated_(start),
        vibrations_(equations_),
        main_(equations_, vibrations_),
        beside_(equations_, vibrations_),
        now_(main_.make_points()),
        last_(main_.make_points()),
        aside_(main_.make_points()),
        predictor_(main_.size(), now_.a.rows()) {
    dynamics_.keep_places(kPoints);
    y0_ = y_ = ydot_ = weights_ = before_ = high_ = VecX::Zero(main_.size());
    visited_ = of_ydot_ = MatX::Zero(main_.size(), kPoints);
    of_g_ = MatX::Zero(now_.g.rows(), kPoints);
  }

 protected:
  void advance(double limit) override {
    tolerances_.follow(reached_, reached_ - started_, motion_, largest_work_);
    last_start_ = started_;
    started_ = reached_;
    write(motion_, y0_);
    weights_ = (tolerances_.rtol() * y0_.cwiseAbs() + tolerances_.absolute()).cwiseInverse();
    if (is_new_) {
      begin_motion(limit);
    } else {
      std::swap(last_, now_);
      if (++since_renewed_ >= kRenewEvery) renew_vibrations();
    }
    const double last_length = length_;
    double end = started_;
    do {
      end = end_of_try(limit);
      length_ = end - started_;
      main_.begin(y0_, length_);
      predictor_.begin(started_, length_, last_start_, last_length);
      if (is_new_) guess_constant_rates();
    } while (!try_step());
    is_new_ = false;
    predictor_.know_past();
    read(y_, end_);
    dynamics_.project(*nearby_, end, end_.q, end_.Y);
    motion_ = end_;
    reached_ = end;
    ++steps_;
  }

  const MotionState& interpolate(double t) override {
    if (t == reached_) return end_;
    main_.write_state_within((t - started_) / length_, now_, y_);
    read(y_, interpolated_);
    return interpolated_;
  }

  /// A step of its own to t, from rates that the last step's polynomials tell: they leave little to converge. Within a
  /// step they are known to a lower order than its end.
  void set_motion_at(double t) override {
    if (t == reached_) {
      motion_ = end_;
      return;
    }
    const double length = t - started_;
    PointRow factors;
    for (int m = 0; m < kPoints; ++m) {
      write_interpolation(gauss_rule().points.data(), kPoints, gauss_rule().points[m] * length / length_,
                          factors.data());
      aside_.ydot.col(m).noalias() = now_.ydot * factors.transpose();
      aside_.g.col(m).noalias() = now_.g * factors.transpose();
    }
    beside_.begin(y0_, length);
    beside_.write_state(kPoints, aside_, y_);
    for (int sweep = 1; sweep <= kMostSweeps; ++sweep) {
      before_ = y_;
      if (!sweep_points(beside_, length, sweep > 1, aside_)) give_up("equations of motion cannot be evaluated");
      if (has_converged(norm(y_ - before_), contraction_)) break;
    }
    read(y_, motion_);
    dynamics_.project(*nearby_, t, motion_.q, motion_.Y);
  }

  [[nodiscard]] int parts_of_step() const override {
    return line_rate_ * length_ < kLineStays ? kParts : kPartsForLines;
  }
  [[nodiscard]] bool remembers_multipliers() const override { return false; }

  void restart(double t) override {
    reached_ = t;
    end_ = motion_;
    is_new_ = true;
  }

 private:
  /// At the start, and where the equations go on as others.
  void begin_motion(double limit) {
    constexpr double kPart = 0.01;      // of the time in which the motion changes by its size, at its rates
    constexpr double kLeastSize = 1e3;  // in tolerances
    constexpr double kAfterBreak = 0.25;
    predictor_.forget();
    if (!evaluate(0, false, started_, y0_)) give_up("the equations of motion cannot be evaluated");
    ydot0_ = ydot_;
    renew_vibrations();
    const double change = norm(ydot0_);
    const double first = change > 0.0 ? kPart * std::max(norm(y0_), kLeastSize) / change : HUGE_VAL;
    next_ = next_ > 0.0 ? kAfterBreak * next_ : std::min(first, kPart * (limit - started_));
    growth_ = kGrowthAtStart;
  }

  void guess_constant_rates() {
    for (int m = 0; m < kPoints; ++m) main_.keep_rates(m, y0_, ydot0_, now_);
  }

  /// From the last solution, which is near.
  void renew_vibrations() {
    vibrations_.renew(dynamics_);
    for (int m = 0; m < kPoints; ++m) main_.take_rest(m, last_);
    since_renewed_ = 0;
  }

  /// Where the next try of a step ends: no short step is left before the limit.
  [[nodiscard]] double end_of_try(double limit) const {
    constexpr double kShortRest = 1.1;
    const double left = limit - started_;
    if (left <= next_) return limit;
    return started_ + (left < kShortRest * next_ ? 0.5 * left : next_);
  }

  [[nodiscard]] double norm(const VecX& difference) const {
    return difference.cwiseProduct(weights_).cwiseAbs().maxCoeff();
  }

  /// At one of the points, where `again` says whether this step has been there before.
  bool evaluate(int place, bool again, double t, const VecX& y) {
    if (!y.allFinite()) return false;
    try {
      ++evaluations_;
      const auto q = y.head(n_q_);
      const auto Y = y.segment(n_q_, n_Y_);
      const Solution& solution = dynamics_.solve_at_place(place, again, t, q, Y);
      nearby_ = &solution;
      equations_.layout().write_qdot(q, Y, ydot_.head(n_q_));
      ydot_.segment(n_q_, n_Y_) = solution.Ydot();
      ydot_(n_q_ + n_Y_) = equations_.power_of(solution.lambda());
      return ydot_.allFinite();
    } catch (const SolverError&) {
      failure_ = std::current_exception();
      return false;
    }
  }

  /// Finds the rates at each point anew from those at all points, later ones as they were before. Then y_ is the
  /// solution at the end.
  bool sweep_points(Collocation& step, double length, bool again, PointRates& rates) {
    for (int m = 0; m < kPoints; ++m) {
      step.write_state(m, rates, y_);
      visited_.col(m) = y_;
      if (!evaluate(m, again, started_ + gauss_rule().points[m] * length, y_)) return false;
      step.keep_rates(m, y_, ydot_, rates);
    }
    step.write_state(kPoints, rates, y_);
    return true;
  }

  /// The first sweep, which foretells the rates at later points from those at earlier ones.
  bool predict_points() {
    line_rate_ = 0.0;
    for (int m = 0; m < kPoints; ++m) {
      predictor_.predict(m, last_, now_);
      main_.write_state(m, now_, y_);
      visited_.col(m) = y_;
      if (!evaluate(m, false, started_ + gauss_rule().points[m] * length_, y_)) return false;
      line_rate_ = std::max(line_rate_, equations_.applied().fastest_line_rate());
      main_.keep_rates(m, y_, ydot_, now_);
      predictor_.learn(m, last_, now_, main_, weights_);
    }
    predictor_.choose();
    return true;
  }

  /// By how much the solution at the points has moved from where their rates were found, in tolerances: what the next
  /// sweep changes.
  double open_at_points() {
    double largest = 0.0;
    for (int m = 0; m < kPoints; ++m) {
      main_.write_state(m, now_, y_);
      largest = std::max(largest, norm(y_ - visited_.col(m)));
    }
    return largest;
  }

  /// Whether what further sweeps would change of the end is small, when the last one has changed it by so many
  /// tolerances.
  static bool has_converged(double change, double contraction) {
    constexpr double kSmall = 0.1;
    constexpr double kTiny = 0.01;
    const double bounded = std::min(contraction, 0.9);
    return change * bounded / (1.0 - bounded) < kSmall || change < kTiny;
  }

  /// The step from started_, length_ long. False if it must be shorter, as next_ then is.
  bool try_step() {
    constexpr double kHopeless = 1e6;  // tolerances
    constexpr double kDivergence = 0.8;
    constexpr double kMeasurable = 1.0;  // tolerances
    failure_ = nullptr;
    contraction_ = kUsualContraction;
    if (!predict_points()) return shorten(0.1);
    if (error_of_step() > kHopeless) return shorten(0.3);
    double open_before = open_at_points();
    int sweeps = 1;
    for (;;) {
      main_.write_state(kPoints, now_, before_);
      if (!sweep_points(main_, length_, true, now_)) return shorten(0.1);
      ++sweeps;
      const double open = open_at_points();
      if (open_before > kMeasurable) contraction_ = open / open_before;
      main_.write_state(kPoints, now_, y_);
      if (has_converged(norm(y_ - before_), contraction_)) break;
      if (!(contraction_ < kDivergence) || sweeps == kMostSweeps) return shorten(0.5);
      open_before = open;
    }
    const double error = error_of_step();
    if (!(error <= 1.0)) return shorten(std::clamp(0.9 * std::pow(error, -1.0 / 12.0), 0.2, 0.9));
    lengthen(error, sweeps);
    return true;
  }

  /// Of the end of the step, in tolerances. Legendre coefficients of rates fall by as much from each to the next as
  /// those did that are known; what is left of them at twice the degree is the error of Gauss's rule (C60).
  double error_of_step() {
    const PointSquare& legendre = legendre_coefficients();
    constexpr int n = kPoints;
    of_ydot_.noalias() = length_ * now_.ydot * legendre.transpose();
    of_g_.noalias() = length_ * now_.g * legendre.transpose();
    const auto largest = [&](int degree) {
      main_.write_change(of_ydot_.col(degree), of_g_.col(degree), high_);
      return norm(high_);
    };
    const double high = largest(n - 1) + largest(n - 2);
    const double middle = largest(n - 3) + largest(n - 4);
    const double ratio = middle > high ? high / middle : 1.0;
    return high * ratio * ratio * ratio;
  }

  bool shorten(double factor) {
    constexpr double kShortest = 1e-13;  // of the run
    next_ = factor * length_;
    growth_ = kGrowth;
    if (next_ < kShortest * until_) give_up("no step succeeds, however short");
    return false;
  }

  void lengthen(double error, int sweeps) {
    constexpr double kOrder = 15.0;
    double factor = kSafety * std::pow(std::max(error, 1e-30), -1.0 / kOrder);
    if (growth_ > kGrowth && sweeps <= kAimedSweeps) {
      factor = std::min(factor, growth_);
    } else {
      growth_ = kGrowth;
      factor = std::min(factor, sweeps < kAimedSweeps ? kGrowth : std::pow(0.85, sweeps - kAimedSweeps));
    }
    // A step as long as the last one needs no new integrals.
    if (factor < 0.95 || factor > 1.1)
      next_ = std::max(factor, 0.2) * length_;
    else
      next_ = length_;
  }

  [[noreturn]] void give_up(const char* reason) const {
    if (failure_) std::rethrow_exception(failure_);
    throw SolverError(fmt::format("cartesian (gauss): at t = {:.6g} s {}", started_, reason));
  }

  void read(const VecX& y, MotionState& motion) const {
    motion.q = y.head(n_q_);
    motion.Y = y.segment(n_q_, n_Y_);
    motion.work = y(n_q_ + n_Y_);
  }
  void write(const MotionState& motion, VecX& y) const {
    y.head(n_q_) = motion.q;
    y.segment(n_q_, n_Y_) = motion.Y;
    y(n_q_ + n_Y_) = motion.work;
  }

  Eigen::Index n_q_;
  Eigen::Index n_Y_;
  double until_;
  StepTolerances tolerances_;
  MotionState end_;
  MotionState interpolated_;
  Vibrations vibrations_;
  Collocation main_;
  Collocation beside_;  // of steps to times within the last one
  PointRates now_;
  PointRates last_;
  PointRates aside_;
  RatePredictor predictor_;
  std::exception_ptr failure_;        // the last within a step
  const Solution* nearby_ = nullptr;  // at the last point
  bool is_new_ = true;                // no step has been made since the start
  double started_ = 0.0;              // the last step, at
  double length_ = 0.0;               // and its length
  double line_rate_ = 0.0;            // the fastest of a line spring at its points
  double last_start_ = 0.0;
  double next_ = 0.0;  // length to try next; 0: none is known
  double growth_ = kGrowthAtStart;
  double contraction_ = kUsualContraction;  // of changes at the points from sweep to sweep
  int since_renewed_ = 0;
  VecX y0_;
  VecX ydot0_;
  VecX y_;
  VecX ydot_;
  VecX weights_;  // 1 / tolerance
  VecX before_;   // the solution at the end, before the last sweep
  VecX high_;
  MatX visited_;  // the solution at the points, where their rates were found
  MatX of_ydot_;  // Legendre coefficients
  MatX of_g_;
};

}  // namespace

std::unique_ptr<Stepper> make_collocation_stepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance) {
  return std::make_unique<CollocationStepper>(dynamics, start, tolerance);
}

}  // namespace concord::cartesian
