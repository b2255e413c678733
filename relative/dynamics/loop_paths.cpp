#include <algorithm>
#include <functional>
#include <utility>

#include "relative/dynamics/loops.h"

/// How multipliers act along the links, laid out once for a machine.
namespace concord::relative {

std::vector<Loops::LoopPath> Loops::lay_out_paths(const ArticulatedInertias& tree) const {
  std::vector<LoopPath> paths;
  for (const CutIndex c : upward<CutIndex>(closure_->cuts().size())) {
    const Closure::Cut& cut = closure_->cuts()[c];
    if (cut.measure.n_rows() == 0) continue;  // permits all six, and exerts nothing
    paths.push_back(lay_out(tree, {CutRows{c}, cut.first_row, cut.measure.n_rows(), {}, {}}, {cut.joint}));
  }
  for (std::size_t r = 0; r < closure_->speed_constraints().size(); ++r) {
    const SpeedConstraint& constraint = closure_->speed_constraints()[r];
    std::vector<JointIndex> joints;
    for (const ConstrainedJoint& part : constraint.joints) joints.push_back(part.joint);
    LoopPath path{SpeedRows{static_cast<int>(r)}, constraint.first_row, constraint.n_rows, {}, {}};
    paths.push_back(lay_out(tree, std::move(path), joints));
  }
  return paths;
}

/// Paths couple where they share a link.
EliminationOrder Loops::order_of_paths() const {
  std::vector<RowGroup> groups;
  std::vector<std::vector<int>> paths_on(kinematics_->topology().links.size());
  for (const LoopPath& path : paths_) {
    for (const PathLink& path_link : path.links) paths_on[path_link.link].push_back(static_cast<int>(groups.size()));
    groups.push_back({path.first_row.value(), path.n_rows});
  }
  return {std::move(groups), neighbours_of(paths_on, paths_.size())};
}

/// Pairs of links of two paths that are the same link, for the blocks on and below the diagonal.
void Loops::lay_out_shared() {
  struct Place {
    int path, link;
  };
  std::vector<std::vector<Place>> places_of(kinematics_->topology().links.size());
  for (int path = 0; path < static_cast<int>(paths_.size()); ++path) {
    for (int i = 0; i < static_cast<int>(paths_[path].links.size()); ++i) {
      const PathLink& path_link = paths_[path].links[i];
      if (path_link.unit_response.rows() > 0) places_of[path_link.link].push_back({path, i});
    }
  }
  const EliminationOrder& order = Lambda_.order();
  for (const std::vector<Place>& places : places_of) {
    for (const Place& row : places) {
      for (const Place& column : places) {
        if (order.place_of(row.path) < order.place_of(column.path)) continue;
        shared_.push_back({order.block_of(row.path, column.path), row.path, row.link, column.path, column.link});
      }
    }
  }
}

/// Where the unknowns of each link on a path stand among all of them.
void Loops::lay_out_stacked(const ArticulatedInertias& tree) {
  first_of_link_.resize(kinematics_->topology().links.size());
  int most_unknowns = 0;
  for (const LoopPath& path : paths_) {
    for (const PathLink& path_link : path.links) {
      const int n = tree.n_unknowns(path_link.link);
      most_unknowns = std::max(most_unknowns, n);
      if (first_of_link_[path_link.link]) continue;
      first_of_link_[path_link.link] = static_cast<int>(n_stacked_);
      n_stacked_ += n;
    }
  }
  force_.setZero(most_unknowns);
}

/// The links between the bodies of some joints and ground, outermost first.
std::vector<LinkIndex> Loops::links_to_ground(const std::vector<JointIndex>& joints) const {
  const Topology& topology = kinematics_->topology();
  std::vector<LinkIndex> links;
  for (const JointIndex joint : joints) {
    for (const Attachment& side : kinematics_->model().joints[joint].sides) {
      for (std::optional<LinkIndex> l = topology.link_of_body[side.body]; l; l = topology.inward_link(*l))
        links.push_back(*l);
    }
  }
  std::sort(links.begin(), links.end(), std::greater<>());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return links;
}

/// Gives a path its links, and a load for each of its joints.
Loops::LoopPath Loops::lay_out(const ArticulatedInertias& tree, LoopPath path,
                               const std::vector<JointIndex>& joints) const {
  const Topology& topology = kinematics_->topology();
  const std::vector<LinkIndex> links = links_to_ground(joints);
  const auto path_link_of = [&](std::optional<LinkIndex> link) -> std::optional<int> {
    if (!link) return std::nullopt;
    return static_cast<int>(std::find(links.begin(), links.end(), *link) - links.begin());
  };
  for (const LinkIndex l : links) {
    const int m = topology.modes[topology.links[l].body].n_u;
    path.links.push_back({l, path_link_of(topology.inward_link(l)), Mat6X::Zero(6, path.n_rows),
                          MatX::Zero(m, path.n_rows), MatX::Zero(tree.n_unknowns(l), path.n_rows)});
  }
  for (const JointIndex k : joints) {
    if (const auto* on_link = std::get_if<OnLink>(&topology.places[k])) {
      path.loads.emplace_back(CoordinateLoad{*path_link_of(on_link->link)});
      continue;
    }
    const auto link_on = [&](Side side) {
      return path_link_of(topology.link_of_body[kinematics_->model().joints[k].on(side).body]);
    };
    path.loads.emplace_back(WrenchLoad{k, link_on(Side::child), link_on(Side::parent)});
  }
  return path;
}

}  // namespace concord::relative
