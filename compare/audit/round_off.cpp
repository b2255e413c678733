#include "compare/audit/round_off.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "compare/audit/audit_ledger.h"
#include "compare/audit/machine_size.h"

namespace concord::compare {

namespace {

constexpr double kUnits = 4.0 * std::numeric_limits<double>::epsilon();

/// Two draws; for the opposite number of units the opposite ones.
std::array<State, 2> moved_by(const State& state, double length, double units) {
  const double place = size_of_places(state, length);
  const double speed = size_of_speeds(state, length);
  std::array<State, 2> moved{state, state};
  std::uint32_t signs = 1;
  const auto move = [&](auto& values, double size) {
    for (double& one : values) {
      signs = signs * 1664525U + 1013904223U;
      one += ((signs >> 31U) != 0U ? units : -units) * size;
    }
  };
  for (State& one : moved) {
    for (std::size_t i = 1; i < one.bodies.size(); ++i) {
      move(one.bodies[i].r, place);
      move(one.bodies[i].p, 1.0);
      move(one.bodies[i].v, speed);
      move(one.bodies[i].omega, speed / length);
    }
  }
  return moved;
}

}  // namespace

std::array<State, 2> within_roundoff(const State& state, double length) { return moved_by(state, length, kUnits); }

std::array<State, 4> about_a_jump(const State& state, double length) {
  constexpr double kFarther = 16.0 * kUnits;
  auto [one, other] = moved_by(state, length, kFarther);
  auto [opposite, other_opposite] = moved_by(state, length, -kFarther);
  return {std::move(one), std::move(other), std::move(opposite), std::move(other_opposite)};
}

VecX beyond_roundoff(const VecX& residuals, const VecX& roundoff) {
  constexpr double kTimes = 4.0;
  return (residuals.cwiseAbs() - kTimes * roundoff).cwiseMax(0.0);
}

bool is_suspicious(const Balance& balance) {
  const double least = std::pow(10.0, -kAudit);
  return !((balance.rows.cwiseAbs() - least * balance.scales).maxCoeff() <= 0.0);
}

VecX OwnRoundOff::unexplained(const Balance& balance,
                              const std::function<VecX(const State&, const Evaluation&)>& again) {
  constexpr int kDraws = 5;
  constexpr double kWithinRoundOff = 20.0;
  constexpr double kCoarsest = 1e-6;
  if (!drawn_) {
    drawn_.emplace();
    for (int k = 0; redraw_ && k < kDraws; ++k) {
      if (auto answer = redraw_(state_, k)) drawn_->push_back(std::move(*answer));
    }
  }
  VecX changes = VecX::Zero(balance.rows.size());
  for (const auto& [moved, of_moved] : *drawn_) {
    changes = changes.cwiseMax((again(moved, of_moved) - balance.rows).cwiseAbs());
  }
  const VecX explained = (kWithinRoundOff * changes).cwiseMin(kCoarsest * balance.scales);
  return (balance.rows.array().abs() <= explained.array()).select(0.0, balance.rows);
}

}  // namespace concord::compare
