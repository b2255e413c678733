#include "compare/states/start_report.h"

#include <algorithm>
#include <cmath>

#include "common/joints/facts.h"
#include "common/joints/named_coordinates.h"
#include "compare/audit/places.h"
#include "compare/states/branch.h"

namespace concord::compare {

namespace {

Said said_of(const Model& given, const Joint& joint, const NamedCoordinate& at) {
  if (driver_of(joint, at.word, at.component) != nullptr) return Said::law;
  switch (joint.start[static_cast<std::size_t>(at.word)].role_q) {
    case StartRole::keep:
      return given.run.from_equilibrium ? Said::guess : Said::keep;
    case StartRole::guess:
      return Said::guess;
    case StartRole::unsaid:
      break;
  }
  return Said::nothing;
}

/// A ball, whose numbers are shown as a rotation vector.
void take_orientation(const Vec4& got, const Vec4& guess, StartCoordinate& coordinate) {
  coordinate.value = rotation_vector_of(rotation_of(got.normalized()));
  if (coordinate.said != Said::guess) return;
  const Mat3 guessed = rotation_of(guess.normalized());
  coordinate.guess = rotation_vector_of(guessed);
  coordinate.moved = rotation_vector_of(rotation_of(got.normalized()) * guessed.transpose()).norm();
  coordinate.size = coordinate.moved;
}

StartCoordinate coordinate_at(const Model& given, std::size_t k, const NamedCoordinate& at, const State& start) {
  const Joint& joint = given.joints[k];
  const int q = first_q(*joint.type, at.word) + at.component;
  const VecX& stated = joint.start[static_cast<std::size_t>(at.word)].q;
  StartCoordinate coordinate{static_cast<int>(k), at.name, at.kind, said_of(given, joint, at), {}, {}, 0.0, 0.0};
  if (at.kind == joints::CoordinateKind::orientation) {
    take_orientation(start.q[k].segment<4>(q), stated.segment<4>(at.component), coordinate);
    return coordinate;
  }
  coordinate.value = start.q[k].segment<1>(q);
  const double off = std::abs(coordinate.value(0) - stated(at.component));
  const bool is_met = off <= kWrittenExactly * std::max(1.0, std::abs(stated(at.component)));
  if (coordinate.said == Said::keep && !is_met) coordinate.guess = stated.segment<1>(at.component);
  if (coordinate.said != Said::guess) return coordinate;
  coordinate.guess = stated.segment<1>(at.component);
  const double from = coordinate.guess(0);
  const double got = coordinate.value(0);
  const bool is_one_pose = whole_turns_change_nothing(given, k, at.word, at.component);
  coordinate.moved = (is_one_pose ? with_turns_of(from, got) : got) - from;
  const double unit = at.kind == joints::CoordinateKind::length ? given.length_scale() : 1.0;
  coordinate.size = std::abs(coordinate.moved) / unit;
  return coordinate;
}

}  // namespace

StartReport report_start(const Model& given, const State& start) {
  StartReport report;
  for (std::size_t k = 0; k < given.joints.size(); ++k) {
    for (const NamedCoordinate& at : named_coordinates(*given.joints[k].type)) {
      report.coordinates.push_back(coordinate_at(given, k, at, start));
    }
  }
  const double length = given.length_scale();
  for (std::size_t i = 1; i < given.bodies.size(); ++i) {
    if (!given.bodies[i].pose_guess) continue;
    const Pose& guess = *given.bodies[i].pose_guess;
    const BodyState& got = start.bodies[i];
    const MovedBody moved{static_cast<int>(i), (got.r - guess.r).norm(),
                          rotation_vector_of(rotation_of(got.p) * guess.A.transpose()).norm()};
    if (moved.apart > kNoticed * length || moved.turned > kNoticed) report.bodies.push_back(moved);
  }
  return report;
}

void add_other_pose(const Model& given, const State& found, StartReport& report) {
  const StartReport other = report_start(given, found);
  std::vector<VecX>& values = report.others.values.emplace_back();
  std::size_t next = 0;
  for (std::size_t k = 0; k < given.joints.size(); ++k) {
    for (const NamedCoordinate& at : named_coordinates(*given.joints[k].type)) {
      VecX& value = values.emplace_back(other.coordinates[next].value);
      if (whole_turns_change_nothing(given, k, at.word, at.component)) {
        value(0) = with_turns_of(report.coordinates[next].value(0), value(0));
      }
      ++next;
    }
  }
}

}  // namespace concord::compare
