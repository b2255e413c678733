#include "compare/audit/machine_rank.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "common/products.h"
#include "compare/audit/free_body.h"
#include "compare/audit/motion_audit.h"

namespace concord::compare {

namespace {

constexpr double kThreshold = 1e-10;
constexpr double kSurelyZero = 1e-12;
constexpr double kSurelyKept = 1e-8;
/// Components that all self-stresses move by less than this part of the largest one are unique; the flag is sure where
/// it is so by a margin either way.
constexpr double kUnmoved = 1e-8;
constexpr double kMargin = 30.0;
/// Directions of a joint that are nearer to each other than this have no clear complement.
constexpr double kClearDirections = 1e-6;

/// A unit of each velocity of a body at rest: first those of the origin, then of the turn, then of the modes.
BodyState moving(const BodyState& at, Eigen::Index velocity, double unit) {
  BodyState body = at;
  body.v.setZero();
  body.omega.setZero();
  body.adot = VecX::Zero(at.a.size());
  if (velocity < 0) return body;
  if (velocity < 3) {
    body.v(velocity) = unit;
  } else if (velocity < 6) {
    body.omega(velocity - 3) = unit;
  } else {
    body.adot(velocity - 6) = unit;
  }
  return body;
}

/// Orthonormal columns across all of `directions`; false if these are not clearly independent.
bool complement(Mat6X directions, Mat6X& across) {
  const Eigen::Index n = directions.cols();
  for (Eigen::Index c = 0; c < n; ++c) {
    const double size = directions.col(c).norm();
    if (size > 0.0) directions.col(c) /= size;
  }
  if (n == 0) {
    across = Mat6::Identity();
    return true;
  }
  across = orthogonal_completion(directions).rightCols(6 - n);
  return singular_values(directions).minCoeff() > kClearDirections;
}

/// The largest that a unit of a mode moves or turns at any joint, in parts of the length; zero if that is round-off of
/// the shape, as where the mode has a node of vibration.
VecX sizes_of_modes(const Model& model, int body, double length) {
  constexpr double kNodeOfVibration = 1e-9;
  VecX sizes = VecX::Zero(model.bodies[body].n_modes());
  if (sizes.size() == 0) return sizes;
  for (const Joint& joint : model.joints) {
    for (const Attachment& side : joint.sides) {
      if (side.body != body) continue;
      for (Eigen::Index m = 0; m < sizes.size(); ++m) {
        sizes(m) = std::max({sizes(m), side.Psi_t_L.col(m).norm() / length, side.Psi_r_L.col(m).norm()});
      }
    }
  }
  const VecX anywhere = largest_ways(model.bodies[body], length) / length;
  return (sizes.array() > kNodeOfVibration * anywhere.array()).select(sizes, 0.0);
}

}  // namespace

MachineConstraints::MachineConstraints(const Model& model, const State& state)
    : model_(model), length_(model.length_scale()) {
  lay_out_velocities();
  lay_out_owners(state);
  add_multipliers();
  forces_ = MatX::Zero(units_.size(), static_cast<Eigen::Index>(owners_.size()));
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    forces_ += transposed_product(velocities_of(k, state), joints_[k].reaction + joints_[k].coordinate);
  }
  normalize();
  decompose();
}

void MachineConstraints::lay_out_velocities() {
  Eigen::Index n = 0;
  for (const Body& body : model_.bodies) {
    first_.push_back(n);
    if (first_.size() > 1) n += 6 + body.n_modes();
  }
  units_ = VecX::Ones(n);
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    const VecX sizes = sizes_of_modes(model_, static_cast<int>(i), length_);
    for (Eigen::Index m = 0; m < sizes.size(); ++m) {
      if (sizes(m) > 0.0) units_(first_[i] + 6 + m) = 1.0 / sizes(m);
    }
  }
}

