#include "compare/random_machines/elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/rotation.h"

namespace concord::compare::fuzz {

namespace {

Entry number_entry(const std::string& key, double value, bool needed = false) {
  return {key, number_text(value), needed};
}

Vec3 position_of(const End& end, const std::vector<Pose>& poses) {
  return poses[end.body].r + poses[end.body].A * end.point;
}

Mat3 axes_of(const End& end, const std::vector<Pose>& poses) { return poses[end.body].A * rotation_of(end.p); }

/// Turns the end's frame into these global axes.
void turn_to(End& end, const Mat3& A, const std::vector<Pose>& poses) {
  end.p = parameters_of(poses[end.body].A.transpose() * A);
}

/// Where an element is drawn, and in what units.
struct Surroundings {
  const Ends& ends;
  const std::vector<Pose>& poses;
  const Units& units;
};

void draw(std::type_identity<Load> /*kind*/, const Surroundings& around, ElementPlan& plan, Random& random) {
  const auto& [ends, poses, units] = around;
  plan.child = ends.alone;
  const int axes = random.below(3);
  plan.has_frame = axes == 2;
  const bool has_force = random.chance(0.7);
  const bool has_torque = !has_force || random.chance(0.5);
  if (has_force) plan.entries.push_back({"force", list_text(random.vector(3.0 * units.force()))});
  if (has_torque) plan.entries.push_back({"torque", list_text(random.vector(units.force() * units.length))});
  if (axes > 0) plan.entries.push_back({"axes", axes == 1 ? "\"body\"" : "\"follower\""});
  if (random.chance(0.6)) {
    plan.entries.push_back({"law", inline_text(draw_load_law(1.0, units.time, random).entries)});
  }
}

void draw(std::type_identity<LineSpring> /*kind*/, const Surroundings& around, ElementPlan& plan, Random& random) {
  const auto& [ends, poses, units] = around;
  plan.parent = ends.parent;
  plan.child = ends.child;
  plan.has_frame = false;
  const double length = (position_of(ends.child, poses) - position_of(ends.parent, poses)).norm();
  plan.entries = draw_force_law(length, units.length, 2.0 * units.force(), units, true, random);
}

/// A rotation by less than `most` about any axis.
Mat3 small_rotation(double most, Random& random) {
  return rotation_about(rotation_of(random.rotation()).col(0), random.between(-most, most));
}

void draw(std::type_identity<TurnSpring> /*kind*/, const Surroundings& around, ElementPlan& plan, Random& random) {
  const auto& [ends, poses, units] = around;
  plan.parent = ends.parent;
  plan.child = ends.child;
  const double angle = random.between(-3.1, 3.1);  // turns are counted: half a turn is no border
  turn_to(plan.child, axes_of(ends.parent, poses) * small_rotation(0.5, random) * rotation_about(Axis::z, angle),
          poses);
  plan.entries = draw_force_law(angle, 1.0, units.force() * units.length, units, false, random);
}

std::string matrix_text(const Mat6& matrix) {
  std::string text = "[";
  for (int row = 0; row < 6; ++row) text += (row > 0 ? ", " : "") + list_text(matrix.row(row).transpose());
  return text + "]";
}

/// Six numbers, or six rows of six: a positive definite matrix in units of a force over a length (and a torque).
std::string bushing_text(double size, double length, Random& random) {
  Vec6 scales;
  scales << Vec3::Ones(), Vec3::Constant(length);
  const bool is_diagonal = random.chance(0.5);
  Mat6 matrix = Mat6::Zero();
  for (double& one : matrix.diagonal()) one = random.between(0.3, 1.5);
  if (is_diagonal) {
    const Vec6 numbers = size * scales.cwiseProduct(scales).cwiseProduct(matrix.diagonal());
    return list_text(numbers);
  }
  Mat6 mixed;
  for (int row = 0; row < 6; ++row) mixed.row(row) = random.vector(Eigen::Index{6}, 0.5).transpose();
  const Mat6 symmetric = matrix + mixed * mixed.transpose();
  Mat6 scaled = size * scales.asDiagonal() * symmetric * scales.asDiagonal();
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < row; ++column) scaled(row, column) = scaled(column, row);
  }
  return matrix_text(scaled);
}

