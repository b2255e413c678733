#include "relative/bodies/velocity_transformation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "relative/bodies/exponential_map.h"

namespace concord::relative {

Vec6 relative_velocity(const JointPoint& parent, const JointPoint& child) {
  Vec6 v_rel;
  v_rel.head<3>() = parent.A.transpose() * (child.v - parent.v - parent.omega.cross(child.r - parent.r));
  v_rel.tail<3>() = parent.A.transpose() * (child.omega - parent.omega);
  return v_rel;
}

Kinematics::Kinematics(const Model& model)
    : model_(&model),
      topology_(build_topology(model)),
      size_(model, topology_),
      joint_motions_(model.joints.size()),
      bodies_(model.bodies.size()),
      first_rows_(model.bodies.size(), 0),
      turns_(VecX::Zero(topology_.n_q)),
      q_(VecX::Zero(topology_.n_q)),
      u_(VecX::Zero(topology_.n_u)) {
  for (const Joint& joint : model.joints) {
    mobilizers_.emplace_back(*joint.type, size_.length());
    for (const Attachment& side : joint.sides) {
      points_.emplace_back(fmt::format("joint '{}'", joint.name), topology_.from_reference_point(side));
    }
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const VecX home = mobilizers_[k].home();
    mobilizers_[k].evaluate(home.data(), VecX::Zero(mobilizers_[k].n_u()).eval().data(), joint_motions_[k]);
  }
  for (const Link& link : topology_.links) {
    LinkBlocks blocks;
    blocks.Xa.setZero(6, model.bodies[link.reference].n_modes());
    blocks.Ha.setZero(6, model.bodies[link.body].n_modes());
    blocks_.push_back(blocks);
  }
  lay_out_places();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    first_rows_[i] = n_rows_;
    n_rows_ += 6 + model.bodies[i].n_modes();
  }
}

void Kinematics::lay_out_places() {
  for (const LinkIndex l : upward<LinkIndex>(topology_.links.size())) {
    const Link& link = topology_.links[l];
    const Span& span = topology_.joints[link.joint];
    const bool is_flexible = topology_.modes[link.body].n_u + topology_.modes[link.reference].n_u > 0;
    places_.push_back({&mobilizers_[link.joint], &joint_motions_[link.joint],
                       &moving_point(link.joint, link.reference_side()), &moving_point(link.joint, link.own_side()),
                       &bodies_[link.reference], &bodies_[link.body], &blocks_[l], span.first_q, span.first_u,
                       mobilizers_[link.joint].only_turn(), link.along ? 1.0 : -1.0, is_flexible});
  }
}

void Kinematics::count_turns(const VecX& turns) {
  turns_ = turns;
  for (std::size_t k = 0; k < mobilizers_.size(); ++k)
    mobilizers_[k].count_turns(turns.data() + topology_.joints[k].first_q);
}

VecX Kinematics::with_turns(const VecX& q) const {
  return VecX::NullaryExpr(q.size(), [&](Eigen::Index c) { return with_turns(static_cast<int>(c), q(c)); });
}

VecX Kinematics::without_turns(const VecX& values) const {
  return VecX::NullaryExpr(values.size(),
                           [&](Eigen::Index c) { return without_turns(static_cast<int>(c), values(c)); });
}

VecX Kinematics::whole_turns(const VecX& q, double least) const {
  VecX turns = VecX::Zero(q.size());
  for (std::size_t k = 0; k < mobilizers_.size(); ++k) {
    for (int c = 0; c < mobilizers_[k].n_u(); ++c) {
      if (!mobilizers_[k].is_turn(c)) continue;
      const int place = topology_.joints[k].first_q + c;
      const double made = q(place) / static_cast<double>(kWholeTurn);
      if (std::abs(made) > least) turns(place) = std::round(made);
    }
  }
  return turns;
}

void Kinematics::update(const VecX& q, const VecX& u) {
  q_ = q;
  u_ = u;
  for (const LinkIndex l : upward<LinkIndex>(places_.size())) {
    if (places_[l].only_turn >= 0) {
      update_turning_link(l);
    } else {
      update_link(l);
    }
  }
  place_cut_joint_points();
}

void Kinematics::require_rank(JointIndex joint, const JointMotion& motion) const {
  if (!mobilizers_[joint].loses_rank(motion)) return;
  throw SingularPose(
      fmt::format("relative: joint '{}' ({}): its coordinates are singular in this pose, where two of its motions are "
                  "one: turn its frame on the parent, so that the machine stays away from there",
                  model_->joints[joint].name, model_->joints[joint].type->name));
}