/// Joints, then drivers, then couplings.
void MachineConstraints::lay_out_owners(const State& state) {
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    const Joint& joint = model_.joints[k];
    AtJoint& at = joints_.emplace_back();
    at.relative = relative_motion_of(joint, state);
    motions_.push_back(read_motion(*joint.type, at.relative, k < state.q.size() ? state.q[k] : VecX()));
    owners_.insert(owners_.end(), static_cast<std::size_t>(6 - motions_.back().free.cols()), "joint " + joint.name);
  }
  for (const Joint& joint : model_.joints) {
    owners_.insert(owners_.end(), joint.drivers.size(), "driver of joint " + joint.name);
  }
  for (const Coupling& coupling : model_.couplings) {
    couplings_.push_back(static_cast<Eigen::Index>(owners_.size()));
    owners_.push_back("coupling " + coupling.name);
  }
}

/// In the order of the owners.
void MachineConstraints::add_multipliers() {
  const auto columns = static_cast<Eigen::Index>(owners_.size());
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    AtJoint& at = joints_[k];
    at.reaction = at.coordinate = Mat6X::Zero(6, columns);
    at.tau = at.driver = MatX::Zero(model_.joints[k].type->n_u(), columns);
    Mat6X across;
    is_sure_ = complement(permitted_by(static_cast<int>(k)), across) && is_sure_;
    at.reaction.middleCols(next, across.cols()) = across;
    next += across.cols();
  }
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const Joint& joint = model_.joints[k];
    for (const Driver& driver : joint.drivers) {
      const int speed = first_u(*joint.type, driver.word) + driver.component;
      add_coordinate_force(static_cast<int>(k), speed, 1.0, next);
      joints_[k].driver(speed, next++) = 1.0;
    }
  }
  for (const Coupling& coupling : model_.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      const joints::JointType& type = *model_.joints[term.joint].type;
      add_coordinate_force(term.joint, first_u(type, term.word) + term.component, term.factor, next);
    }
    ++next;
  }
}

/// The coordinate wrench of a force on one speed of a joint.
void MachineConstraints::add_coordinate_force(int joint, int speed, double factor, Eigen::Index column) {
  AtJoint& at = joints_[joint];
  const Mat6X& S = motions_[joint].S;
  const Mat6X span = coordinate_wrench_directions(*model_.joints[joint].type, at.relative, S);
  const VecX shares = solve_by_complete_pivoting(transposed_product(S, span), factor * VecX::Unit(S.cols(), speed));
  Vec6 wrench = span * shares;
  wrench.head<3>() *= length_;
  at.coordinate.col(column) += wrench;
  at.tau(speed, column) += factor;
}

/// v_rel of a joint for a unit of each velocity of the machine, displacements in lengths: they are linear in them.
Mat6X MachineConstraints::velocities_of(std::size_t k, const State& state) const {
  const Joint& joint = model_.joints[k];
  Mat6X velocities = Mat6X::Zero(6, units_.size());
  for (const Side side : kSides) {
    const int body = joint.on(side).body;
    if (body == kGround) continue;
    const int other = joint.on(side == Side::child ? Side::parent : Side::child).body;
    const PlacedFrame at_rest =
        place(joint.on(side == Side::child ? Side::parent : Side::child), moving(state.bodies[other], -1, 0.0));
    for (Eigen::Index c = 0; c < 6 + model_.bodies[body].n_modes(); ++c) {
      const Eigen::Index column = first_[body] + c;
      const double unit = c < 3 ? length_ : units_(column);
      const PlacedFrame moved = place(joint.on(side), moving(state.bodies[body], c, unit));
      velocities.col(column) +=
          (side == Side::child ? relative_motion(at_rest, moved) : relative_motion(moved, at_rest)).v_rel;
    }
  }
  velocities.topRows<3>() /= length_;
  return velocities;
}

/// Multipliers that do as much as a force of unit size.
void MachineConstraints::normalize() {
  sizes_ = VecX::Ones(forces_.cols());
  for (Eigen::Index c = 0; c < forces_.cols(); ++c) {
    const double size = forces_.col(c).norm();
    if (!(size > 0.0)) continue;
    sizes_(c) = size;
    forces_.col(c) /= size;
    for (AtJoint& at : joints_) {
      at.reaction.col(c) /= size;
      at.coordinate.col(c) /= size;
      if (at.tau.rows() == 0) continue;
      at.tau.col(c) /= size;
      at.driver.col(c) /= size;
    }
  }
}

