#include "compare/invariance/moves.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "compare/invariance/draw.h"
#include "compare/invariance/frames.h"
#include "compare/invariance/joint_frames.h"
#include "compare/invariance/modes.h"
#include "compare/invariance/order.h"
#include "compare/invariance/sides.h"
#include "compare/invariance/units.h"
#include "compare/invariance/welds.h"

namespace concord::compare::invariance {

namespace {

/// Of the machine's length: how far frames of bodies, and the world, are moved.
constexpr double kMoveOfFrames = 0.2;
constexpr double kMoveOfWorld = 0.5;
/// A move, of the machine's length or in radians, that rounds every number anew and hides nothing else.
constexpr double kNearby = 1e-9;

/// A regular matrix without zeros. Modal stiffnesses may span decades: the more a soft mode takes of a stiff one, the
/// more digits of its own stiffness drown in the data (entries of size 0.4 on the shipped rod: one unit in the last
/// place of K moves the reactions of either solver by 1e-10 of their scale).
MatX regular(Draw& draw, int n) {
  MatX T(n, n);
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) T(row, column) = draw.one(0.05);
    T(row, row) = (row % 2 == 0 ? 1.0 : -1.0) * (1.4 + draw.one(0.6));
  }
  return T;
}

Move move_of_cuts(const Model& model) {
  Move move{"cut", "another joint of a loop is cut", {}, "", {}, true};
  for (const std::size_t joint : joints_in_loops(model)) {
    move.variants.push_back({model.joints[joint].name + " is cut", cut_at(joint)});
  }
  if (move.variants.empty()) move.why_not = "no joint lies in a loop";
  return move;
}

Move move_of(std::string name, std::string about, PartialChange partial, const char* nothing) {
  Move move{std::move(name), std::move(about), {}, "", std::move(partial.left), false};
  if (partial.changed > 0) {
    move.variants.push_back({"", std::move(partial.change)});
  } else {
    move.why_not = nothing;
  }
  return move;
}

Move move_of_world(const Model& model, std::uint64_t seed) {
  Move move{"world", "the world is turned and moved", {{"", moved_world(model, seed)}}, "", {}, false};
  const WorldFreedom freedom = freedom_of_world(model);
  if (freedom.turns) return move;
  move.left.emplace_back("directions: tires stand on a road, whose height is along z");
  if (!freedom.turns_about_vertical) move.left.emplace_back("turns about z: the road's height depends on x");
  if (!freedom.rises) move.left.emplace_back("heights: a bump stands on z = 0");
  return move;
}

Move move_of_modes(const Model& model, std::uint64_t seed) {
  Move move{"modes", "the modes of flexible bodies are combined anew", {}, "", {}, false};
  if (model.is_flexible()) {
    move.variants.push_back({"", recombined(model, seed)});
  } else {
    move.why_not = "no body is flexible";
  }
  return move;
}

Move move_of_units(const Model& model) {
  Move move{"units", "millimetres, tonnes and seconds instead of SI units", {}, "", {}, false};
  if (const auto reason = why_no_other_units(model)) {
    move.why_not = *reason;
    return move;
  }
  Units units{1e3, 1e-3, 1.0, 1.0};
  units.modal = std::sqrt(units.mass) * units.length;  // modal masses stay what they are
  move.variants.push_back({"", in_units(model, units)});
  return move;
}