void draw(std::type_identity<Bushing> /*kind*/, const Surroundings& around, ElementPlan& plan, Random& random) {
  const auto& [ends, poses, units] = around;
  plan.parent = ends.parent;
  plan.child = ends.child;
  turn_to(plan.child, axes_of(ends.parent, poses) * small_rotation(1.3 / units.stiffer, random), poses);
  if (units.stiffer > 1.0) {  // joins what is nearly there
    const Vec3 near = position_of(ends.parent, poses) + random.vector(0.5 * units.length / units.stiffer);
    plan.child.point = poses[plan.child.body].A.transpose() * (near - poses[plan.child.body].r);
  }
  const double soft = units.force() / units.length * random.log_between(0.3, 20.0);
  const double stiffness = units.stiffer * soft;
  plan.entries.push_back({"stiffness", bushing_text(stiffness, units.length, random)});
  if (random.chance(0.6)) {
    const double damping = 0.1 * units.damped * soft * units.time * random.between(0.2, 2.0);
    plan.entries.push_back({"damping", bushing_text(damping, units.length, random)});
  }
  if (random.chance(0.3)) {
    Vec6 preload;
    preload << random.vector(units.force()), random.vector(units.force() * units.length);
    plan.entries.push_back({"preload", list_text(preload)});
  }
}

/// A spin axis that is level to 0.3 rad, across any direction of travel.
Mat3 wheel_axes(Random& random) {
  return rotation_about(Axis::z, random.between(-3.0, 3.0)) * rotation_about(Axis::x, random.between(-0.3, 0.3)) *
         rotation_about(Axis::y, random.between(-3.0, 3.0));
}

/// A road whose height under x is about `height`.
Entries draw_road(double x, double height, const Units& units, Random& random) {
  switch (random.below(3)) {
    case 0:
      return {{"profile", "\"flat\"", true}, number_entry("height", height)};
    case 1: {
      VecX places(5);
      VecX heights(5);
      for (int k = 0; k < 5; ++k) {
        places(k) = x + units.length * (0.7 * (k - 2) + random.between(-0.1, 0.1));
        heights(k) = height + 0.02 * units.length * random.between(-1.0, 1.0);
      }
      return {{"profile", "\"table\"", true}, {"x", list_text(places), true}, {"height", list_text(heights), true}};
    }
    default:
      return {{"profile", "\"half_sine\"", true},
              number_entry("start", x + units.length * random.between(-0.6, 0.1), true),
              number_entry("length", units.length * random.between(0.3, 0.8), true),
              number_entry("height", 0.02 * units.length * random.between(0.3, 1.0), true)};
  }
}

void draw(std::type_identity<Tire> /*kind*/, const Surroundings& around, ElementPlan& plan, Random& random) {
  const auto& [ends, poses, units] = around;
  plan.child = ends.alone;
  turn_to(plan.child, wheel_axes(random), poses);
  const Vec3 centre = position_of(plan.child, poses);
  const double deflection = units.length * random.between(-0.02, 0.05);
  double radius = units.length * random.between(0.2, 0.8);
  plan.road = draw_road(centre.x(), centre.z() - radius + deflection, units, random);
  // A bump rises from the level z = 0: there the radius has to fit.
  if (plan.road.front().value == "\"half_sine\"") {
    if (centre.z() > 0.1 * units.length) {
      radius = centre.z() + deflection;
    } else {
      plan.road = {{"profile", "\"flat\"", true}, number_entry("height", centre.z() - radius + deflection)};
    }
  }
  const double load = units.force();
  plan.entries = {number_entry("radius", radius, true),
                  number_entry("stiffness", load / units.length * random.between(10.0, 50.0), true),
                  number_entry("slip_stiffness", load * random.between(1.0, 10.0), true),
                  number_entry("cornering_stiffness", load * random.between(1.0, 10.0), true),
                  number_entry("friction", random.between(0.3, 1.2), true),
                  number_entry("speed_scale", 0.3 * units.length / units.time)};
  if (random.chance(0.6)) {
    plan.entries.push_back(number_entry("damping", load * units.time / units.length * random.between(0.1, 1.0)));
  }
}

using Draw = void (*)(const Surroundings& around, ElementPlan& plan, Random& random);

template <class Kind>
void draw_kind(const Surroundings& around, ElementPlan& plan, Random& random) {
  draw(std::type_identity<Kind>{}, around, plan, random);
}

template <class... Kinds>
std::vector<Draw> draws_of(std::type_identity<std::variant<Kinds...>> /*all*/) {
  return {draw_kind<Kinds>...};
}

}  // namespace

ElementPlan draw_element(int kind, const Ends& ends, const std::vector<Pose>& poses, const Units& units,
                         Random& random) {
  static const std::vector<Draw> kDraws = draws_of(std::type_identity<AnyElement>{});
  ElementPlan plan;
  plan.table = element_keys()[static_cast<std::size_t>(kind)];
  kDraws[static_cast<std::size_t>(kind)]({ends, poses, units}, plan, random);
  return plan;
}

}  // namespace concord::compare::fuzz
