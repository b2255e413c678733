#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/solver.h"

/// Which forces make a machine move as asked?
namespace concord::compare::analyses {

/// A joint coordinate whose acceleration is prescribed at the start.
struct Prescribed {
  int joint = 0;
  int word = 0;
  int component = 0;
  double acceleration = 0.0;  // m/s2 or rad/s2

  /// The joint speed of it.
  [[nodiscard]] int speed(const Model& model) const;
  /// "turn_z of hinge".
  [[nodiscard]] std::string name(const Model& model) const;
};

/// "turn_z of hinge" has this acceleration.
struct AskedAcceleration {
  std::string joint;
  std::string coordinate;
  double value = 0.0;
  SourceLocation where{"--acceleration", 0, 0};  // who asks for it
};

/// The coordinates that the model keeps at its start, each with the acceleration asked for, else zero. Throws
/// InputError if one that is asked for is not kept, if a ball is kept (no driver can hold it), or if none is.
std::vector<Prescribed> prescribed_coordinates(const Model& model, const std::vector<AskedAcceleration>& asked);

/// The model whose prescribed coordinates are driven through their values and speeds in `state` (at time 0) with their
/// accelerations: force_to_apply() of it is the answer. Where it keeps the speed of one coordinate and the place of
/// another, the driver decides that place too: as many kept coordinates become guesses, the first ones without which
/// `starts` says that the machine still starts (where there are none, the model as it was).
Model driven_through(const Model& model, const State& state, const std::vector<Prescribed>& coordinates,
                     const std::function<bool(const Model&)>& starts);

/// What a motor must exert on a prescribed coordinate so that it moves as asked, its springs, dampers and motors
/// replaced by it [N, N m]: tau without what couplings exert, which go on to act. `evaluation`: of the driven model.
double force_to_apply(const Model& model, const Evaluation& evaluation, const Prescribed& one);

/// The model in which actuators exert these forces on the prescribed coordinates in place of springs and motors: it
/// must accelerate as was asked. `evaluation`: of the driven one.
Model actuated_by(const Model& model, const Evaluation& evaluation, const std::vector<Prescribed>& coordinates);

}  // namespace concord::compare::analyses