void Kinematics::place(const std::vector<BodyState>& bodies) {
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const BodyState& body = bodies[i];
    const Mat3 A = rotation_from_euler_parameters(body.p);
    const Vec3 to_reference_point = A * topology_.reference_points_L[i];
    bodies_[i] = {body.r + to_reference_point, A, body.v + body.omega.cross(to_reference_point), body.omega};
    const Span& modes = topology_.modes[i];
    q_.segment(modes.first_q, modes.n_q) = body.a;
    u_.segment(modes.first_u, modes.n_u) = body.adot;
  }
  for (const JointIndex k : upward<JointIndex>(model_->joints.size())) {
    for (const Side side : {Side::parent, Side::child}) {
      deform(k, side);
      moving_point(k, side).compute_point_motion(bodies_[model_->joints[k].on(side).body]);
    }
  }
}

BodyMotion Kinematics::motion_of_origin(BodyIndex i) const {
  BodyMotion motion = bodies_[i];
  const Vec3 to_origin = -(motion.A * topology_.reference_points_L[i]);
  motion.r += to_origin;
  motion.v += motion.omega.cross(to_origin);
  return motion;
}

Vec6 Kinematics::acceleration_of_origin(BodyIndex i, const Vec6& Vdot) const {
  const BodyMotion& motion = bodies_[i];
  const Vec3 to_origin = -(motion.A * topology_.reference_points_L[i]);
  Vec6 moved = shift_motion(Vdot, to_origin);
  moved.head<3>() += motion.omega.cross(motion.omega.cross(to_origin));
  return moved;
}

double Kinematics::farthest_place() const {
  double farthest = 0.0;
  for (const BodyIndex i : upward<BodyIndex>(bodies_.size())) {
    farthest = std::max(farthest, motion_of_origin(i).r.cwiseAbs().maxCoeff());
  }
  return farthest;
}

void Kinematics::deform(JointIndex joint, Side side) {
  const Span& modes = topology_.modes[model_->joints[joint].on(side).body];
  moving_point(joint, side).deform(q_.data() + modes.first_q, u_.data() + modes.first_u);
}

void Kinematics::deform_both_sides(const Link& link) {
  deform(link.joint, Side::parent);
  deform(link.joint, Side::child);
}

void Kinematics::update_link(LinkIndex l) {
  const LinkPlaces& at = places_[l];
  const Link& link = topology_.links[l];
  at.mobilizer->evaluate(q_.data() + at.first_q, u_.data() + at.first_u, *at.motion);
  require_rank(link.joint, *at.motion);
  if (at.is_flexible) deform_both_sides(link);
  at.reference->compute_point_motion(*at.reference_body);
  JointStep step;
  if (link.along) {
    place_child_side(link, step);
  } else {
    place_parent_side(link, step);
  }
  at.own->compute_body_motion(*at.body);
  compute_blocks(l, step);
}

/// All of it in closed form where the joint can do nothing but turn: the points coincide, the frame's other axes mix,
/// and Sdot u vanishes.
void Kinematics::update_turning_link(LinkIndex l) {  // (R80)
  const LinkPlaces& at = places_[l];
  const int axis = at.only_turn;
  const double speed = u_(at.first_u);
  const auto [sine, cosine] = at.mobilizer->turn_again(q_(at.first_q), speed, *at.motion);
  if (at.is_flexible) deform_both_sides(topology_.links[l]);
  JointPoint& reference = *at.reference;
  JointPoint& own = *at.own;
  reference.compute_point_motion(*at.reference_body);
  const int second = axis == 2 ? 0 : axis + 1;
  const int third = axis == 0 ? 2 : axis - 1;
  const double signed_sine = at.sign * sine;
  const Vec3 b = reference.A.col(second);
  const Vec3 n = reference.A.col(third);
  const Vec3 along_axis = reference.A.col(axis);
  own.A.col(second) = cosine * b + signed_sine * n;
  own.A.col(third) = cosine * n - signed_sine * b;
  own.A.col(axis) = along_axis;
  const Vec3 turn = at.sign * along_axis;
  const Vec3 spin = turn * speed;  // of this body against its reference
  own.r = reference.r;
  own.v = reference.v;
  own.omega = reference.omega + spin;
  own.compute_body_motion(*at.body);

  LinkBlocks& blocks = *at.blocks;
  blocks.rho = reference.lever - own.lever;
  blocks.H.col(0).tail<3>() = turn;
  // The parent's omega differs from the reference's by the spin at most, whose cross product with itself vanishes.
  const Vec3 turning = cross(reference.omega, spin) + reference.bias.tail<3>() - own.bias.tail<3>();
  blocks.D.head<3>() = reference.bias.head<3>();
  blocks.D.tail<3>() = turning;
  if (own.is_reference_point() && !at.is_flexible) return;
  const Vec3 from_own = -own.lever;
  blocks.H.col(0).head<3>() = cross(turn, from_own);
  blocks.D.head<3>() += cross(turning, from_own) - own.bias.head<3>();
  if (at.is_flexible) shift_modes(l, from_own, from_own);
}

