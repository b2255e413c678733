#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/joint_check/poses.h"

/// The rigs in which a joint type is tested: two unequal bodies in generic poses, the first held to ground by a free
/// joint and joined to the second by the type under test; all frames tilted, all points off the axes, gravity askew.
namespace concord::relative {
class Equations;
class States;
}  // namespace concord::relative

namespace concord::compare::joint_check {

/// What acts on one coordinate of the joint under test.
enum class Load { none, spring, motor, driver };

/// How the joint under test is built in.
struct Arrangement {
  bool parent_bends = false;
  bool child_bends = false;
  bool tree_runs_against = false;  // from the joint's child to its parent
  std::vector<Load> loads;         // one for each of coordinates_of(type)
};

/// "rigid parent, flexible child, tree against the joint; coordinate 2 driven".
std::string describe(const Arrangement& arrangement);

class Rig {
 public:
  static constexpr int kHolder = 0;  // joints
  static constexpr int kTested = 1;
  static constexpr int kCloser = 2;

  /// The type must outlive the rig.
  Rig(const JointType& type, const Arrangement& arrangement, std::uint32_t seed);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// The joint under test in the tree.
  [[nodiscard]] const Model& open() const { return open_; }
  /// The same with a second free joint, from ground to the outer body: a loop, cut at the joint under test. A free
  /// joint carries nothing, so the physics is that of the open rig.
  [[nodiscard]] const Model& idle_loop() const { return idle_loop_; }
  /// The outer body held to ground by a ball instead: a loop that loads the joint under test, cut at it, or at the ball
  /// so that the joint under test stands in the tree.
  [[nodiscard]] const Model& loop_cut_at_tested() const { return loop_cut_at_tested_; }
  [[nodiscard]] const Model& loop_cut_at_ball() const { return loop_cut_at_ball_; }

  /// A closed state of the open rig at pose `number` of the seed, driven coordinates on their laws; made by the
  /// relative solver's kinematics.
  State state(int number);
  /// The same with the joint under test at q and the rest as at pose 0.
  State state_at(const VecX& q);

  /// A state of the open rig as one of the idle loop: the joint that closes it gets no hint but "unmoved".
  static State in_idle_loop(State state);
  /// A state of the open rig moved as a whole to where the ball is in its socket.
  [[nodiscard]] State in_loop(State state) const;

  /// Weight of both bodies [N]: what the joint may be expected to carry, at least.
  [[nodiscard]] double weight() const;

 private:
  [[nodiscard]] int parent() const { return arrangement_.tree_runs_against ? 2 : 1; }
  [[nodiscard]] int child() const { return 3 - parent(); }
  Model build_open(Numbers& numbers) const;
  Joint build_tested(const Model& model, Numbers& numbers) const;
  void load(Joint& tested, const Coordinate& coordinate, Load how, Numbers& numbers) const;
  void keep_possible_speeds(Joint& tested) const;
  void close_loops(Numbers& numbers);
  State write_state(double t, const VecX& q, const VecX& u, Numbers& numbers);
  [[nodiscard]] VecX on_laws(double t, VecX q) const;
  [[nodiscard]] std::vector<SpeedValue> speeds_on_laws(double t) const;
  [[nodiscard]] bool can_follow_laws(double t, const VecX& q) const;

  const JointType& type_;
  Arrangement arrangement_;
  std::uint32_t seed_;
  PoseSource poses_;
  Model open_;
  Model idle_loop_;
  Model loop_cut_at_tested_;
  Model loop_cut_at_ball_;
  std::unique_ptr<relative::Equations> equations_;
  std::unique_ptr<relative::States> states_;
};

}  // namespace concord::compare::joint_check
