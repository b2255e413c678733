#pragma once

#include <string>
#include <vector>

#include "common/joints/coordinate.h"
#include "common/model.h"
#include "common/results.h"

/// The pose that a machine starts in, beside what its model says of it.
namespace concord::compare {

/// What decides a coordinate of the start.
enum class Said { nothing, guess, keep, law };

/// One coordinate of a joint at the start.
struct StartCoordinate {
  int joint = 0;
  std::string name;  // "turn_z"
  joints::CoordinateKind kind{};
  Said said = Said::nothing;
  VecX value;          // m or rad; of an orientation its rotation vector [rad]
  VecX guess;          // the same of the guess, or of what is kept and met no further than it is written; else empty
  double moved = 0.0;  // from the guess, whole turns aside that change nothing [m, rad]; of an orientation the angle
  double size = 0.0;   // |moved| in the machine's length or rad
};

/// A body that stands elsewhere than its model guesses.
struct MovedBody {
  int body = 0;
  double apart = 0.0;   // of its origin [m]
  double turned = 0.0;  // rad
};

/// Poses that keep what the model keeps and drives, beside the one that was taken: those that were found.
struct OtherPoses {
  /// Of each pose the numbers of all coordinates, as StartCoordinate::value, in their order.
  std::vector<std::vector<VecX>> values;
  int guesses = 0;          // from which they were sought; 0: the machine has no loop
  bool not_sought = false;  // the machine has loops, but is too large to seek beside a comparison
  std::string found_by;     // the solver that assembled them
  std::string accepted_by;  // the one whose own residuals accept them
};

struct StartReport {
  std::vector<StartCoordinate> coordinates;  // of all joints, in the order of the model
  std::vector<MovedBody> bodies;             // noticeably, in the order of the model
  OtherPoses others;
};

/// What is noticed: a hundredth of the machine's length, or of a radian.
inline constexpr double kNoticed = 0.01;

/// The start of a machine beside what the model as it was given says of it. A run from the equilibrium keeps nothing:
/// what the model keeps counts as a guess there.
StartReport report_start(const Model& given, const State& start);

/// Enters a pose that was found beside that of the report: angles on the turn nearest to those of the start, where
/// whole turns change nothing.
void add_other_pose(const Model& given, const State& found, StartReport& report);

}  // namespace concord::compare
