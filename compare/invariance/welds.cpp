#include "compare/invariance/welds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/decompositions.h"
#include "common/joints/weld.h"
#include "common/overloaded.h"
#include "compare/audit/places.h"
#include "compare/invariance/frames.h"

namespace concord::compare::invariance {

namespace {

/// One end of a joint or of a force element: number in the model, side.
struct EndOf {
  bool of_joint = true;
  std::size_t number = 0;
  Side side = Side::child;
};

/// A new body: the body that it was a part of, its frame there, the weld, and the ends that it takes along.
struct Part {
  int of = kGround;
  Pose frame;
  double share = 0.5;     // of the mass of what is left of the body
  Pose weld;              // in the body's frame
  bool reversed = false;  // the weld's parent is the part
  std::vector<EndOf> ends;
  std::string name;
};

Attachment& end_in(Model& model, const EndOf& end) {
  if (end.of_joint) return model.joints[end.number].sides[static_cast<std::size_t>(index(end.side))];
  const auto ends = ends_of(model.elements[end.number]);
  return end.side == Side::child ? ends.back() : ends.front();
}

/// Takes a share of a body's mass away, and gives it as a body in the same frame. Their centres of mass lie apart along
/// the direction in which the body is longest, so far that both are bodies that could be.
Body take_share(Body& body, double share) {
  constexpr double kOfExtent = 0.5;
  Body part = body;
  part.mass = share * body.mass;
  const Mat3 second = 0.5 * body.inertia_L.trace() * Mat3::Identity() - body.inertia_L;  // integral of x x^T
  const SymmetricEigenpairs extents = symmetric_eigenpairs(second);
  const double both = share * (1.0 - share) * body.mass;
  const double longest = std::max(0.0, extents.values(2));
  const Vec3 apart = (both > 0.0 ? kOfExtent * std::sqrt(longest / both) : 0.0) * extents.vectors.col(2);
  const Mat3 own = body.inertia_L - both * (apart.squaredNorm() * Mat3::Identity() - apart * apart.transpose());
  part.center_of_mass_L = body.center_of_mass_L + (1.0 - share) * apart;
  part.inertia_L = share * own;
  body.center_of_mass_L -= share * apart;
  body.inertia_L = (1.0 - share) * own;
  body.mass -= part.mass;
  return part;
}

/// A body of its own that is welded to ground.
Body block_on_ground(const Model& model) {
  const double length = model.length_scale();
  Body block;
  for (const Body& body : model.bodies) block.mass = std::max(block.mass, body.modal ? body.modal->G(0, 0) : body.mass);
  block.inertia_L = 0.01 * block.mass * length * length * Vec3(1.0, 1.3, 0.9).asDiagonal().toDenseMatrix();
  block.a_start = block.adot_start = VecX(0);
  return block;
}

void move_ends(Model& model, const Part& part, int body) {
  for (const EndOf& end : part.ends) {
    Attachment& at = end_in(model, end);
    at = with_frame(std::move(at), part.frame);
    at.body = body;
    if (end.of_joint) continue;
    auto* load = std::get_if<Load>(&model.elements[end.number].what);
    if (load == nullptr || load->axes != LoadAxes::body) continue;
    load->force = part.frame.A.transpose() * load->force;
    load->torque = part.frame.A.transpose() * load->torque;
  }
}

Joint weld_of(const Part& part, int body) {
  Joint weld;
  weld.name = part.name;
  weld.type = &joints::weld;
  const Attachment on_whole{part.of, part.weld.r, part.weld.A, Mat3X(3, 0), Mat3X(3, 0)};
  Attachment on_part = with_frame(on_whole, part.frame);
  on_part.body = body;
  weld.sides = {on_whole, on_part};
  if (part.reversed) std::swap(weld.sides[0], weld.sides[1]);
  return weld;
}

Model model_in_parts(Model model, const std::vector<Part>& parts) {
  const Body block = block_on_ground(model);
  for (const Part& part : parts) {
    const auto whole = static_cast<std::size_t>(part.of);
    Body taken = part.of == kGround ? block : with_frame(take_share(model.bodies[whole], part.share), part.frame);
    if (part.of == kGround) taken.pose_guess = part.frame;
    taken.name = part.name;
    const auto body = static_cast<int>(model.bodies.size());
    move_ends(model, part, body);
    model.bodies.push_back(std::move(taken));
    model.joints.push_back(weld_of(part, body));
  }
  return model;
}

State state_in_parts(State state, const std::vector<Part>& parts) {
  for (const Part& part : parts) {
    BodyState body = moved_motion(state.bodies[static_cast<std::size_t>(part.of)], part.frame);
    body.a = body.adot = VecX(0);
    state.bodies.push_back(std::move(body));
    state.q.emplace_back(0);
    state.u.emplace_back(0);
  }
  return state;
}

Change in_parts(const Model& model, std::vector<Part> list) {
  const auto parts = std::make_shared<const std::vector<Part>>(std::move(list));
  const std::size_t bodies = model.bodies.size();
  const std::size_t joints = model.joints.size();
  Change change;
  change.model = [parts](Model first) { return model_in_parts(std::move(first), *parts); };
  change.state = [parts](State state) { return state_in_parts(std::move(state), *parts); };
  change.back = [bodies, joints](State state) {
    state.bodies.resize(bodies);
    state.q.resize(joints);
    state.u.resize(joints);
    return state;
  };
  change.evaluation = [bodies, joints](const State&, Evaluation evaluation) {
    evaluation.bodies.resize(bodies);
    evaluation.joints.resize(joints);
    return evaluation;
  };
  change.report = [joints](RankReport report) {
    report.joints.resize(joints);
    if (!report.decided.empty()) report.decided.resize(joints);
    return report;
  };
  return change;
}

bool may_be_parted(const Model& model, int body) {
  return body == kGround || !model.bodies[static_cast<std::size_t>(body)].modal;
}

Part part_of(const Model& model, int body, Draw& draw) {
  const double length = model.length_scale();
  Part part;
  part.of = body;
  part.frame = draw.pose(0.3 * length);
  part.weld = draw.pose(0.3 * length);
  return part;
}

/// Ends on each body, in the order of joints and then of force elements.
std::vector<std::vector<EndOf>> ends_on_bodies(Model model) {
  std::vector<std::vector<EndOf>> ends(model.bodies.size());
  const auto take = [&](const EndOf& end) { ends[static_cast<std::size_t>(end_in(model, end).body)].push_back(end); };
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) take({true, k, side});
  }
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    for (const Side side : kSides) {
      if (end_of(model.elements[e], side) != nullptr) take({false, e, side});
    }
  }
  return ends;
}

}  // namespace

