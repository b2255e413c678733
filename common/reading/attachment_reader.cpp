#include "common/reading/attachment_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/reading/orientation_reader.h"
#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"
#include "common/rotation.h"

namespace concord {

namespace {

/// What `both` says for the two sides at once, in each body's own axes.
struct BothSides {
  std::optional<Vec3> point;
  std::optional<Mat3> C;
};

BothSides read_both(const TableReader& owner) {
  BothSides both;
  const toml::table* found = owner.table("both");
  if (found == nullptr) return both;
  const TableReader table(*found, owner.title() + ", both", with_orientation({"point"}), owner.reading());
  both.point = table.vector3("point");
  if (says_orientation(table)) both.C = read_orientation(table).value_or(Mat3::Identity());
  return both;
}

/// Index of the body that a side names; nothing after a complaint.
std::optional<int> find_body(const TableReader& table, std::string_view key, const std::vector<BodyReading>& bodies) {
  const auto name = table.text(key);
  if (!name) return std::nullopt;
  const std::string wanted = table.reading().name_in_model("body", *name);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].body.name == wanted) return static_cast<int>(i);
  }
  std::vector<std::string> names;
  for (const BodyReading& one : bodies) {
    const std::string known = table.reading().name_in_file("body", one.body.name);
    const bool is_new = std::find(names.begin(), names.end(), known) == names.end();
    if (is_new && !known.empty()) names.push_back(known);
  }
  table.complain(key, fmt::format("unknown body '{}': {}", *name, suggestion(*name, names, "bodies")));
  return std::nullopt;
}

/// Puts the attachment at a node: its place and rows. A rigid arm from the node, `offset`, moves with the node's
/// rotation: Psi_t - offset~ Psi_r.
void attach_to_node(const ModalNode& node, const Vec3& offset_L, Attachment& side) {
  side.point_L = node.s0_L + offset_L;
  side.Psi_t_L = node.Psi_t_L - skew(offset_L) * node.Psi_r_L;
  side.Psi_r_L = node.Psi_r_L;
}

void read_node(const TableReader& table, const BodyReading& on, Attachment& side) {
  const auto name = table.text("node");
  const Vec3 offset = table.vector3("offset").value_or(Vec3::Zero());
  if (!name || !on.is_usable) return;
  const std::vector<ModalNode>& nodes = on.body.modal->nodes;
  const auto node = std::find_if(nodes.begin(), nodes.end(), [&](const ModalNode& one) { return one.name == *name; });
  if (node != nodes.end()) {
    attach_to_node(*node, offset, side);
    return;
  }
  std::vector<std::string> names;
  for (const ModalNode& one : nodes) names.push_back(one.name);
  table.complain("node",
                 fmt::format("body '{}' has no node '{}': {}", on.body.name, *name, suggestion(*name, names, "nodes")));
}

std::string flexible_needs_node(const std::string& body) {
  return fmt::format("body '{}' is flexible: joints and forces sit on its nodes, so give a 'node'", body);
}

void read_point(const TableReader& table, const BothSides& both, Attachment& side) {
  if (both.point && table.has("point")) table.complain("point", "the point is given in 'both' already");
  side.point_L = both.point ? *both.point : table.vector3("point").value_or(Vec3::Zero());
}

void read_place(const TableReader& table, const BodyReading& on, const BothSides& both, Attachment& side) {
  const std::string& name = on.body.name;
  if (table.has("point") && table.has("node")) {
    table.require_one_of({"point", "node"});
  } else if (on.is_flexible) {
    if (both.point) {
      table.complain(fmt::format("body '{}' is flexible: the point in 'both' cannot be on it", name));
    } else if (table.has("node")) {
      read_node(table, on, side);
    } else {
      table.complain(flexible_needs_node(name));
    }
  } else if (table.has("node") || table.has("offset")) {
    const std::string_view key = table.has("node") ? "node" : "offset";
    table.complain(key, fmt::format("body '{}' is rigid: give a 'point' instead of a '{}'", name, key));
  } else {
    read_point(table, both, side);
  }
}

void read_frame(const TableReader& table, const BothSides& both, Attachment& side) {
  if (both.C && says_orientation(table)) table.complain("the frame is given in 'both' already");
  side.C = both.C ? *both.C : read_orientation(table).value_or(Mat3::Identity());
}

/// The end that a table says, together with `both`.
std::optional<Attachment> read_table(const TableReader& table, const BothSides& both,
                                     const std::vector<BodyReading>& bodies) {
  Attachment side;
  read_frame(table, both, side);
  if (!table.require({"body"})) return std::nullopt;
  const auto body = find_body(table, "body", bodies);
  if (!body) return std::nullopt;
  side.body = *body;
  read_place(table, bodies[*body], both, side);
  return side;
}

/// The end that is said by a body's name alone: at the body's origin, in its axes, or where `both` says.
std::optional<Attachment> read_name(const TableReader& owner, std::string_view key, const BothSides& both,
                                    const std::vector<BodyReading>& bodies) {
  const auto body = find_body(owner, key, bodies);
  if (!body) return std::nullopt;
  Attachment side;
  side.body = *body;
  side.C = both.C.value_or(Mat3::Identity());
  side.point_L = both.point.value_or(Vec3::Zero());
  if (bodies[*body].is_flexible) owner.complain(key, flexible_needs_node(bodies[*body].body.name));
  return side;
}

std::optional<Attachment> read_end(const TableReader& owner, std::string_view key, const BothSides& both,
                                   const std::vector<BodyReading>& bodies) {
  const toml::node* found = owner.node(key);
  if (found == nullptr) return std::nullopt;
  if (found->is_string()) return read_name(owner, key, both, bodies);
  if (const toml::table* said = found->as_table()) {
    const std::string title = fmt::format("{}, {}", owner.title(), key);
    return read_table(TableReader(*said, title, with_attachment({}), owner.reading()), both, bodies);
  }
  owner.complain(key, fmt::format("'{}' must be the name of a body, or a table, found {}", key, type_name(*found)));
  return std::nullopt;
}

KnownKeys joined(KnownKeys own, const KnownKeys& more) {
  own.insert(own.end(), more.begin(), more.end());
  return own;
}

}  // namespace

KnownKeys with_attachment(KnownKeys own) {
  return with_orientation(joined(std::move(own), {"body", "point", "node", "offset"}));
}

std::optional<Attachment> read_attachment(const TableReader& table, const std::vector<BodyReading>& bodies) {
  return read_table(table, {}, bodies);
}

KnownKeys with_ends(KnownKeys own) { return joined(std::move(own), {"parent", "child", "both"}); }

std::optional<std::array<Attachment, 2>> read_ends(const TableReader& owner, const std::vector<BodyReading>& bodies) {
  owner.require({"parent", "child"});
  const BothSides both = read_both(owner);
  const auto parent = read_end(owner, "parent", both, bodies);
  const auto child = read_end(owner, "child", both, bodies);
  if (!parent || !child) return std::nullopt;
  if (parent->body == child->body) {
    owner.complain("child", fmt::format("connects body '{}' with itself", bodies[child->body].body.name));
  }
  return std::array{*parent, *child};
}

}  // namespace concord
