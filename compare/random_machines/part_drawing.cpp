#include "compare/random_machines/part_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "common/joints/catalogue.h"
#include "common/joints/named_coordinates.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/referee.h"
#include "compare/random_machines/flexible.h"

namespace concord::compare::fuzz {

namespace {

Vec4 about_z(double angle) { return {std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle)}; }

}  // namespace

double rounded(double value) { return value == 0.0 ? 0.0 : std::stod(fmt::format("{:.2g}", value)); }

Vec3 PartDrawing::draw_point() {
  if (!recipe_.is_aligned) return random_.vector(0.6 * units_.length);
  if (random_.chance(0.3)) return Vec3::Zero();
  const double sign = random_.chance(0.5) ? 1.0 : -1.0;
  const int most = recipe_.is_planar ? 2 : 3;
  return sign * rounded(random_.between(0.2, 1.0) * units_.length) * Vec3::Unit(random_.below(most));
}

Vec4 PartDrawing::draw_frame() {
  if (recipe_.is_planar) return about_z(recipe_.is_aligned ? 0.0 : random_.between(-2.0, 2.0));
  if (!recipe_.is_aligned) return random_.rotation();
  if (random_.chance(0.4)) return Vec4::Unit(0);
  const double half = std::numbers::pi / 4.0 * (1 + random_.below(2));
  Vec4 p = std::cos(half) * Vec4::Unit(0);
  p(1 + random_.below(3)) = std::sin(half);
  return p;
}

BodyPlan PartDrawing::draw_body(int i) {
  BodyPlan body;
  body.name = fmt::format("body{}", i);
  const double spread = recipe_.is_wide ? 300.0 : 4.0;
  body.mass = units_.mass * random_.log_between(1.0 / spread, spread);
  if (recipe_.is_aligned) body.mass = rounded(body.mass);
  const bool is_central = recipe_.is_aligned && random_.chance(0.5);
  body.center_of_mass = is_central ? Vec3(Vec3::Zero()) : Vec3(0.5 * draw_point());
  draw_inertia(body);
  if (random_.chance(recipe_.flexible)) make_flexible(body);
  return body;
}

void PartDrawing::draw_inertia(BodyPlan& body) {
  const double size = body.mass * std::pow(units_.length * random_.between(0.2, 0.5), 2);
  Vec3 second = size * Vec3(random_.between(0.1, 1.0), random_.between(0.1, 1.0), random_.between(0.1, 1.0));
  if (recipe_.is_aligned) {
    if (random_.chance(0.4)) second.setConstant(second(0));
    if (random_.chance(0.3)) second(1) = second(0);
    for (double& one : second) one = rounded(one);
  }
  if (recipe_.is_slender && random_.chance(0.7)) second.tail<2>() *= random_.log_between(1e-6, 1e-1);  // a rod
  const Vec3 principal(second(1) + second(2), second(2) + second(0), second(0) + second(1));
  if (recipe_.is_aligned) {
    body.inertia << principal, Vec3::Zero();
    return;
  }
  const Mat3 A = rotation_of(random_.rotation());
  const Mat3 I = A * principal.asDiagonal() * A.transpose();
  body.inertia << I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
}

void PartDrawing::make_flexible(BodyPlan& body) {
  Units units = units_;
  if (recipe_.is_stiff) {
    units.stiffer = random_.log_between(1.0, 10.0);
    units.damped = random_.log_between(1.0, 100.0);
  }
  body.flexible = random_.chance(0.75) ? draw_beam(body.mass, units, recipe_.is_aligned, random_)
                                       : draw_modes_file(body.mass, units, random_);
  const auto modes = body.flexible->a.size();
  if (recipe_.loops == 0 && !random_.chance(recipe_.resting)) {
    const double size = 0.01 / units.stiffer * units.length * std::sqrt(body.mass);
    body.flexible->a = random_.vector(modes, size);
    body.flexible->adot = random_.vector(modes, size / units.time);
  }
}

