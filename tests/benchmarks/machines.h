#pragma once

#include <filesystem>
#include <string>

#include "common/joints/joint_type.h"
#include "common/model.h"
#include "common/results.h"

namespace concord::benchmarks {

/// A machine in one general closed state: every joint frame tilted on either side, points off all axes, unequal
/// inertias. The same in every run.
struct Machine {
  Model model;
  State state;

  [[nodiscard]] int bodies() const { return static_cast<int>(model.bodies.size()) - 1; }
};

/// Bodies that hang from ground by revolute or spherical joints: n in a chain; in a tree body k from body k / 2.
Machine make_chain(int n, const joints::JointType& type);
Machine make_tree(int n);

/// Cranks on ground, each tied to the next by a rod with a spherical and a universal joint: n loops, of which those
/// that share a crank couple; no constraint is redundant.
Machine make_ladder(int n);

/// A model file at its start: at the equilibrium, if it says so.
Machine read_machine(const std::filesystem::path& file);

}  // namespace concord::benchmarks