void Kinematics::take_joint_step(const Link& link, JointStep& step) const {
  const JointMotion& motion = joint_motions_[link.joint];
  const Mat3& A = point(link.joint, Side::parent).A;
  multiply(A, motion.v_rel.data() + 3, step.spin.data());
  if (!mobilizers_[link.joint].has_place()) return;
  multiply(A, motion.d.data(), step.d.data());
  multiply(A, motion.v_rel.data(), step.sliding_velocity.data());
}

void Kinematics::place_child_side(const Link& link, JointStep& step) {  // (R15)
  const JointPoint& parent = point(link.joint, Side::parent);
  JointPoint& child = moving_point(link.joint, Side::child);
  take_joint_step(link, step);
  multiply(parent.A, joint_motions_[link.joint].R, child.A);
  child.r = parent.r + step.d;
  child.omega = parent.omega + step.spin;
  child.v = parent.v + cross(parent.omega, step.d) + step.sliding_velocity;
}

void Kinematics::place_parent_side(const Link& link, JointStep& step) {  // (R16)
  JointPoint& parent = moving_point(link.joint, Side::parent);
  const JointPoint& child = point(link.joint, Side::child);
  multiply_transpose(child.A, joint_motions_[link.joint].R, parent.A);
  take_joint_step(link, step);
  parent.r = child.r - step.d;
  parent.omega = child.omega - step.spin;
  parent.v = child.v - cross(parent.omega, step.d) - step.sliding_velocity;
}

/// The columns of S that are the same in every pose are axes of the parent's joint frame.
void Kinematics::compute_columns(LinkIndex l, const Vec3& from_child) {
  const Link& link = topology_.links[l];
  const Mobilizer& mobilizer = mobilizers_[link.joint];
  const JointMotion& motion = joint_motions_[link.joint];
  const Mat3& A = point(link.joint, Side::parent).A;
  for (int c = 0; c < mobilizer.n_u(); ++c) {
    const ColumnKind& kind = mobilizer.kind(c);
    double* column = blocks_[l].H.col(c).data();
    Vec3 place = Vec3::Zero();
    Vec3 turn = Vec3::Zero();
    if (kind.is_fixed) {
      (kind.displaces ? place : turn) = A.col(kind.axis);
    } else {
      if (kind.displaces) multiply(A, motion.S.col(c).data(), place.data());
      if (kind.rotates) multiply(A, motion.S.col(c).data() + 3, turn.data());
    }
    const Vec3 linear = kind.rotates ? Vec3(cross(turn, from_child) + place) : place;
    for (int row = 0; row < 3; ++row) {
      column[row] = link.along ? linear(row) : -linear(row);
      column[3 + row] = link.along ? turn(row) : -turn(row);
    }
  }
}

/// The joint contributes the velocity of the child's point seen from the parent's frame, plus or minus by the direction
/// of the tree; everything is then moved to the reference point of the link's body (R20), (R21). Levers are sums of the
/// link's own lengths, not differences of places, which far from the ground's origin would hold the round-off of these.
void Kinematics::compute_blocks(LinkIndex l, const JointStep& step) {
  const Link& link = topology_.links[l];
  LinkBlocks& blocks = blocks_[l];
  const JointMotion& motion = joint_motions_[link.joint];
  const Mobilizer& mobilizer = mobilizers_[link.joint];
  const JointPoint& parent = point(link.joint, Side::parent);
  const JointPoint& own = point(link.joint, link.own_side());
  const JointPoint& reference = point(link.joint, link.reference_side());
  const Vec3 from_own = -own.lever;  // to the body's reference point
  const Vec3 from_reference = link.along ? Vec3(from_own + step.d) : Vec3(from_own - step.d);
  const Vec3& from_child = link.along ? from_own : from_reference;
  blocks.rho = from_reference + reference.lever;
  compute_columns(l, from_child);

  Vec6 joint_bias;
  joint_bias.head<3>().setZero();
  joint_bias.tail<3>() = cross(parent.omega, step.spin);
  if (mobilizer.has_place()) {
    const Vec3& sliding_velocity = step.sliding_velocity;
    joint_bias.head<3>() = cross(parent.omega, cross(parent.omega, step.d) + 2.0 * sliding_velocity);
  }
  if (mobilizer.is_curved()) joint_bias.head<3>() += times(parent.A, motion.Sdot_u.head<3>());
  joint_bias.tail<3>() += times(parent.A, motion.Sdot_u.tail<3>());
  const Vec6 of_joint = shift_motion(joint_bias, from_child);
  blocks.D = shift_motion(reference.bias, from_reference) - shift_motion(own.bias, from_own);
  if (link.along) {
    blocks.D += of_joint;
  } else {
    blocks.D -= of_joint;
  }
  if (places_[l].is_flexible) shift_modes(l, from_reference, from_own);
}

