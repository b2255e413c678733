#include "compare/states/motion_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/states/modal_sizes.h"

namespace concord::compare {

namespace {

/// Parts of a motion smaller than this, relative to all of it, are round-off.
constexpr double kTakesNoPart = 1e-6;

/// What a motion has of a joint speed, a body's velocity or a mode's rate, in scaled units, and its name.
struct Part {
  std::string name;
  double size;
};

std::vector<Part> joint_parts(const Model& model, const State& state, double length) {
  std::vector<Part> parts;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const VecX hint = k < state.q.size() ? state.q[k] : VecX();
    const VecX u = read_motion(*joint.type, relative_motion_of(joint, state), hint).u;
    const std::vector<std::string> names = speed_names(*joint.type);
    const std::vector<bool> turns = turning_speeds(*joint.type);
    for (std::size_t c = 0; c < names.size(); ++c) {
      const double size = u(static_cast<Eigen::Index>(c)) / (turns[c] ? 1.0 : length);
      parts.push_back({fmt::format("{} of {}", names[c], joint.name), size});
    }
  }
  return parts;
}

std::vector<Part> body_parts(const Model& model, const State& state, double length) {
  std::vector<Part> parts;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyState& body = state.bodies[i];
    const VecX sizes = modal_sizes(model, i);
    parts.push_back({fmt::format("motion of body {}", model.bodies[i].name), body.v.norm() / length});
    parts.push_back({fmt::format("rotation of body {}", model.bodies[i].name), body.omega.norm()});
    for (Eigen::Index mode = 0; mode < body.adot.size(); ++mode) {
      parts.push_back(
          {fmt::format("mode {} of body {}", mode + 1, model.bodies[i].name), body.adot(mode) * sizes(mode)});
    }
  }
  return parts;
}

/// The three largest parts, as far as they are a tenth of the largest; empty if none is above `least`.
std::string largest_parts(std::vector<Part> parts, double least) {
  for (Part& part : parts) part.size = std::abs(part.size);
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.size > b.size; });
  if (parts.empty() || !(parts.front().size > least)) return "";
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, parts.size()); ++k) {
    if (parts[k].size < 0.1 * parts.front().size) break;
    text += (k == 0 ? "" : ", ") + parts[k].name;
  }
  return text;
}

/// The state with velocities [v; omega; adot] of bodies 1, 2, ...
State moving_with(const Model& model, const State& state, const VecX& velocities) {
  State moving = state;
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    BodyState& body = moving.bodies[i];
    body.v = velocities.segment<3>(row);
    body.omega = velocities.segment<3>(row + 3);
    body.adot = velocities.segment(row + 6, body.a.size());
    row += 6 + body.a.size();
  }
  return moving;
}

}  // namespace

std::string describe_motion(const Model& model, const State& state, const VecX& velocities) {
  const State moving = moving_with(model, state, velocities);
  const double length = model.length_scale();
  const std::vector<Part> of_bodies = body_parts(model, moving, length);
  double largest = 0.0;
  for (const Part& part : of_bodies) largest = std::max(largest, std::abs(part.size));
  std::string words = largest_parts(joint_parts(model, moving, length), kTakesNoPart * largest);
  if (words.empty()) words = largest_parts(of_bodies, 0.0);
  return words.empty() ? "nothing" : words;
}

MatX separate_motions(const Model& model, const State& state, MatX motions) {
  const Eigen::Index n = motions.cols();
  MatX speeds(0, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::vector<Part> parts = joint_parts(model, moving_with(model, state, motions.col(k)), model.length_scale());
    if (k == 0) speeds.resize(static_cast<Eigen::Index>(parts.size()), n);
    for (std::size_t row = 0; row < parts.size(); ++row) speeds(static_cast<Eigen::Index>(row), k) = parts[row].size;
  }
  if (speeds.rows() == 0) return motions;
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index row = 0;
    Eigen::Index column = 0;
    const double largest = speeds.rightCols(n - k).cwiseAbs().maxCoeff(&row, &column);
    if (!(largest > kTakesNoPart)) break;
    column += k;
    speeds.col(k).swap(speeds.col(column));
    motions.col(k).swap(motions.col(column));
    motions.col(k) /= speeds(row, k);
    speeds.col(k) /= speeds(row, k);
    for (Eigen::Index other = 0; other < n; ++other) {
      if (other == k) continue;
      motions.col(other) -= speeds(row, other) * motions.col(k);
      speeds.col(other) -= speeds(row, other) * speeds.col(k);
    }
  }
  return motions;
}

}  // namespace concord::compare
