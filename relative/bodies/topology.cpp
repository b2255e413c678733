#include "relative/bodies/topology.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace concord::relative {

namespace {

int body_on(const Joint& joint, Side side) { return joint.on(side).body; }

/// Fewest joints between ground and each body, over all joints; bodies that are out of reach get a large number.
std::vector<int> distances_from_ground(const Model& model) {
  constexpr int kOutOfReach = std::numeric_limits<int>::max() / 2;
  std::vector<int> distance(model.bodies.size(), kOutOfReach);
  distance[kGround] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (const Joint& joint : model.joints) {
      int& parent = distance[body_on(joint, Side::parent)];
      int& child = distance[body_on(joint, Side::child)];
      const int least = std::min(parent, child) + 1;
      changed = changed || parent > least || child > least;
      parent = std::min(parent, least);
      child = std::min(child, least);
    }
  }
  return distance;
}

int closure_rows(const Joint& joint) { return 6 - joint.type->n_u() + static_cast<int>(joint.drivers.size()); }

/// Joints that may be in the tree, the preferred ones first: see build_topology for the rule.
std::vector<int> tree_candidates(const Model& model) {
  const std::vector<int> distance = distances_from_ground(model);
  const auto reach = [&](const Joint& joint) {
    return distance[body_on(joint, Side::parent)] + distance[body_on(joint, Side::child)];
  };
  std::vector<int> candidates;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (!model.joints[k].named_as_cut) candidates.push_back(static_cast<int>(k));
  }
  std::stable_sort(candidates.begin(), candidates.end(), [&](int left, int right) {
    const Joint& a = model.joints[left];
    const Joint& b = model.joints[right];
    if (closure_rows(a) != closure_rows(b)) return closure_rows(a) > closure_rows(b);
    return reach(a) < reach(b);
  });
  return candidates;
}

/// Kruskal's choice: a candidate joins the tree if its bodies are not connected yet.
std::vector<bool> choose_tree_joints(const Model& model) {
  std::vector<int> group(model.bodies.size());
  std::iota(group.begin(), group.end(), 0);
  std::vector<bool> in_tree(model.joints.size(), false);
  for (const int k : tree_candidates(model)) {
    const int parent = group[body_on(model.joints[k], Side::parent)];
    const int child = group[body_on(model.joints[k], Side::child)];
    if (parent == child) continue;
    in_tree[k] = true;
    std::replace(group.begin(), group.end(), child, parent);
  }
  return in_tree;
}

/// Joints of the tree at each body.
std::vector<std::vector<int>> incident_tree_joints(const Model& model) {
  const std::vector<bool> in_tree = choose_tree_joints(model);
  std::vector<std::vector<int>> incident(model.bodies.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (!in_tree[k]) continue;
    for (const Attachment& side : model.joints[k].sides) incident[side.body].push_back(static_cast<int>(k));
  }
  return incident;
}

/// Directs the tree away from ground, breadth first, joints in the order of the model.
void direct_links(const Model& model, Topology& topology) {
  const std::vector<std::vector<int>> incident = incident_tree_joints(model);
  topology.link_of_body.assign(model.bodies.size(), std::nullopt);
  std::vector<int> reached{kGround};
  for (std::size_t next = 0; next < reached.size(); ++next) {
    const int reference = reached[next];
    for (const int k : incident[reference]) {
      const bool along = body_on(model.joints[k], Side::parent) == reference;
      const int body = body_on(model.joints[k], along ? Side::child : Side::parent);
      if (body == kGround || topology.link_of_body[body]) continue;
      topology.link_of_body[body] = LinkIndex(topology.links.size());
      topology.links.push_back({BodyIndex(body), BodyIndex(reference), JointIndex(k), along});
      reached.push_back(body);
    }
  }
}

void require_all_bodies(const Model& model, const Topology& topology) {
  if (topology.links.size() + 1 == model.bodies.size()) return;
  std::vector<std::string> lost;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (!topology.link_of_body[i]) lost.push_back(fmt::format("'{}'", model.bodies[i].name));
  }
  std::vector<std::string> named;
  SourceLocation where{model.file, 0, 0};
  for (const Joint& joint : model.joints) {
    if (!joint.named_as_cut) continue;
    if (named.empty()) where = joint.where;
    named.push_back(fmt::format("'{}'", joint.name));
  }
  if (named.empty()) {
    throw InputError(where, fmt::format("no joint connects {} to ground: add a joint (type 'free' for a body that "
                                        "moves freely)",
                                        fmt::join(lost, ", ")));
  }
  throw InputError(where, fmt::format("with the joints named as cut ({}) opened, no way leads from ground to {}: name "
                                      "one cut joint per loop",
                                      fmt::join(named, ", "), fmt::join(lost, ", ")));
}

Span joint_span(const Joint& joint, int first_q, int first_u) {
  return {first_q, joint.type->n_q(), first_u, joint.type->n_u()};
}

void lay_out(const Model& model, Topology& topology) {
  topology.joints.resize(model.joints.size());
  topology.modes.resize(model.bodies.size());
  int q = 0;
  int u = 0;
  const auto place_joint = [&](int k) {
    topology.joints[k] = joint_span(model.joints[k], q, u);
    q += topology.joints[k].n_q;
    u += topology.joints[k].n_u;
  };
  for (const Link& link : topology.links) {
    place_joint(link.joint);
    const int m = model.bodies[link.body].n_modes();
    topology.modes[link.body] = {q, m, u, m};
    q += m;
    u += m;
  }
  topology.n_tree_q = q;
  topology.n_tree_u = u;
  for (const JointIndex k : topology.cuts) place_joint(k);
  topology.n_q = q;
  topology.n_u = u;
}

/// Whether an inertia about the point keeps the digits of that about the mass centre: within a few radii of gyration of
/// it, or no farther than the origin.
bool serves_as_reference(const Body& body, const Vec3& point_L) {
  constexpr double kRadii = 5.0;
  const double square = (point_L - body.center_of_mass_L).squaredNorm();
  return body.mass * square <= kRadii * kRadii * 0.5 * body.inertia_L.trace() ||
         square <= body.center_of_mass_L.squaredNorm();
}

}  // namespace

Topology build_topology(const Model& model) {
  Topology topology;
  direct_links(model, topology);
  require_all_bodies(model, topology);
  std::vector<std::optional<LinkIndex>> link_of_joint(model.joints.size());
  for (const LinkIndex l : upward<LinkIndex>(topology.links.size())) link_of_joint[topology.links[l].joint] = l;
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
    if (link_of_joint[k]) {
      topology.places.emplace_back(OnLink{*link_of_joint[k]});
    } else {
      topology.places.emplace_back(AmongCuts{CutIndex(topology.cuts.size())});
      topology.cuts.push_back(k);
    }
  }
  lay_out(model, topology);
  topology.reference_points_L.assign(model.bodies.size(), Vec3::Zero());
  for (const Link& link : topology.links) {
    if (model.bodies[link.body].modal) continue;
    const Vec3& point_L = model.joints[link.joint].on(link.own_side()).point_L;
    if (serves_as_reference(model.bodies[link.body], point_L)) topology.reference_points_L[link.body] = point_L;
  }
  return topology;
}

}  // namespace concord::relative
