#include "compare/audit/geometric_stiffness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "compare/audit/digits.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

constexpr double kNotable = 0.05;
/// How straight and regular nodes and sections of a beam are, relative to its length.
constexpr double kStraight = 1e-9;
constexpr std::size_t kPointsOfSection = 4;
constexpr std::size_t kSectionsOfElement = 4;

/// Where a beam lies in its body.
struct BeamLine {
  Vec3 first_L = Vec3::Zero();
  Vec3 axis_L = Vec3::UnitX();  // from the first end to the last, unit
  Vec3 y_L = Vec3::UnitY();     // the beam's y axis, unit
  double length = 0.0;
  std::size_t elements = 0;

  [[nodiscard]] double along(const Vec3& point_L) const {
    return std::clamp(axis_L.dot(point_L - first_L), 0.0, length);
  }
};

/// Whether the nodes are "0", "1", ... at equal distances on a straight line, then "first" and "last".
bool has_nodes_of_a_beam(const std::vector<ModalNode>& nodes, BeamLine& line) {
  if (nodes.size() < 4) return false;
  line.elements = nodes.size() - 3;
  const Vec3 whole = nodes[line.elements].s0_L - nodes[0].s0_L;
  line.length = whole.norm();
  if (!(line.length > 0.0)) return false;
  line.first_L = nodes[0].s0_L;
  line.axis_L = whole / line.length;
  for (std::size_t node = 0; node <= line.elements; ++node) {
    const Vec3 place = line.first_L + whole * (static_cast<double>(node) / static_cast<double>(line.elements));
    if (nodes[node].name != std::to_string(node)) return false;
    if ((nodes[node].s0_L - place).norm() > kStraight * line.length) return false;
  }
  return nodes[line.elements + 1].name == "first" && nodes[line.elements + 2].name == "last";
}

/// Whether the mass points are sections of four, at plus and minus the radii of gyration about points of the line; the
/// first two of a section differ in the beam's z, the first and the third in its y.
bool has_sections_of_a_beam(const std::vector<MassPoint>& points, BeamLine& line) {
  if (points.size() != kPointsOfSection * kSectionsOfElement * line.elements) return false;
  for (std::size_t k = 0; k < points.size(); k += kPointsOfSection) {
    const Vec3 z = points[k + 1].s0_L - points[k].s0_L;
    const Vec3 y = points[k + 2].s0_L - points[k].s0_L;
    const Vec3 middle = 0.5 * (points[k].s0_L + points[k + 3].s0_L) - line.first_L;
    if (!(y.norm() > 0.0 && z.norm() > 0.0)) return false;
    const double askew =
        std::max({std::abs(line.axis_L.dot(y)), std::abs(line.axis_L.dot(z)), std::abs(y.dot(z)) / y.norm(),
                  (middle - line.axis_L * line.axis_L.dot(middle)).norm()});
    if (askew > kStraight * line.length) return false;
    if (k == 0) line.y_L = y.normalized();
  }
  return true;
}

/// The line of a body that was made from a `beam` table; nothing for any other.
std::optional<BeamLine> beam_line(const ModalData& modal) {
  BeamLine line;
  if (!has_nodes_of_a_beam(modal.nodes, line) || !has_sections_of_a_beam(modal.mass_points, line)) return std::nullopt;
  return line;
}

/// The largest deflection of a mode's nodes in a direction.
double deflection(const ModalData& modal, int column, const Vec3& direction_L) {
  double largest = 0.0;
  for (const ModalNode& node : modal.nodes) {
    largest = std::max(largest, std::abs(direction_L.dot(node.Psi_t_L.col(column))));
  }
  return largest;
}

/// The softest mode that bends towards a direction and in no other; -1 if there is none.
int lowest_bending_mode(const ModalData& modal, const BeamLine& line, const Vec3& direction_L) {
  int lowest = -1;
  for (int column = 0; column < modal.n_modes(); ++column) {
    const double own = deflection(modal, column, direction_L);
    const double other =
        std::max(deflection(modal, column, line.axis_L), deflection(modal, column, line.axis_L.cross(direction_L)));
    if (!(own > 0.0) || other > kStraight * own || !(modal.stiffness(column, column) > 0.0)) continue;
    if (lowest < 0 || modal.stiffness(column, column) < modal.stiffness(lowest, lowest)) lowest = column;
  }
  return lowest;
}

/// Where along the beam a wrench enters: at the node whose mode shapes the attachment has, whatever its offset is.
double place_along(const ModalData& modal, const BeamLine& line, const Attachment& side) {
  double nearest = std::numeric_limits<double>::infinity();
  double x = line.along(side.point_L);
  for (const ModalNode& node : modal.nodes) {
    if (node.Psi_r_L != side.Psi_r_L) continue;
    const double distance = (node.s0_L - side.point_L).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    x = line.along(node.s0_L);
  }
  return x;
}

