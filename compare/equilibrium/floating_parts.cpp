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

FloatingParts::FloatingParts(const Model& model) {
  const std::vector<std::size_t> first = first_of_parts(model);
  std::map<std::size_t, Part> parts;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (first[i] == 0) continue;
    Part& part = parts[first[i]];
    part.bodies.push_back(i);
    if (part.heaviest == 0 || mass_of(model.bodies[i]) > mass_of(model.bodies[part.heaviest])) part.heaviest = i;
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const auto& [parent, child] = model.joints[k].sides;
    if (model.joints[k].type->n_u() != 6 || (parent.body != kGround && child.body != kGround)) continue;
    const auto held = static_cast<std::size_t>(std::max(parent.body, child.body));
    const auto found = parts.find(first[held]);
    if (found == parts.end()) continue;
    found->second.joint = k;
    found->second.held = held;
  }
  for (auto& [body, part] : parts) parts_.push_back(std::move(part));
}

void FloatingParts::turn_back(const State& origin, State& state, Evaluation& evaluation) const {
  for (const Part& part : parts_) {
    const Eigen::Quaterniond back =
        quaternion_of(origin.bodies[part.heaviest].p) * quaternion_of(state.bodies[part.heaviest].p).conjugate();
    for (const std::size_t i : part.bodies) {
      const Eigen::Quaterniond turned = back * quaternion_of(state.bodies[i].p);
      state.bodies[i].p << turned.w(), turned.vec();
      evaluation.bodies[i].vdot = back * evaluation.bodies[i].vdot;
      evaluation.bodies[i].omegadot = back * evaluation.bodies[i].omegadot;
    }
  }
}

std::optional<State> FloatingParts::put_back(const State& start, const State& here) const {
  State moved = here;
  bool moves = false;
  for (const Part& part : parts_) {
    if (!part.joint) continue;
    moves = true;
    const BodyState& from = here.bodies[part.held];
    const BodyState& to = start.bodies[part.held];
    const Eigen::Quaterniond turn = (quaternion_of(to.p) * quaternion_of(from.p).conjugate()).normalized();
    for (const std::size_t i : part.bodies) {
      BodyState& body = moved.bodies[i];
      const Eigen::Quaterniond turned = turn * quaternion_of(body.p);
      body.r = to.r + turn * (here.bodies[i].r - from.r);
      body.p << turned.w(), turned.vec();
    }
    moved.q[*part.joint] = start.q[*part.joint];
  }
  return moves ? std::optional(std::move(moved)) : std::nullopt;
}

}  // namespace concord::compare
