#pragma once

#include <memory>

#include "tests/benchmarks/chain.h"

namespace concord::benchmarks {

/// The same chain in Simbody, at the same state: an opinion from outside and a yardstick of speed.
class SimbodyChain {
 public:
  explicit SimbodyChain(const Chain& chain);
  ~SimbodyChain();
  SimbodyChain(const SimbodyChain&) = delete;
  SimbodyChain& operator=(const SimbodyChain&) = delete;

  /// Accelerations and all mobilizer reactions, from positions on.
  void evaluate();

  /// Of the last evaluation: angular acceleration of joint k [rad/s2], and its reaction on the child at the joint
  /// point, global axes.
  [[nodiscard]] double acceleration(int joint) const;
  [[nodiscard]] Wrench reaction(int joint) const;

 private:
  struct Machine;
  std::unique_ptr<Machine> machine_;
};

}  // namespace concord::benchmarks