void Kinematics::shift_modes(LinkIndex l, const Vec3& from_reference, const Vec3& from_own) {
  const Link& link = topology_.links[l];
  const auto shift_columns = [](const Mat6X& G, const Vec3& e, Mat6X& moved) {
    for (Eigen::Index c = 0; c < G.cols(); ++c) moved.col(c) = shift_motion(G.col(c), e);
  };
  LinkBlocks& blocks = blocks_[l];
  if (blocks.Xa.cols() > 0) shift_columns(point(link.joint, link.reference_side()).Ga(), from_reference, blocks.Xa);
  if (blocks.Ha.cols() > 0) shift_columns(point(link.joint, link.own_side()).Ga(), from_own, blocks.Ha);
}

void Kinematics::place_cut_joint_points() {
  for (const JointIndex k : topology_.cuts) {
    for (const Side side : {Side::parent, Side::child}) {
      deform(k, side);
      moving_point(k, side).compute_point_motion(bodies_[model_->joints[k].on(side).body]);
    }
  }
}

void Kinematics::add_times_B(BodyIndex body, MatX rows_on_body, MatX& rows) const {
  for (std::optional<LinkIndex> l = topology_.link_of_body[body]; l; l = topology_.inward_link(*l)) {
    const Link& link = topology_.links[*l];
    const LinkBlocks& b = blocks_[*l];
    const Span& joint = topology_.joints[link.joint];
    const Span& modes = topology_.modes[link.body];
    if (modes.n_u > 0) rows.middleCols(modes.first_u, modes.n_u) += rows_on_body.rightCols(modes.n_u);
    if (modes.n_u != b.Xa.cols()) rows_on_body.conservativeResize(Eigen::NoChange, 6 + b.Xa.cols());
    for (Eigen::Index row = 0; row < rows.rows(); ++row) {
      const Vec6 w = rows_on_body.row(row).head<6>();
      for (int c = 0; c < joint.n_u; ++c) rows(row, joint.first_u + c) += w.dot(b.H.col(c));
      for (int c = 0; c < modes.n_u; ++c) rows(row, modes.first_u + c) -= w.dot(b.Ha.col(c));
      for (Eigen::Index c = 0; c < b.Xa.cols(); ++c) rows_on_body(row, 6 + c) = w.dot(b.Xa.col(c));
      rows_on_body.row(row).head<6>() = shift_wrench(w, b.rho);
    }
  }
}

MatX Kinematics::explicit_B() const {
  MatX B = MatX::Zero(n_rows_, topology_.n_tree_u);
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const int size = 6 + topology_.modes[i].n_u;
    MatX rows = MatX::Zero(size, topology_.n_tree_u);
    add_times_B(BodyIndex(i), MatX::Identity(size, size), rows);
    B.middleRows(first_rows_[i], size) = rows;
  }
  return B;
}

MatX Kinematics::explicit_B_of_origins() const {
  MatX B = explicit_B();
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Vec3 to_origin = -(bodies_[i].A * topology_.reference_points_L[i]);
    for (Eigen::Index c = 0; c < B.cols(); ++c) {
      auto V = B.col(c).segment<6>(first_rows_[i]);
      V = shift_motion(V, to_origin);
    }
  }
  return B;
}

VecX Kinematics::Bdot_u() const {
  VecX result = VecX::Zero(n_rows_);
  for (std::size_t l = 0; l < topology_.links.size(); ++l) {
    const Link& link = topology_.links[l];
    Vec6 acceleration = blocks_[l].D;
    if (link.reference != kGround) {
      const Vec6 of_reference = result.segment<6>(first_rows_[link.reference]);
      acceleration += shift_motion(of_reference, blocks_[l].rho);
    }
    result.segment<6>(first_rows_[link.body]) = acceleration;
  }
  return result;
}

VecX Kinematics::Y() const {
  VecX result(n_rows_);
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Span& modes = topology_.modes[i];
    result.segment(first_rows_[i], 6 + modes.n_u) << bodies_[i].v, bodies_[i].omega,
        u_.segment(modes.first_u, modes.n_u);
  }
  return result;
}

}  // namespace concord::relative
