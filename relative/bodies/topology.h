#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "common/model.h"
#include "relative/bodies/indices.h"

/// The spanning tree of a machine, and where its coordinates stand.
namespace concord::relative {

/// One body of the tree and the joint that connects it to its reference body, one step nearer to ground. `along`: the
/// body is the joint's child; otherwise the tree runs against the joint and the body is the joint's parent.
struct Link {
  BodyIndex body;
  BodyIndex reference;
  JointIndex joint;
  bool along = true;

  [[nodiscard]] Side own_side() const { return along ? Side::child : Side::parent; }
  [[nodiscard]] Side reference_side() const { return along ? Side::parent : Side::child; }
};

/// Where a joint stands: on a link of the tree, or among the cut joints.
struct OnLink {
  LinkIndex link;
};
struct AmongCuts {
  CutIndex cut;
};
using JointPlace = std::variant<OnLink, AmongCuts>;

/// The cut joint's index, or nothing for a joint of the tree.
inline std::optional<CutIndex> cut_of(const JointPlace& place) {
  const auto* among_cuts = std::get_if<AmongCuts>(&place);
  return among_cuts != nullptr ? std::optional(among_cuts->cut) : std::nullopt;
}

/// Places of a joint's or a body's numbers in q and u.
struct Span {
  int first_q = 0;
  int n_q = 0;
  int first_u = 0;
  int n_u = 0;
};

/// Order of q and u: link by link from ground outward, the joint's numbers and then the body's modal ones, u_i = [joint
/// speeds; adot_i]; after the tree the cut joints in the order of the model.
struct Topology {
  std::vector<Link> links;                             // from ground outward: a reference body's link stands before
  std::vector<std::optional<LinkIndex>> link_of_body;  // none for ground
  std::vector<JointIndex> cuts;                        // joints, in the order of the model
  std::vector<JointPlace> places;                      // of every joint of the model
  std::vector<Span> joints;                            // of every joint of the model
  std::vector<Span> modes;                             // of every body of the model, ground included
  /// Of every body of the model the point whose motion is that of the body, in its frame [m]: of a rigid body the point
  /// of its link's joint, whose motion then needs no shift, if that is not far from the mass; else the origin.
  std::vector<Vec3> reference_points_L;
  int n_q = 0;
  int n_u = 0;
  int n_tree_q = 0;
  int n_tree_u = 0;

  /// The link of a link's reference body; none at ground.
  [[nodiscard]] std::optional<LinkIndex> inward_link(LinkIndex link) const {
    return link_of_body[links[link].reference];
  }
  /// The same attachment seen from the reference point of its body instead of from the origin.
  [[nodiscard]] Attachment from_reference_point(Attachment attachment) const {
    attachment.point_L -= reference_points_L[attachment.body];
    return attachment;
  }
};

/// Opens the loops of the joint graph.
///
/// Rule for the cut joint: joints that the model names are cut. Of the others, those with the most closure rows
/// (6 - speeds + drivers) go into the tree first, so that each loop is cut where it needs the fewest rows; among equals
/// the joint nearer to ground (fewer joints on the shortest way), then the earlier one in the file, stays in the tree.
///
/// Throws InputError, naming the joints, if the named cuts leave bodies without a way to ground.
Topology build_topology(const Model& model);

}  // namespace concord::relative
