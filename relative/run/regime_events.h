#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "relative/forces/applied_forces.h"
#include "relative/run/stepper.h"

/// The ends of the regimes of tires, stops and tables in a run.
namespace concord::relative {

/// Takes an integration through the events of its tires and stops: during a step their regimes are kept, and a step in
/// which one ends is made anew up to there.
class RegimeEvents {
 public:
  /// Brings the forces to a time and the integrated numbers.
  using ApplyForces = std::function<void(double t, const Eigen::Ref<const VecX>& y)>;

  /// `sizes`: of the coordinates, which come first among the integrated numbers; `until`: the end of the run [s].
  RegimeEvents(AppliedForces& forces, ApplyForces apply, Stepper& stepper, VecX sizes, double until);
  ~RegimeEvents();
  RegimeEvents(const RegimeEvents&) = delete;
  RegimeEvents& operator=(const RegimeEvents&) = delete;

  /// Takes the regimes of the state that the stepper has reached.
  void set_regimes();

  /// Makes one step, to t_end at most. Throws SolverError where the stepper does, and where events follow each other
  /// without end.
  void step(double t_end);

 private:
  /// Lengths of two steps, and the event function where they end: inside the regimes, and outside.
  struct Bracket {
    double inside, value_inside;
    double outside, value_outside;
  };
  /// A time of the last step, from its begin, and the event functions there.
  struct Look {
    double at = 0.0;
    VecX values;

    [[nodiscard]] double least() const { return values.minCoeff(); }
  };
  /// The same of one event function.
  struct Point {
    double at;
    double value;
  };
  static Point point(const Look& look, Eigen::Index function) { return {look.at, look.values(function)}; }

  void take_event_functions(double t, const Eigen::Ref<const VecX>& y, VecX& values);
  double least_event_function();
  void take_look(double t_before, double at, Look& look);
  std::optional<Bracket> find_bracket(double t_before, double step);
  std::optional<Bracket> find_dip(double t_before);
  static std::optional<Point> lowest_possible(const std::array<Point, 4>& around);
  std::optional<Point> follow_dip(double t_before, std::array<Point, 4> around, Eigen::Index function);
  [[nodiscard]] Bracket up_to(double at, double value) const;
  [[nodiscard]] static double guess(const Bracket& bracket, double tolerance);
  void approach(Bracket bracket);
  void require_progress();
  void require_held_regimes(const std::optional<AppliedForces::Contact>& departed);

  AppliedForces* forces_;
  ApplyForces apply_;
  Stepper* stepper_;
  double until_;
  VecX within_;
  std::array<Look, 5> looks_;  // into the last step, from its begin to its end
  Look look_;
  /// When an event was, and how far the coordinates had moved from event to event, in their sizes.
  struct Event {
    double t;
    double way;
  };
  VecX sizes_;
  VecX at_event_;  // the coordinates at the last one
  std::vector<Event> events_;
  bool departed_ = false;  // some force from its law, at the end of the last step
};

}  // namespace concord::relative