End PartDrawing::draw_end(int i, const BodyPlan& body) {
  End end;
  end.body = i;
  end.p = draw_frame();
  end.point = draw_point();
  if (recipe_.is_planar && recipe_.is_aligned) end.point.z() = 0.0;
  if (const auto& flexible = body.flexible) {
    end.node = random_.below(static_cast<int>(flexible->nodes.size()));
    const bool is_on_node = recipe_.is_aligned || random_.chance(0.5);
    end.point = flexible->nodes[end.node] + (is_on_node ? Vec3(Vec3::Zero()) : Vec3(0.2 * end.point));
  }
  return end;
}

const joints::JointType* PartDrawing::draw_type() {
  const auto& all = joints::catalogue();
  if (!recipe_.is_planar) return all[static_cast<std::size_t>(random_.below(static_cast<int>(all.size())))];
  return joints::find("revolute");
}

JointPlan PartDrawing::draw_joint(const joints::JointType* type, std::size_t number) {
  JointPlan joint;
  joint.type = type;
  joint.name = fmt::format("joint{}", number);
  for (const joints::Parameter& parameter : type->parameters) {
    const bool is_length = parameter.unit.starts_with("m");
    const double value = parameter.example * random_.between(0.7, 2.5) * (is_length ? units_.length : 1.0);
    joint.parameters.push_back(recipe_.is_aligned ? rounded(value) : value);
  }
  joint.coordinates.resize(named_coordinates(*type).size());
  joint.keeps_q.assign(type->permits.size(), false);
  joint.keeps_u.assign(type->permits.size(), false);
  draw_coordinates(joint);
  for (int tries = 0; tries < 100 && !is_regular(joint); ++tries) draw_coordinates(joint);
  return joint;
}

void PartDrawing::draw_coordinates(JointPlan& joint) {
  joint.q = VecX::Zero(joint.type->n_q());
  joint.u = VecX::Zero(joint.type->n_u());
  const bool rests = random_.chance(recipe_.resting);
  for (int w = 0; w < static_cast<int>(joint.type->permits.size()); ++w) {
    if (!is_orientation(joint.type->permits[w])) continue;
    joint.q.segment<4>(first_q(*joint.type, w)) = recipe_.is_aligned ? Vec4(Vec4::Unit(0)) : random_.rotation();
    if (!rests) joint.u.segment<3>(first_u(*joint.type, w)) = random_.vector(1.5 / units_.time);
  }
  for (const joint_check::Coordinate& one : joint_check::coordinates_of(*joint.type)) {
    joint.q(one.q) = draw_place(*joint.type, one);
    if (!rests) joint.u(one.u) = random_.between(-1.5, 1.5) * (one.is_turn ? 1.0 : units_.length) / units_.time;
  }
}

double PartDrawing::draw_place(const joints::JointType& type, const joint_check::Coordinate& one) {
  const bool has_range = stated_coordinates(type.permits[one.word])[one.component].range.has_value();
  if (has_range) return random_.between(one.least, one.greatest);
  if (recipe_.is_aligned) {
    const int step = random_.below(7) - 3;
    return one.is_turn ? step * std::numbers::pi / 12.0 : rounded(0.1 * step * units_.length);
  }
  const double reach =
      one.is_turn ? std::min(one.greatest, random_.chance(0.1) ? one.greatest : 1.4) : one.greatest * units_.length;
  return random_.between(-reach, reach);
}

/// Whether the columns of the motion are far from one another.
bool PartDrawing::is_regular(const JointPlan& joint) const {
  constexpr double kLeast = 0.1;
  const joints::JointType type = joint.own_type();
  if (type.n_u() == 0) return true;
  MatX S = referee_permits(type, joint.q, VecX::Zero(type.n_u())).S.leftCols(type.n_u());
  S.topRows<3>() /= units_.length;
  const std::vector<bool> turning = turning_speeds(type);
  for (Eigen::Index c = 0; c < S.cols(); ++c) {
    if (!turning[static_cast<std::size_t>(c)]) S.col(c) *= units_.length;
  }
  return singular_values(S).minCoeff() > kLeast;
}

}  // namespace concord::compare::fuzz