/// The geometric stiffness of one bending mode of one body. N(x) is the sum of all axial forces beyond x, so that the
/// integral of N w'^2 is the sum of each force times the integral of w'^2 up to where it acts.
class PlaneWatch {
 public:
  PlaneWatch(const Model& model, int body, const BeamLine& line, int column, const Vec3& direction_L, const char* plane)
      : model_(model), body_(body), axis_L_(line.axis_L) {
    const ModalData& modal = *model.bodies[body].modal;
    const BendingMode mode(modal, column, line.axis_L, direction_L);
    for (const MassPoint& point : modal.mass_points) {
      of_points_.push_back(mode.squared_slope_until(line.along(point.s0_L)) / mode.stiffness());
    }
    const auto of = [&](const Attachment& side) {
      return side.body == body ? mode.squared_slope_until(place_along(modal, line, side)) / mode.stiffness() : 0.0;
    };
    for (const Joint& joint : model.joints) of_joints_.push_back({of(joint.sides[0]), of(joint.sides[1])});
    for (const ForceElement& element : model.elements) {
      std::array<double, 2> weights{};
      for (const Side side : kSides) {
        const Attachment* end = end_of(element, side);
        if (end != nullptr) weights[index(side)] = of(*end);
      }
      of_elements_.push_back(weights);
    }
    ratio_.body = model.bodies[body].name;
    ratio_.plane = plane;
    ratio_.mode = column + 1;
    ratio_.lowest = std::numeric_limits<double>::infinity();
    ratio_.highest = -ratio_.lowest;
  }

  void add(const Sample& sample) {
    const double ratio = ratio_in(sample);
    if (!std::isfinite(ratio)) ratio_.is_known = false;
    if (ratio < ratio_.lowest) std::tie(ratio_.lowest, ratio_.t_lowest) = std::pair(ratio, sample.state.t);
    if (ratio > ratio_.highest) std::tie(ratio_.highest, ratio_.t_highest) = std::pair(ratio, sample.state.t);
  }

  [[nodiscard]] const GeometricStiffness& ratio() const { return ratio_; }

 private:
  [[nodiscard]] double ratio_in(const Sample& sample) const {
    const Vec3 axis = rotation_of(sample.state.bodies[body_].p) * axis_L_;
    double sum = of_mass(sample, axis);
    for (std::size_t k = 0; k < of_joints_.size(); ++k) {
      for (const Side side : kSides) {
        sum += of_joints_[k][index(side)] * axis.dot(sample.evaluation.joints[k].total_on(side).in_global.force);
      }
    }
    for (std::size_t k = 0; k < of_elements_.size(); ++k) {
      for (const Side side : kSides) {
        sum += of_elements_[k][index(side)] * axis.dot(sample.evaluation.elements[k].on_side(side).in_global.force);
      }
    }
    return sum;
  }

  /// Of the forces -m (acceleration - g) of the mass points.
  [[nodiscard]] double of_mass(const Sample& sample, const Vec3& axis) const {
    const BodyState& state = sample.state.bodies[body_];
    const BodyAcceleration& rate = sample.evaluation.bodies[body_];
    const Mat3 A = rotation_of(state.p);
    const std::vector<MassPoint>& points = model_.bodies[body_].modal->mass_points;
    double sum = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec3 s = A * (points[k].s0_L + points[k].Psi_t_L * state.a);
      const Vec3 sdot = A * (points[k].Psi_t_L * state.adot);
      const Vec3 sddot = A * (points[k].Psi_t_L * rate.addot);
      const Vec3 acceleration = rate.vdot + rate.omegadot.cross(s) + state.omega.cross(state.omega.cross(s)) +
                                2.0 * state.omega.cross(sdot) + sddot;
      sum -= of_points_[k] * points[k].mass * axis.dot(acceleration - model_.gravity);
    }
    return sum;
  }

  const Model& model_;
  int body_;
  Vec3 axis_L_;
  // What an axial force of 1 N adds to the ratio, by mass point, and by joint and element on each side.
  std::vector<double> of_points_;
  std::vector<std::array<double, 2>> of_joints_;
  std::vector<std::array<double, 2>> of_elements_;
  GeometricStiffness ratio_;
};

GeometricStiffness not_known(const Body& body) {
  GeometricStiffness ratio;
  ratio.body = body.name;
  ratio.is_known = false;
  return ratio;
}

}  // namespace

bool GeometricStiffness::is_notable() const {
  return is_known && std::max(std::abs(lowest), std::abs(highest)) > kNotable;
}

