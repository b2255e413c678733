#include "compare/audit/same_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "common/flexible/beam.h"
#include "common/products.h"
#include "compare/audit/beam_statement.h"

namespace concord::compare {

namespace {

constexpr double kEqual = 1e-12;
constexpr std::array kNames{"parent", "child"};

/// A body of one description, where it starts in the world of the given one.
struct Placed {
  const Body& body;
  Pose pose;

  [[nodiscard]] Vec3 world(const Vec3& s_L) const { return pose.r + pose.A * s_L; }
};

/// Bodies that have a start pose: of the others, which no joint leads to, no machine is made.
std::vector<bool> standing_bodies(const Model& model) {
  std::vector<bool> stands;
  for (const Body& body : model.bodies) stands.push_back(stands.empty() || body.pose_guess);
  const auto reach = [&](const Joint& joint) {
    const auto parent = static_cast<std::size_t>(joint.on(Side::parent).body);
    const auto child = static_cast<std::size_t>(joint.on(Side::child).body);
    if (stands[parent] == stands[child]) return false;
    stands[parent] = stands[child] = true;
    return true;
  };
  while (std::any_of(model.joints.begin(), model.joints.end(), reach)) {
  }
  return stands;
}

std::vector<Placed> placed(const Model& model, const Vec3& world) {
  const std::vector<Pose> poses = guess_poses(model);
  std::vector<Placed> bodies;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    bodies.push_back({model.bodies[i], {poses[i].r + world, poses[i].A}});
  }
  return bodies;
}

/// G of w = [1; x; A psi_1; ...], x the place in the world.
MatX integrals_in_world(const Placed& one) {
  const MatX& G = one.body.modal->G;
  MatX to_world = MatX::Zero(G.rows(), G.cols());
  to_world(0, 0) = 1.0;
  to_world.block<3, 1>(1, 0) = one.pose.r;
  for (Eigen::Index first = 1; first < G.rows(); first += 3) to_world.block<3, 3>(first, first) = one.pose.A;
  return congruence(to_world.transpose(), G);
}

/// G, added up anew point by point.
MatX integrals_of_points(const ModalData& modal) {
  MatX G = MatX::Zero(modal.G.rows(), modal.G.cols());
  VecX w(G.rows());
  for (const MassPoint& point : modal.mass_points) {
    w << 1.0, point.s0_L, point.Psi_t_L.reshaped();
    G += point.mass * w * w.transpose();
  }
  return G;
}

class Comparison {
 public:
  Comparison(const Model& given, const Model& changed, const Vec3& world)
      : stands_(standing_bodies(given)), given_(placed(given, {0.0, 0.0, 0.0})), changed_(placed(changed, world)) {
    for (const Model* model : {&given, &changed}) take_distances(*model);
    for (const auto* bodies : {&given_, &changed_}) {
      for (const Placed& one : *bodies) distance_ = std::max(distance_, one.pose.r.norm());
    }
  }

  void compare_body(std::size_t i) {
    if (!stands_[i]) return;
    const Placed& given = given_[i];
    const Placed& changed = changed_[i];
    const std::string of = fmt::format(" of body '{}'", given.body.name);
    if (given.body.modal.has_value() != changed.body.modal.has_value()) return miss("modal data" + of);
    if (given.body.modal) return compare_modal(given, changed, of);
    hold("mass" + of, changed.body.mass - given.body.mass, given.body.mass, " kg");
    hold_place("mass centre" + of, given.world(given.body.center_of_mass_L),
               changed.world(changed.body.center_of_mass_L));
    const auto inertia = [](const Placed& one) {
      return Mat3(one.pose.A * one.body.inertia_L * one.pose.A.transpose());
    };
    hold("inertia" + of, (inertia(changed) - inertia(given)).norm(), inertia(given).norm(), " kg m2");
  }

