#pragma once

#include <memory>
#include <optional>

#include "tests/benchmarks/machines.h"

namespace concord::benchmarks {

/// One program's way from positions and velocities to all accelerations and the reactions of all joints on both sides,
/// again and again in the state of a machine, which must outlive it.
class Evaluator {
 public:
  virtual ~Evaluator() = default;
  virtual void evaluate() = 0;
  /// Of the last evaluation: the reaction of joint k on its child at the joint's point, in global axes; nothing where
  /// the program does not tell it.
  [[nodiscard]] virtual std::optional<Wrench> reaction(std::size_t k) const = 0;
};

std::unique_ptr<Evaluator> make_cartesian(const Machine& machine);
std::unique_ptr<Evaluator> make_relative(const Machine& machine);
#ifdef CONCORD_HAS_SIMBODY
/// A machine of rigid bodies, revolute, spherical and universal joints, and gravity alone, each joint stated after the
/// one that carries its parent. Reactions on the child's side only, and none of joints that close loops.
std::unique_ptr<Evaluator> make_simbody(const Machine& machine);
#endif

/// Matching digits of the reactions that both tell: the largest difference over the largest reaction, over all joints;
/// at most 16.
double matching_digits(const Machine& machine, const Evaluator& one, const Evaluator& other);

}  // namespace concord::benchmarks
