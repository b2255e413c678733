#include "compare/equilibrium/floating_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "compare/audit/free_body.h"

namespace concord::compare {

namespace {

Eigen::Quaterniond quaternion_of(const Vec4& p) { return {p(0), p(1), p(2), p(3)}; }

void turn_by(const Eigen::Quaterniond& turn, BodyState& body) {
  const Eigen::Quaterniond turned = turn * quaternion_of(body.p);
  body.p << turned.w(), turned.vec();
}

/// From one orientation to another, global axes.
Eigen::Quaterniond turn_between(const BodyState& from, const BodyState& to) {
  return (quaternion_of(to.p) * quaternion_of(from.p).conjugate()).normalized();
}

/// For each body the first of those that joints hold together with it.
std::vector<std::size_t> first_of_parts(const Model& model) {
  std::vector<std::size_t> first(model.bodies.size());
  std::iota(first.begin(), first.end(), std::size_t{0});
  for (const Joint& joint : model.joints) {
    if (joint.type->n_u() == 6) continue;
    const std::size_t one = first[static_cast<std::size_t>(joint.sides[0].body)];
    const std::size_t other = first[static_cast<std::size_t>(joint.sides[1].body)];
    std::replace(first.begin(), first.end(), std::max(one, other), std::min(one, other));
  }
  return first;
}

}  // namespace

VecX displacement(const State& from, const State& to) {
  Eigen::Index rows = 0;
  for (std::size_t i = 1; i < from.bodies.size(); ++i) rows += 6 + from.bodies[i].a.size();
  VecX moved(rows);
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < from.bodies.size(); ++i) {
    const Eigen::AngleAxisd turn(turn_between(from.bodies[i], to.bodies[i]));
    moved.segment<3>(row) = to.bodies[i].r - from.bodies[i].r;
    moved.segment<3>(row + 3) = turn.angle() * turn.axis();
    moved.segment(row + 6, from.bodies[i].a.size()) = to.bodies[i].a - from.bodies[i].a;
    row += 6 + from.bodies[i].a.size();
  }
  return moved;
}

FloatingParts::FloatingParts(const Model& model) {
  const std::vector<std::size_t> first = first_of_parts(model);
  std::map<std::size_t, Part> parts;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (first[i] == 0) continue;
    Part& part = parts[first[i]];
    part.bodies.push_back(i);
    if (part.heaviest == 0 || mass_of(model.bodies[i]) > mass_of(model.bodies[part.heaviest])) part.heaviest = i;
  }
  std::map<std::size_t, int> n_free_joints;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (model.joints[k].type->n_u() != 6) continue;
    const auto& [parent, child] = model.joints[k].sides;
    const bool is_to_ground = parent.body == kGround || child.body == kGround;
    for (const auto body : {static_cast<std::size_t>(parent.body), static_cast<std::size_t>(child.body)}) {
      const auto part = parts.find(first[body]);
      if (part == parts.end()) continue;
      const bool is_alone = ++n_free_joints[first[body]] == 1 && is_to_ground;
      part->second.free_joint = is_alone ? std::optional(FreeJoint{k, body}) : std::nullopt;
    }
  }
  for (auto& [body, part] : parts) parts_.push_back(std::move(part));
}

void FloatingParts::turn_back(const State& origin, State& state, Evaluation& evaluation) const {
  for (const Part& part : parts_) {
    const Eigen::Quaterniond back = turn_between(state.bodies[part.heaviest], origin.bodies[part.heaviest]);
    for (const std::size_t i : part.bodies) {
      turn_by(back, state.bodies[i]);
      evaluation.bodies[i].vdot = back * evaluation.bodies[i].vdot;
      evaluation.bodies[i].omegadot = back * evaluation.bodies[i].omegadot;
    }
  }
}

std::optional<State> FloatingParts::put_back(const State& start, const State& here) const {
  State moved = here;
  bool moves = false;
  for (const Part& part : parts_) {
    if (!part.free_joint) continue;
    const auto [joint, held] = *part.free_joint;
    moves = true;
    const BodyState& from = here.bodies[held];
    const BodyState& to = start.bodies[held];
    const Eigen::Quaterniond turn = turn_between(from, to);
    for (const std::size_t i : part.bodies) {
      moved.bodies[i].r = to.r + turn * (here.bodies[i].r - from.r);
      turn_by(turn, moved.bodies[i]);
    }
    moved.q[joint] = start.q[joint];
  }
  return moves ? std::optional(std::move(moved)) : std::nullopt;
}

}  // namespace concord::compare