BendingMode::BendingMode(const ModalData& modal, int column, const Vec3& axis_L, const Vec3& direction_L)
    : stiffness_(modal.stiffness(column, column)) {
  const std::size_t elements = modal.nodes.size() - 3;
  width_ = (modal.nodes[elements].s0_L - modal.nodes[0].s0_L).norm() / static_cast<double>(elements);
  const auto value = [&](std::size_t node) { return direction_L.dot(modal.nodes[node].Psi_t_L.col(column)); };
  const auto slope = [&](std::size_t node) {
    return direction_L.dot(Vec3(modal.nodes[node].Psi_r_L.col(column)).cross(axis_L));
  };
  double sum = 0.0;
  for (std::size_t element = 0; element < elements; ++element) {
    // The derivative of the cubic with these values and slopes at its ends.
    const double rise = (value(element + 1) - value(element)) / width_;
    const double at_first = slope(element);
    const double at_last = slope(element + 1);
    rates_.emplace_back(at_first, 6.0 * rise - 4.0 * at_first - 2.0 * at_last,
                        3.0 * at_first + 3.0 * at_last - 6.0 * rise);
    until_.push_back(sum);
    sum = squared_slope_until(width_ * static_cast<double>(element + 1));
  }
}

double BendingMode::squared_slope_until(double x) const {
  const double place = std::max(0.0, x / width_);
  const std::size_t element = std::min(static_cast<std::size_t>(place), rates_.size() - 1);
  const double xi = std::min(1.0, place - static_cast<double>(element));
  const Vec3& r = rates_[element];
  // The integral of (r0 + r1 xi + r2 xi^2)^2.
  const double integral =
      xi * (r(0) * r(0) + xi * (r(0) * r(1) + xi * ((r(1) * r(1) + 2.0 * r(0) * r(2)) / 3.0 +
                                                    xi * (r(1) * r(2) / 2.0 + xi * r(2) * r(2) / 5.0))));
  return until_[element] + width_ * integral;
}

std::vector<GeometricStiffness> geometric_stiffness(const Model& model, const Trajectory& trajectory) {
  std::vector<GeometricStiffness> ratios;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (!body.modal) continue;
    const std::optional<BeamLine> line = beam_line(*body.modal);
    if (!line || trajectory.samples.empty()) {
      ratios.push_back(not_known(body));
      continue;
    }
    const std::array<std::pair<const char*, Vec3>, 2> planes{
        {{"bending_xy", line->y_L}, {"bending_xz", line->axis_L.cross(line->y_L)}}};
    for (const auto& [plane, direction_L] : planes) {
      const int column = lowest_bending_mode(*body.modal, *line, direction_L);
      if (column < 0) continue;
      PlaneWatch watch(model, static_cast<int>(i), *line, column, direction_L, plane);
      for (const Sample& sample : trajectory.samples) watch.add(sample);
      ratios.push_back(watch.ratio());
    }
  }
  return ratios;
}

std::vector<int> axial_modes(const ModalData& modal) {
  std::vector<int> modes;
  const std::optional<BeamLine> line = beam_line(modal);
  if (!line) return modes;
  for (int column = 0; column < modal.n_modes(); ++column) {
    const double own = deflection(modal, column, line->axis_L);
    const double other =
        std::max(deflection(modal, column, line->y_L), deflection(modal, column, line->axis_L.cross(line->y_L)));
    const bool is_axial = own > 0.0 && other <= kStraight * own;
    if (is_axial && modal.stiffness(column, column) > 0.0) modes.push_back(column);
  }
  return modes;
}

namespace {

std::string range_of(const GeometricStiffness& ratio) {
  const auto text = [](double part, double t) { return fmt::format("{} (t = {:.6g} s)", format_percent(part, 1), t); };
  const std::string lowest = text(ratio.lowest, ratio.t_lowest);
  const std::string highest = text(ratio.highest, ratio.t_highest);
  return lowest == highest ? lowest : fmt::format("{} to {}", lowest, highest);
}

}  // namespace

std::vector<std::string> notes_on(const std::vector<GeometricStiffness>& ratios) {
  std::vector<std::string> notes;
  for (const GeometricStiffness& ratio : ratios) {
    if (!ratio.is_known) {
      notes.push_back(fmt::format("geometric stiffness of body {}: not known, its modes do not come from a beam table",
                                  ratio.body));
    } else if (ratio.is_notable()) {
      notes.push_back(
          fmt::format("geometric stiffness, which no model has: on body {} axial forces reach {} of the elastic "
                      "stiffness of its lowest mode of {}, a_{}",
                      ratio.body, range_of(ratio), ratio.plane, ratio.mode));
    }
  }
  return notes;
}

}  // namespace concord::compare