void MachineConstraints::decompose() {
  const Eigen::Index n = forces_.cols();
  const Svd all = svd_of(n > 0 ? forces_ : MatX::Zero(forces_.rows(), 1));
  const VecX sigma = all.sigma / std::max(all.sigma.maxCoeff(), 1.0);
  const auto rank = static_cast<Eigen::Index>((sigma.array() > kThreshold).count());
  report_.constraints = static_cast<int>(n);
  report_.rank = static_cast<int>(rank);
  report_.degrees_of_freedom = static_cast<int>(forces_.rows() - rank);
  report_.undecided = (sigma.array() > kSurelyZero && sigma.array() < kSurelyKept).any();
  report_.smallest_kept = rank > 0 ? sigma(rank - 1) : 0.0;
  report_.largest_dropped = rank < sigma.size() ? sigma(rank) : 0.0;
  is_sure_ = is_sure_ && !report_.undecided && forces_.allFinite();
  permitted_ = all.U.rightCols(forces_.rows() - rank);
  self_stresses_ = n > 0 ? MatX(all.V.rightCols(n - rank)) : MatX::Zero(0, 0);
  mark_unique();
  name_self_stressed();
}

/// Wrenches on a side of a joint in that side's frame, forces times the length.
MatX MachineConstraints::on_side(const AtJoint& at, Side side, const Mat6X& wrenches) const {
  MatX there = wrenches;
  if (side == Side::child) {
    const Mat3 to_child = at.relative.R.transpose();
    there.topRows(3) = to_child * wrenches.topRows<3>();
    there.bottomRows(3) = to_child * wrenches.bottomRows<3>();
    return there;
  }
  const Vec3 d = at.relative.d / length_;
  for (Eigen::Index c = 0; c < there.cols(); ++c) {
    there.col(c).tail<3>() += d.cross(Vec3(wrenches.col(c).head<3>()));
  }
  return there;
}

/// What all self-stresses move at a joint, component by component.
MachineConstraints::Moved MachineConstraints::moved_at(std::size_t k) const {
  Moved moved;
  const Mat6X reaction = product(joints_[k].reaction, self_stresses_);
  const Mat6X total = reaction + product(joints_[k].coordinate, self_stresses_);
  for (const Side side : kSides) {
    moved.reaction[index(side)] = on_side(joints_[k], side, reaction).rowwise().norm();
    moved.total[index(side)] = on_side(joints_[k], side, total).rowwise().norm();
  }
  moved.tau = product(joints_[k].tau, self_stresses_).rowwise().norm();
  moved.driver = product(joints_[k].driver, self_stresses_).rowwise().norm();
  const std::vector<bool> turns = turning_speeds(*model_.joints[k].type);
  for (Eigen::Index c = 0; c < moved.tau.size(); ++c) {
    if (turns[static_cast<std::size_t>(c)]) continue;
    moved.tau(c) *= length_;
    moved.driver(c) *= length_;
  }
  return moved;
}