Move make_move(const std::string& name, const Model& model, const State& start, std::uint64_t seed) {
  Draw draw(seed);
  if (name == "cut") return move_of_cuts(model);
  if (name == "sides") {
    return move_of(name, "parent and child of joints and springs change places", swapped_sides(model, start),
                   "no joint and no spring has sides that are alike");
  }
  if (name == "frames") {
    return {name, "the frame of every body is moved and turned in it", {{"", moved_frames(model, seed)}}, "", {},
            false};
  }
  if (name == "joint frames") {
    return move_of(name, "frames of joints and force elements are turned as far as these allow",
                   turned_joint_frames(model, draw), "no joint and no force element allows it");
  }
  if (name == "world") return move_of_world(model, seed);
  if (name == "order") {
    Move move{name, "bodies, joints and force elements stand in another order", {}, "", {}, false};
    if (std::max({model.bodies.size() - 1, model.joints.size(), model.couplings.size(), model.elements.size()}) > 1) {
      move.variants.push_back({"", shuffled(model, seed)});
    } else {
      move.why_not = "there is one part of each kind";
    }
    return move;
  }
  if (name == "modes") return move_of_modes(model, seed);
  if (name == "units") return move_of_units(model);
  if (name == "welds") {
    return move_of(name, "a part of a body is welded in where a joint attached directly", with_welds(model, draw),
                   "every joint is between flexible bodies");
  }
  return move_of(name, "every rigid body is two that a weld holds together", split_bodies(model, draw),
                 "every body is flexible");
}

}  // namespace

const std::vector<std::string>& move_names() {
  static const std::vector<std::string> names{"cut",   "sides", "frames", "joint frames", "world",
                                              "order", "modes", "units",  "welds",        "split"};
  return names;
}

std::vector<Move> moves_of(const Model& model, const State& start, const std::vector<std::string>& names,
                           std::uint64_t seed) {
  std::vector<Move> moves;
  for (std::size_t k = 0; k < move_names().size(); ++k) {
    const std::string& name = move_names()[k];
    if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
    moves.push_back(make_move(name, model, start, seed + k));
  }
  return moves;
}

Change cut_at(std::size_t joint) {
  Change change;
  change.model = [joint](Model model) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) model.joints[k].named_as_cut = k == joint;
    return model;
  };
  return change;
}

std::vector<std::size_t> joints_in_loops(const Model& model) {
  std::vector<std::size_t> found;
  for (std::size_t without = 0; without < model.joints.size(); ++without) {
    std::vector<int> group(model.bodies.size());
    std::iota(group.begin(), group.end(), 0);
    const auto group_on = [&](std::size_t k, Side side) {
      return group[static_cast<std::size_t>(model.joints[k].on(side).body)];
    };
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      if (k != without) std::replace(group.begin(), group.end(), group_on(k, Side::child), group_on(k, Side::parent));
    }
    if (group_on(without, Side::child) == group_on(without, Side::parent)) found.push_back(without);
  }
  return found;
}

Change moved_frames(const Model& model, std::uint64_t seed) {
  Draw draw(seed);
  std::vector<Pose> frames;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    frames.push_back(draw.pose(kMoveOfFrames * model.length_scale()));
  }
  return with_body_frames(frames);
}

Change nearby_frames(const Model& model, std::uint64_t seed) {
  Draw draw(seed);
  std::vector<Pose> frames;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Vec3 place = draw.vector(kNearby * model.length_scale());
    const Vec3 axis = draw.vector(1.0);
    frames.push_back({place, rotation_about(Vec3(axis.normalized()), kNearby)});
  }
  return with_body_frames(frames);
}

Change moved_world(const Model& model, std::uint64_t seed) {
  Draw draw(seed);
  const WorldFreedom freedom = freedom_of_world(model);
  Pose world = draw.pose(kMoveOfWorld * model.length_scale());
  if (!freedom.turns) world.A = freedom.turns_about_vertical ? rotation_about(Axis::z, draw.angle()) : Mat3::Identity();
  if (!freedom.rises) world.r.z() = 0.0;
  return in_world(world);
}

Change shuffled(const Model& model, std::uint64_t seed) {
  Draw draw(seed);
  PartOrder order;
  order.bodies = draw.order(model.bodies.size(), 1);
  order.joints = draw.order(model.joints.size(), 0);
  order.couplings = draw.order(model.couplings.size(), 0);
  order.elements = draw.order(model.elements.size(), 0);
  return in_order(order);
}

Change recombined(const Model& model, std::uint64_t seed) {
  Draw draw(seed);
  std::vector<MatX> T;
  for (const Body& body : model.bodies) T.push_back(regular(draw, body.n_modes()));
  return with_modes(T);
}

}  // namespace concord::compare::invariance
