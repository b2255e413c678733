#pragma once

#include <string>
#include <vector>

#include "compare/invariance/change.h"

/// The moves of the checks: ways to describe a machine anew.
namespace concord::compare::invariance {

/// One description that a move makes.
struct Variant {
  std::string label;  // "D is cut"; empty if the move makes one description
  Change change;
};

struct Move {
  std::string name;   // "sides"
  std::string about;  // "parent and child of joints and springs change places"
  std::vector<Variant> variants;
  /// Why the move does not apply to the machine; empty if it does.
  std::string why_not;
  /// Parts of the machine that stay as they are, with the reason.
  std::vector<std::string> left;
  /// The move means nothing to a solver that cuts no joint.
  bool of_cuts = false;
};

/// Names of all moves, in the order in which they are made.
const std::vector<std::string>& move_names();

/// The moves of that name, or all if `names` is empty, for a machine that starts in `start`; the same for the same
/// seed.
std::vector<Move> moves_of(const Model& model, const State& start, const std::vector<std::string>& names,
                           std::uint64_t seed);

/// Names one joint as the cut joint of its loop.
Change cut_at(std::size_t joint);

/// Joints that lie in a loop: without them their bodies are still connected.
std::vector<std::size_t> joints_in_loops(const Model& model);

/// The frame of every body moved and turned in the body.
Change moved_frames(const Model& model, std::uint64_t seed);
/// The same by so little that only the round-off of the model's numbers is another one.
Change nearby_frames(const Model& model, std::uint64_t seed);
/// The world turned and moved as far as the model's roads allow.
Change moved_world(const Model& model, std::uint64_t seed);
/// Bodies, joints, couplings and force elements in another order.
Change shuffled(const Model& model, std::uint64_t seed);
/// The modes of every flexible body combined anew.
Change recombined(const Model& model, std::uint64_t seed);

}  // namespace concord::compare::invariance
