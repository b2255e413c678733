#include "compare/verdict/near_parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "compare/audit/joint_motion.h"

namespace concord::compare {

namespace {

/// The axis of a joint that turns about nothing else, on one of its bodies.
struct Hinge {
  const Joint& joint;
  int body;
  Vec3 axis_L;
};

std::vector<Hinge> hinges_of(const Model& model) {
  std::vector<Hinge> hinges;
  for (const Joint& joint : model.joints) {
    const std::vector<bool> turns = turning_speeds(*joint.type);
    const std::vector<std::string> names = speed_names(*joint.type);
    if (std::count(turns.begin(), turns.end(), true) != 1) continue;
    if (std::find(names.begin(), names.end(), "turn_z") == names.end()) continue;
    for (const Attachment& side : joint.sides) hinges.push_back({joint, side.body, side.C.col(2)});
  }
  return hinges;
}

}  // namespace

std::string note_on_near_parallel_axes(const Model& model) {
  constexpr double kRoundOff = 1e-14;
  constexpr double kMeantToBeParallel = 1e-4;
  double largest = kRoundOff;
  std::string note;
  const bool has_loops = model.joints.size() + 1 > model.bodies.size();
  const bool is_driven =
      std::any_of(model.joints.begin(), model.joints.end(), [](const Joint& joint) { return !joint.drivers.empty(); });
  if (!has_loops || is_driven) return note;
  const std::vector<Hinge> hinges = hinges_of(model);
  for (const Hinge& one : hinges) {
    for (const Hinge& other : hinges) {
      if (one.body != other.body) continue;
      const double angle = one.axis_L.cross(other.axis_L).norm();
      if (angle <= largest || angle >= kMeantToBeParallel) continue;
      largest = angle;
      note = fmt::format(
          "on {} the axes of joints {} and {} are off parallel by {:.1e} rad: a loop of hinges that were meant to be "
          "parallel is locked by that; give their axes with all digits",
          model.bodies[static_cast<std::size_t>(one.body)].name, one.joint.name, other.joint.name, angle);
    }
  }
  return note;
}

bool is_motion_doubtful(const RankReport& rank) { return rank.undecided || rank.degrees_of_freedom == 0; }

InputError explained(const InputError& error, const Model& model) {
  std::vector<Diagnostic> diagnostics = error.diagnostics();
  const std::string note = note_on_near_parallel_axes(model);
  if (!note.empty() && !diagnostics.empty()) diagnostics.front().message += "; " + note;
  return InputError(std::move(diagnostics));
}

}  // namespace concord::compare