  void compare_attachment(const std::string& what, const Attachment& given, const Attachment& changed) {
    if (given.body != changed.body || given.Psi_t_L.cols() != changed.Psi_t_L.cols() ||
        given.Psi_r_L.cols() != changed.Psi_r_L.cols()) {
      return miss("body of " + what);
    }
    if (!stands_[static_cast<std::size_t>(given.body)]) return;
    const Placed& before = given_[static_cast<std::size_t>(given.body)];
    const Placed& after = changed_[static_cast<std::size_t>(given.body)];
    hold_place("point of " + what, before.world(given.point_L), after.world(changed.point_L));
    hold_axes("axes of " + what, before.pose.A * given.C, after.pose.A * changed.C);
    hold_axes("mode shapes of " + what, before.pose.A * given.Psi_t_L, after.pose.A * changed.Psi_t_L);
    hold_axes("mode shapes of " + what, before.pose.A * given.Psi_r_L, after.pose.A * changed.Psi_r_L);
  }

  void compare_load(const std::string& what, const Load& given, const Load& changed) {
    if (given.axes != changed.axes) return miss("axes of " + what);
    const auto body = static_cast<std::size_t>(given.at.body);
    const bool turns = given.axes == LoadAxes::body;
    const Mat3 before = turns ? given_[body].pose.A : Mat3(Mat3::Identity());
    const Mat3 after = turns ? changed_[body].pose.A : Mat3(Mat3::Identity());
    hold("force of " + what, (after * changed.force - before * given.force).norm(), given.force.norm(), " N");
    hold("torque of " + what, (after * changed.torque - before * given.torque).norm(), given.torque.norm(), " N m");
  }

