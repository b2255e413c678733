#pragma once

#include "common/model.h"
#include "common/results.h"

namespace concord::benchmarks {

/// A chain of revolute joints hanging from ground, every joint frame tilted on either side, points off all axes,
/// unequal inertias, and one general state of it.
struct Chain {
  Model model;
  VecX angles;  // rad, of joint k
  VecX speeds;  // rad/s
  State state;
};

/// The chain of n bodies; body k + 1 hangs from body k by joint k. The same in every run.
Chain make_chain(int n);

}  // namespace concord::benchmarks
