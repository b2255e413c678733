#include "tests/second_reading/places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "common/flexible/beam.h"
#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

namespace {

Mat3 turn(const Vec3& axis, double angle) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

/// The frame with two of its axes: z, or else x, is kept, the one that is left out stands on both, and the other one
/// where these two say.
StatedFrame frame_of_axes(const StatedTable& table) {
  const std::array<std::optional<Vec3>, 3> given{table.vector("x"), table.vector("y"), table.vector("z")};
  const auto count = std::count_if(given.begin(), given.end(), [](const auto& axis) { return axis.has_value(); });
  if (count != 2) throw std::runtime_error("a frame of another number of axes than two");
  const int kept = given[2] ? 2 : 0;
  const int missing = !given[0] ? 0 : !given[1] ? 1 : 2;
  StatedFrame frame;
  frame.R.col(kept) = given[kept]->normalized();
  frame.R.col(missing) = given[(missing + 1) % 3]->normalized().cross(given[(missing + 2) % 3]->normalized());
  frame.R.col(missing).normalize();
  const int other = 3 - kept - missing;
  frame.R.col(other) = Vec3(frame.R.col((other + 1) % 3)).cross(Vec3(frame.R.col((other + 2) % 3)));
  return frame;
}

Mat3 frame_of_sequence(const StatedTable& table) {
  const std::string sequence = table.text("sequence").value_or("");
  const auto angles = table.numbers("angles");
  if (sequence.size() != 3 || !angles || angles->size() != 3) throw std::runtime_error("no sequence of three angles");
  Mat3 R = Mat3::Identity();
  for (std::size_t k = 0; k < 3; ++k) R = R * turn(Vec3::Unit(sequence[k] - 'x'), (*angles)[k]);
  return R;
}

Mat3 frame_of_euler_parameters(const StatedTable& table) {
  const std::vector<double> p = *table.numbers("euler_parameters");
  if (p.size() != 4) throw std::runtime_error("not four Euler parameters");
  return Eigen::Quaterniond(p[0], p[1], p[2], p[3]).normalized().toRotationMatrix();
}

/// What a side of a joint, or the place of an element, says of itself, and where.
struct StatedPlace {
  std::string body;
  std::optional<Vec3> point;
  std::optional<std::string> node;
  std::optional<Vec3> offset;
  std::optional<StatedFrame> frame;
  std::function<Entry(const std::string& key)> entry;
};

StatedPlace place_of(const StatedTable& table) {
  return {table.reference(Names::bodies, "body"),
          table.vector("point"),
          table.text("node"),
          table.vector("offset"),
          frame_of(table),
          [table](const std::string& key) { return table.entry(key); }};
}

/// A side that is a body's name alone stands for the body's origin and axes.
StatedPlace place_of_side(const StatedTable& item, const std::string& side) {
  if (item.has_table(side)) return place_of(*item.table(side));
  StatedPlace place;
  place.body = item.reference(Names::bodies, side);
  place.entry = [item, side](const std::string& key) {
    Entry entry = item.entry(side);
    entry.key += "." + key;
    return entry;
  };
  return place;
}

/// The node of a flexible body; those of a beam are counted from its first end.
const ModalNode& node_of(const Body& body, const std::string& name) {
  const std::vector<ModalNode>& nodes = body.modal->nodes;
  if (body.modal->beam) {
    const int last = body.modal->beam->elements;
    const int number = name == "first" ? 0 : name == "last" ? last : std::stoi(name);
    return nodes.at(static_cast<std::size_t>(number));
  }
  for (const ModalNode& node : nodes) {
    if (node.name == name) return node;
  }
  throw std::runtime_error("no node " + name);
}

/// A rigid arm from a node moves with the node's rotation.
void hold_node(const Body& body, const StatedPlace& place, const Attachment& read, Ledger& ledger) {
  if (!place.node) throw std::runtime_error("no node on flexible body " + body.name);
  const ModalNode& node = node_of(body, *place.node);
  const Vec3 arm = place.offset.value_or(Vec3::Zero());
  Mat3X moved = node.Psi_t_L;
  for (Eigen::Index k = 0; k < moved.cols(); ++k) moved.col(k) += Vec3(node.Psi_r_L.col(k)).cross(arm);
  ledger.numbers(place.entry(place.offset ? "offset" : "node"), read.point_L, node.s0_L + arm, kRoundOff,
                 node.s0_L.norm() + arm.norm());
  // Each mode has a size of its own.
  for (Eigen::Index k = 0; k < moved.cols() && read.Psi_t_L.cols() == moved.cols(); ++k) {
    const double size = node.Psi_t_L.col(k).cwiseAbs().maxCoeff() +
                        node.Psi_r_L.col(k).cwiseAbs().maxCoeff() * arm.cwiseAbs().maxCoeff();
    ledger.numbers(place.entry("node.Psi_t"), read.Psi_t_L.col(k), moved.col(k), kRoundOff, size);
  }
  if (read.Psi_t_L.cols() != moved.cols()) ledger.numbers(place.entry("node.Psi_t"), read.Psi_t_L, moved);
  ledger.numbers(place.entry("node.Psi_r"), read.Psi_r_L, node.Psi_r_L);
}

void hold_stated_place(const Model& model, const StatedPlace& place, const Attachment& read, Ledger& ledger) {
  const int body = body_index(model, place.body);
  const bool has_body = read.body >= 0 && read.body < static_cast<int>(model.bodies.size());
  ledger.word(place.entry("body"), has_body ? model.bodies[static_cast<std::size_t>(read.body)].name : "", place.body);
  hold_frame(ledger, place.entry("frame"), read.C, place.frame.value_or(StatedFrame{}));
  if (body < 0) return;
  const Body& on = model.bodies[static_cast<std::size_t>(body)];
  if (on.modal) {
    hold_node(on, place, read, ledger);
    return;
  }
  ledger.numbers(place.entry("point"), read.point_L, place.point.value_or(Vec3::Zero()));
  ledger.numbers(place.entry("node.Psi_t"), read.Psi_t_L, Mat3X(3, 0));
  ledger.numbers(place.entry("node.Psi_r"), read.Psi_r_L, Mat3X(3, 0));
}

}  // namespace