void MachineConstraints::mark_unique() {
  report_.joints.resize(joints_.size());
  report_.decided.resize(joints_.size());
  report_.unique_coupling.assign(couplings_.size(), true);
  report_.decided_coupling.assign(couplings_.size(), true);
  if (self_stresses_.cols() == 0) return;
  std::vector<Moved> moved;
  double largest = 0.0;
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    moved.push_back(moved_at(k));
    for (const VecX& total : moved.back().total) largest = std::max(largest, total.maxCoeff());
  }
  for (const Eigen::Index column : couplings_) largest = std::max(largest, self_stresses_.row(column).norm());
  largest_moved_ = largest;
  const double least = unmoved();
  const auto is_clear = [least](double size) { return size < least / kMargin || size > least * kMargin; };
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    JointUniqueness& unique = report_.joints[k];
    JointUniqueness& decided = report_.decided[k];
    for (int side = 0; side < 2; ++side) {
      for (int c = 0; c < 6; ++c) {
        unique.unique[side][c] = moved[k].reaction[side](c) <= least;
        decided.unique[side][c] = is_clear(moved[k].reaction[side](c));
        unique.unique_total[side][c] = moved[k].total[side](c) <= least;
        decided.unique_total[side][c] = is_clear(moved[k].total[side](c));
      }
    }
    for (int c = 0; c < moved[k].tau.size(); ++c) {
      unique.unique_tau[c] = moved[k].tau(c) <= least;
      decided.unique_tau[c] = is_clear(moved[k].tau(c));
      unique.unique_driver[c] = moved[k].driver(c) <= least;
      decided.unique_driver[c] = is_clear(moved[k].driver(c));
    }
  }
  for (std::size_t g = 0; g < couplings_.size(); ++g) {
    const double size = self_stresses_.row(couplings_[g]).norm();
    report_.unique_coupling[g] = size <= least;
    report_.decided_coupling[g] = is_clear(size);
  }
}

void MachineConstraints::name_self_stressed() {
  constexpr double kTakesPart = 1e-6;
  for (Eigen::Index c = 0; c < self_stresses_.rows(); ++c) {
    const std::string& owner = owners_[static_cast<std::size_t>(c)];
    if (self_stresses_.row(c).norm() < kTakesPart) continue;
    if (in_self_stress_.empty() || in_self_stress_.back() != owner) in_self_stress_.push_back(owner);
  }
}

double MachineConstraints::unmoved() const { return kUnmoved * largest_moved_; }

Mat6X MachineConstraints::reactions_on(int joint, Side side) const {
  return on_side(joints_[joint], side, joints_[joint].reaction);
}

Mat6X MachineConstraints::permitted_by(int joint) const {
  Mat6X directions = product(motions_[joint].S, motions_[joint].free);
  directions.topRows<3>() /= length_;
  return directions;
}

Mat6X MachineConstraints::stresses_of(int joint) const { return product(joints_[joint].reaction, self_stresses_); }

SpanOfVelocities MachineConstraints::hold_against(const MatX& velocities) const {
  constexpr double kObeyed = 1e-8;
  constexpr double kContained = 1e-6;
  SpanOfVelocities span;
  if (velocities.cols() > 0) {
    const MatX in_units = orthonormal_columns(units_.cwiseInverse().asDiagonal() * velocities);
    const MatX misfits = transposed_product(forces_, in_units);
    for (Eigen::Index row = 0; row < misfits.rows(); ++row) {
      const double misfit = misfits.row(row).norm();
      if (!(misfit > span.misfit)) continue;
      span.misfit = misfit;
      span.worst = owners_[static_cast<std::size_t>(row)];
    }
    span.holds_nothing_else = span.misfit < kObeyed;
    const MatX left = outside_span(in_units, permitted_);
    span.holds_all = permitted_.cols() == 0 || left.colwise().norm().maxCoeff() < kContained;
  } else {
    span.holds_all = permitted_.cols() == 0;
  }
  return span;
}

std::string place_left_open(const Model& model, const State& state) {
  constexpr double kOpen = 1e-7;
  MotionAudit audit(model);
  Evaluation nothing;
  nothing.bodies.resize(model.bodies.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    nothing.bodies[i].addot = VecX::Zero(model.bodies[i].n_modes());
  }
  audit.add(state, nothing);
  std::string worst;
  double largest = kOpen;
  const auto look_at = [&](const std::vector<AuditEntity>& all, const char* kind) {
    for (const AuditEntity& entity : all) {
      for (const AuditRow& row : entity.rows) {
        if (row.name.find("acceleration") != std::string::npos || row.rule == AuditRule::derivatives) continue;
        if (!(row.residual > largest * row.scale)) continue;
        largest = row.residual / row.scale;
        worst = kind + entity.name;
      }
    }
  };
  look_at(audit.joints(), "joint ");
  look_at(audit.couplings(), "coupling ");
  return worst;
}

}  // namespace concord::compare