  void miss(std::string what) {
    worst_ = std::numeric_limits<double>::infinity();
    text_ = std::move(what) + ": not the same";
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void take_distances(const Model& model) {
    const auto take = [this](const Vec3& s_L) { distance_ = std::max(distance_, s_L.norm()); };
    for (const Body& body : model.bodies) {
      take(body.center_of_mass_L);
      if (!body.modal) continue;
      for (const MassPoint& point : body.modal->mass_points) take(point.s0_L);
      for (const ModalNode& node : body.modal->nodes) take(node.s0_L);
    }
    for (const Joint& joint : model.joints) {
      for (const Attachment& side : joint.sides) take(side.point_L);
    }
    for (const ForceElement& element : model.elements) {
      for (const Side side : kSides) {
        if (const Attachment* end = end_of(element, side)) take(end->point_L);
      }
    }
  }

  void compare_modal(const Placed& given, const Placed& changed, const std::string& of) {
    const ModalData& before = *given.body.modal;
    const ModalData& after = *changed.body.modal;
    if (before.mass_points.size() != after.mass_points.size() || before.nodes.size() != after.nodes.size() ||
        before.n_modes() != after.n_modes() || (before.beam == nullptr) != (after.beam == nullptr)) {
      return miss("modal data" + of);
    }
    for (std::size_t k = 0; k < before.mass_points.size(); ++k) {
      const MassPoint& point = before.mass_points[k];
      const std::string what = fmt::format("mass point {}{}", k + 1, of);
      hold("mass of " + what, after.mass_points[k].mass - point.mass, point.mass, " kg");
      hold_place(what, given.world(point.s0_L), changed.world(after.mass_points[k].s0_L));
      hold_axes("mode shapes of " + what, given.pose.A * point.Psi_t_L, changed.pose.A * after.mass_points[k].Psi_t_L);
    }
    for (std::size_t k = 0; k < before.nodes.size(); ++k) {
      const ModalNode& node = before.nodes[k];
      const std::string what = fmt::format("node '{}'{}", node.name, of);
      hold_place(what, given.world(node.s0_L), changed.world(after.nodes[k].s0_L));
      hold_axes("mode shapes of " + what, given.pose.A * node.Psi_t_L, changed.pose.A * after.nodes[k].Psi_t_L);
      hold_axes("mode shapes of " + what, given.pose.A * node.Psi_r_L, changed.pose.A * after.nodes[k].Psi_r_L);
    }
    compare_integrals(given, changed, of);
    hold("modal stiffness" + of, (after.stiffness - before.stiffness).norm(), before.stiffness.norm(), " N/m");
    hold("modal damping" + of, (after.damping - before.damping).norm(), before.damping.norm(), " N s/m");
    if (!before.beam) return;
    hold_place("first end" + of, given.world(before.beam->first_end_L), changed.world(after.beam->first_end_L));
    hold_axes("axes of the beam" + of, given.pose.A * before.beam->axes, changed.pose.A * after.beam->axes);
  }

  /// Mass, mass centre, inertia and what the modes have of them: of both in the world, and of the changed one about its
  /// own frame, where the lever of a frame that is far away hides nothing.
  void compare_integrals(const Placed& given, const Placed& changed, const std::string& of) {
    const MatX before = integrals_in_world(given);
    VecX sizes = block_sizes_of(given.body.modal->G);
    sizes.segment<3>(1).setConstant(sizes(0) * distance_);
    hold_entries("mass integrals" + of, before, integrals_in_world(changed), sizes);
    const MatX own = integrals_of_points(*changed.body.modal);
    hold_entries("mass integrals" + of, own, changed.body.modal->G, block_sizes_of(own));
  }

  void hold_entries(const std::string& what, const MatX& given, const MatX& changed, const VecX& sizes) {
    const MatX relative = (changed - given).cwiseAbs().cwiseQuotient((sizes * sizes.transpose()).cwiseMax(kTiny));
    hold(what, relative.maxCoeff<Eigen::PropagateNaN>(), 1.0, " of themselves");
  }
  void hold_place(const std::string& what, const Vec3& given, const Vec3& changed) {
    hold(what, (changed - given).norm(), distance_, " m");
  }
  void hold_axes(const std::string& what, const Mat3X& given, const Mat3X& changed) {
    if (given.cols() > 0) hold(what, (changed - given).norm(), given.norm(), "");
  }
  void hold(const std::string& what, double difference, double size, const char* unit) {
    const double allowed = kEqual * size;
    const double off = std::abs(difference);
    if (off <= allowed || off / allowed <= worst_) return;
    worst_ = off / allowed;
    text_ = fmt::format("{}: off by {:.3g}{}, allowed {:.2g}{}", what, off, unit, allowed, unit);
  }

  static constexpr double kTiny = std::numeric_limits<double>::min();

  std::vector<bool> stands_;  // by body
  std::vector<Placed> given_;
  std::vector<Placed> changed_;
  double distance_ = 0.0;  // the largest of all [m]
  double worst_ = 0.0;     // in parts of what is allowed
  std::string text_;
};

}  // namespace

std::string difference_of_machines(const Model& given, const Model& changed, const Vec3& world) {
  if (given.bodies.size() != changed.bodies.size() || given.joints.size() != changed.joints.size() ||
      given.elements.size() != changed.elements.size()) {
    return "number of bodies, joints or force elements: not the same";
  }
  Comparison comparison(given, changed, world);
  for (std::size_t i = 1; i < given.bodies.size(); ++i) comparison.compare_body(i);
  for (std::size_t k = 0; k < given.joints.size(); ++k) {
    for (const Side side : kSides) {
      comparison.compare_attachment(fmt::format("the {} of joint '{}'", kNames[index(side)], given.joints[k].name),
                                    given.joints[k].on(side), changed.joints[k].on(side));
    }
  }
  for (std::size_t k = 0; k < given.elements.size(); ++k) {
    const ForceElement& before = given.elements[k];
    const ForceElement& after = changed.elements[k];
    if (before.what.index() != after.what.index()) {
      comparison.miss(fmt::format("kind of '{}'", before.name));
      continue;
    }
    for (const Side side : kSides) {
      const Attachment* end = end_of(before, side);
      if (end == nullptr) continue;
      comparison.compare_attachment(fmt::format("the {} of '{}'", kNames[index(side)], before.name), *end,
                                    *end_of(after, side));
    }
    const auto* load = std::get_if<Load>(&before.what);
    if (load != nullptr) {
      comparison.compare_load(fmt::format("the load '{}'", before.name), *load, std::get<Load>(after.what));
    }
  }
  return comparison.text();
}

}  // namespace concord::compare