PartialChange with_welds(const Model& model, Draw& draw) {
  PartialChange partial;
  std::vector<Part> parts;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const Side first = k % 2 == 0 ? Side::child : Side::parent;
    const Side other = first == Side::child ? Side::parent : Side::child;
    const bool takes_first = may_be_parted(model, joint.on(first).body);
    if (!takes_first && !may_be_parted(model, joint.on(other).body)) {
      partial.left.push_back(fmt::format("joint {}: between flexible bodies", joint.name));
      continue;
    }
    const Side side = takes_first ? first : other;
    Part part = part_of(model, joint.on(side).body, draw);
    part.share = 0.2;
    part.reversed = k % 4 >= 2;
    part.ends = {{true, k, side}};
    part.name = fmt::format("weld at {}", joint.name);
    parts.push_back(std::move(part));
    ++partial.changed;
  }
  partial.change = in_parts(model, std::move(parts));
  return partial;
}

PartialChange split_bodies(const Model& model, Draw& draw) {
  PartialChange partial;
  std::vector<Part> parts;
  const std::vector<std::vector<EndOf>> ends = ends_on_bodies(model);
  for (int body = 1; body < static_cast<int>(model.bodies.size()); ++body) {
    const auto i = static_cast<std::size_t>(body);
    if (!may_be_parted(model, body)) {
      partial.left.push_back(fmt::format("body {}: flexible", model.bodies[i].name));
      continue;
    }
    Part part = part_of(model, body, draw);
    part.share = 0.4;
    part.reversed = body % 2 == 0;
    for (std::size_t k = 1; k < ends[i].size(); k += 2) part.ends.push_back(ends[i][k]);
    part.name = fmt::format("part of {}", model.bodies[i].name);
    parts.push_back(std::move(part));
    ++partial.changed;
  }
  partial.change = in_parts(model, std::move(parts));
  return partial;
}

}  // namespace concord::compare::invariance