std::optional<StatedFrame> frame_of(const StatedTable& table) {
  if (table.has("x") || table.has("y") || table.has("z")) return frame_of_axes(table);
  if (table.has("axis")) return StatedFrame{turn(*table.vector("axis"), table.number("angle").value())};
  if (table.has("sequence")) return StatedFrame{frame_of_sequence(table)};
  if (table.has("euler_parameters")) return StatedFrame{frame_of_euler_parameters(table)};
  if (!table.has("rotation_vector")) return {};
  const Vec3 theta = *table.vector("rotation_vector");
  if (!(theta.norm() > 0.0)) return StatedFrame{};
  return StatedFrame{turn(theta, theta.norm()), 1e-15 * theta.norm()};  // of many turns, what its length leaves open
}

void hold_frame(Ledger& ledger, const Entry& entry, const Mat3& read, const StatedFrame& stated) {
  ledger.numbers(entry, read, stated.R, kRoundOff + 2.0 * stated.doubt, 1.0);
}

int body_index(const Model& model, const std::string& name) {
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    if (model.bodies[k].name == name) return static_cast<int>(k);
  }
  return -1;
}

void hold_place(const Model& model, const StatedTable& item, const Attachment& read) {
  hold_stated_place(model, place_of(item), read, item.ledger());
}

void hold_sides(const Model& model, const StatedTable& item, const std::array<Attachment, 2>& read) {
  const auto both = item.table("both");
  const std::optional<Vec3> point = both ? both->vector("point") : std::nullopt;
  const std::optional<StatedFrame> frame = both ? frame_of(*both) : std::nullopt;
  for (const Side side : kSides) {
    StatedPlace place = place_of_side(item, side == Side::parent ? "parent" : "child");
    if (point) place.point = point;
    if (frame) place.frame = frame;
    hold_stated_place(model, place, read[static_cast<std::size_t>(index(side))], item.ledger());
  }
}

}  // namespace concord::second_reading
