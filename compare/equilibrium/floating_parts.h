#pragma once

#include <optional>
#include <vector>

#include "common/model.h"
#include "common/results.h"

namespace concord::compare {

/// How bodies 1, 2, ... have moved from one state to another, in the rows of velocities: [displacement of the origin;
/// rotation vector, global axes; change of modal coordinates].
VecX displacement(const State& from, const State& to);

/// Parts of a machine that no joint holds to the ground. As such a part turns as a whole, the forces within it turn
/// with it; in global axes this looks like a stiffness as large as they are, against which a search for an equilibrium
/// would turn the part instead of moving its joints.
class FloatingParts {
 public:
  explicit FloatingParts(const Model& model);

  /// Turns each part back, with its accelerations, as far as its heaviest body has turned since `origin`. What rests
  /// stays at rest; positions and reactions are left alone.
  void turn_back(const State& origin, State& state, Evaluation& evaluation) const;

  /// `here` with each part moved as a whole so far that the joint which leaves it free stands as in `start`, if there
  /// is one such joint alone, and to the ground; nothing without such parts. Where nothing but the part's own forces
  /// acts on it, it rests there too.
  [[nodiscard]] std::optional<State> put_back(const State& start, const State& here) const;

 private:
  /// A joint to the ground, and the part's body there.
  struct FreeJoint {
    std::size_t joint;
    std::size_t body;
  };
  struct Part {
    std::vector<std::size_t> bodies;
    std::size_t heaviest = 0;
    std::optional<FreeJoint> free_joint;
  };
  std::vector<Part> parts_;
};

}  // namespace concord::compare
