#include "relative/dynamics/reactions.h"

#include <cstring>

#include "relative/bodies/velocity_transformation.h"

namespace concord::relative {

Reactions::Reactions(const Kinematics& kinematics, const Closure& closure)
    : kinematics_(&kinematics),
      closure_(&closure),
      is_driven_(kinematics.model().joints.size(), 0),
      tau_of_springs_(VecX::Zero(kinematics.topology().n_u)) {
  found_.couplings.assign(kinematics.model().couplings.size(), 0.0);
  found_.coupling_tau.setZero(kinematics.topology().n_u);
  const Model& model = kinematics.model();
  for (const Link& link : kinematics.topology().links) {
    Load load;
    load.rho_a.setZero(model.bodies[link.body].n_modes());
    load.reference = kinematics.topology().inward_link(LinkIndex(loads_.size()));
    load.acts_at_one_point = !kinematics.mobilizer(link.joint).has_place();
    loads_.push_back(load);
  }
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
    const Joint& joint = model.joints[k];
    JointWrenches wrenches;
    is_driven_[k.value()] = joint.drivers.empty() ? 0 : 1;
    wrenches.tau.setZero(joint.type->n_u());
    wrenches.shares.fill(wrenches.tau);
    found_.joints.push_back(wrenches);
    if (joint.drivers.empty() && joint.springs.empty() && !model.is_coupled(k)) continue;
    ForcedJoint forced{k, cut_of(kinematics.topology().places[k]), std::nullopt, {}};
    for (const Driver& driver : joint.drivers) {
      forced.driven.push_back(first_u(*joint.type, driver.word) + driver.component);
    }
    for (std::size_t r = 0; r < closure.speed_constraints().size(); ++r) {
      const SpeedConstraint& constraint = closure.speed_constraints()[r];
      if (constraint.is_coupling() || constraint.joints.front().joint != forced.joint) continue;
      forced.nonholonomic = static_cast<int>(r);
    }
    forced_joints_.push_back(forced);
  }
}

const JointReactions& Reactions::compute(const std::vector<BodyInertia>& inertias,
                                         const TreeAccelerations& accelerations, const AppliedForces& applied,
                                         const VecX& lambda) {
  reports_all_ = true;
  balance(inertias, accelerations, applied, lambda);
  split_off_coordinate_wrenches(lambda);  // reactions: (R60)
  return found_;
}

const JointReactions& Reactions::compute_driver_forces(const std::vector<BodyInertia>& inertias,
                                                       const TreeAccelerations& accelerations,
                                                       const AppliedForces& applied, const VecX& lambda) {
  reports_all_ = false;
  balance(inertias, accelerations, applied, lambda);
  for (const ForcedJoint& forced : forced_joints_) set_driver_forces(forced, lambda);
  return found_;
}

/// The totals of joints.
void Reactions::balance(const std::vector<BodyInertia>& inertias, const TreeAccelerations& accelerations,
                        const AppliedForces& applied, const VecX& lambda) {
  load_inertia(inertias, accelerations);  // Step 1: (R54)
  subtract_applied(applied);              // Step 2: (R55)
  set_spring_forces(applied);
  set_coupling_forces(lambda);
  add_coupling_forces();
  apply_cut_wrenches(lambda);  // Step 3: (R56)
  apply_speed_constraint_wrenches(lambda);
  add_spring_wrenches_of_cuts(applied);
  backward_pass();  // Steps 4 and 5: (R57), (R58)
}

const JointReactions& Reactions::compute_self_stress(const VecX& lambda) {
  reports_all_ = true;
  clear_loads();
  set_coupling_forces(lambda);
  add_coupling_forces();
  apply_cut_wrenches(lambda);
  apply_speed_constraint_wrenches(lambda);
  backward_pass();
  split_off_coordinate_wrenches(lambda);
  return found_;
}

/// rho = M Ydot + S + U - Q_gravity (R54).
void Reactions::load_inertia(const std::vector<BodyInertia>& inertias, const TreeAccelerations& accelerations) {
  for (const LinkIndex l : upward<LinkIndex>(loads_.size())) {
    const BodyInertia& inertia = inertias[l];
    const Vec6& Vdot = accelerations.of_link(l);
    Load& load = loads_[l];
    load.rho = inertia.moments().times(Vdot) + inertia.p();
    const FlexibleInertia* flexible = inertia.flexible();
    if (flexible == nullptr) continue;
    const VecX& addot = *accelerations.of_modes(kinematics_->topology().links[l].body);
    load.rho.noalias() += flexible->M_ra().lazyProduct(addot);
    load.rho_a = flexible->p_a();
    load.rho_a.noalias() += flexible->M_ra().transpose().lazyProduct(Vdot);
    load.rho_a.noalias() += flexible->M_aa().lazyProduct(addot);
  }
}

/// rho -= Q of force elements and of the springs of cut joints; a spring in the tree is part of its joint's total.
void Reactions::subtract_applied(const AppliedForces& applied) {  // (R55)
  if (!applied.any()) return;
  for (const LinkIndex l : upward<LinkIndex>(loads_.size())) {
    Load& load = loads_[l];
    load.rho -= applied.on_body(l);
    if (load.rho_a.size() > 0) load.rho_a -= applied.on_modes(l);
  }
}

void Reactions::set_spring_forces(const AppliedForces& applied) {
  for (const ForcedJoint& forced : forced_joints_) {
    const Span& span = kinematics_->topology().joints[forced.joint];
    JointWrenches& wrenches = found_.joints[forced.joint];
    wrenches.tau = applied.tau().segment(span.first_u, span.n_u);
  }
}

void Reactions::share_out_springs(const AppliedForces& applied) {
  if (!applied.any()) return;
  applied.write_tau_of_springs(tau_of_springs_);
  for (const ForcedJoint& forced : forced_joints_) {
    const Span& span = kinematics_->topology().joints[forced.joint];
    std::array<VecX, kActors.size()>& shares = found_.joints[forced.joint].shares;
    const auto of_motors = applied.tau_of_motors().segment(span.first_u, span.n_u);
    const auto of_springs = tau_of_springs_.segment(span.first_u, span.n_u);
    shares[index(Actor::motor)] = of_motors;
    shares[index(Actor::spring)] = of_springs;
    shares[index(Actor::damper)] = applied.tau().segment(span.first_u, span.n_u) - of_motors - of_springs;
  }
}

/// f = -lambda, and factor_k f.
void Reactions::set_coupling_forces(const VecX& lambda) {
  if (found_.couplings.empty()) return;
  found_.coupling_tau.setZero();
  for (const SpeedConstraint& constraint : closure_->speed_constraints()) {
    if (!constraint.is_coupling()) continue;
    const double force = -lambda[constraint.first_row];
    found_.couplings[*constraint.coupling] = force / constraint.size;
    for (const ConstrainedJoint& part : constraint.joints) {
      const Span& span = kinematics_->topology().joints[part.joint];
      found_.coupling_tau.segment(span.first_u, span.n_u) += force * part.C.col(0);
    }
  }
}

void Reactions::add_coupling_forces() {
  if (found_.couplings.empty()) return;
  for (const ForcedJoint& forced : forced_joints_) {
    const Span& span = kinematics_->topology().joints[forced.joint];
    found_.joints[forced.joint].tau += found_.coupling_tau.segment(span.first_u, span.n_u);
  }
}

void Reactions::clear_loads() {
  for (const ForcedJoint& forced : forced_joints_) {
    JointWrenches& wrenches = found_.joints[forced.joint];
    wrenches.tau.setZero();
    for (VecX& share : wrenches.shares) share.setZero();
  }
  for (Load& load : loads_) {
    load.rho.setZero();
    load.rho_a.setZero();
  }
}

/// The constraint wrench of a cut joint on its child at P_i is -T lambda (R56).
void Reactions::apply_cut_wrenches(const VecX& lambda) {
  for (const Closure::Cut& cut : closure_->cuts()) {
    const int rows = cut.measure.n_rows();
    Vec6 on_child;
    on_child.noalias() = -cut.T_global.leftCols(rows).lazyProduct(lambda.segment(cut.first_row, rows));
    report(cut.joint, on_child, exert_at_cut(cut.joint, on_child));
  }
}

/// Likewise of couplings and nonholonomic constraints at cut joints; in the tree they are part of the joint's total.
void Reactions::apply_speed_constraint_wrenches(const VecX& lambda) {
  for (const SpeedConstraint& constraint : closure_->speed_constraints()) {
    for (const ConstrainedJoint& part : constraint.joints) {
      if (!part.cut()) continue;
      Vec6 on_child;
      on_child.noalias() = -part.T_global.lazyProduct(lambda.segment(constraint.first_row, constraint.n_rows));
      add_to_total(part.joint, on_child, exert_at_cut(part.joint, on_child));
    }
  }
}

/// Applies a wrench to the child of a cut joint and the opposite one, at its own point, to the parent; returns the
/// latter.
Vec6 Reactions::exert_at_cut(JointIndex k, const Vec6& on_child) {
  const JointPoint& parent = kinematics_->point(k, Side::parent);
  const JointPoint& child = kinematics_->point(k, Side::child);
  const Joint& joint = kinematics_->model().joints[k];
  Vec6 on_parent = opposite_wrench_at(on_child, child.r, parent.r);
  subtract_from(BodyIndex(joint.on(Side::child).body), child, on_child);
  subtract_from(BodyIndex(joint.on(Side::parent).body), parent, on_parent);
  return on_parent;
}

/// The bodies have felt the springs of cut joints as applied forces; here they join the joints' totals.
void Reactions::add_spring_wrenches_of_cuts(const AppliedForces& applied) {
  for (const ForcedJoint& forced : forced_joints_) {
    if (!forced.cut) continue;
    const JointPoint& parent = kinematics_->point(forced.joint, Side::parent);
    const JointPoint& child = kinematics_->point(forced.joint, Side::child);
    const Vec6& spring = applied.on_child_of_cut(*forced.cut);
    add_to_total(forced.joint, spring, opposite_wrench_at(spring, child.r, parent.r));
  }
}

/// rho -= G_P^T w: the generalized force of a wrench at a point (R8), (R55).
void Reactions::subtract_from(Load& load, const JointPoint& point, const Vec6& wrench) {
  load.rho -= shift_wrench(wrench, point.lever);
  if (point.n_modes() > 0) load.rho_a.noalias() -= point.Ga().transpose().lazyProduct(wrench);
}

void Reactions::subtract_from(BodyIndex body, const JointPoint& point, const Vec6& wrench) {
  if (body == kGround) return;
  subtract_from(loads_[*kinematics_->topology().link_of_body[body]], point, wrench);
}

/// Step 4 gives the wrench of a link's joint. By Step 5 the same wrench leaves nothing of the modal rows: the body's
/// audit holds that against the results.
void Reactions::backward_pass() {  // (R57), (R58)
  const std::vector<Link>& links = kinematics_->topology().links;
  for (const LinkIndex l : downward<LinkIndex>(links.size())) {
    const Link& link = links[l];
    const JointPoint& own = kinematics_->point(link.joint, link.own_side());
    const JointPoint& reference = kinematics_->point(link.joint, link.reference_side());
    Load& load = loads_[l];
    Vec6 on_body = load.rho;
    if (!own.is_reference_point()) {
      on_body.tail<3>() -= own.lever.cross(on_body.head<3>());
    }
    if (own.n_modes() > 0) load.rho_a.noalias() -= own.Ga().transpose().lazyProduct(on_body);
    const Vec6 on_reference = load.acts_at_one_point ? Vec6(-on_body) : opposite_wrench_at(on_body, own.r, reference.r);
    if (load.reference) subtract_from(loads_[*load.reference], reference, on_reference);
    if (link.along) {
      report(link.joint, on_body, on_reference);
    } else {
      report(link.joint, on_reference, on_body);
    }
  }
}

namespace {

/// Six numbers in a row, two at once.
[[gnu::always_inline]] inline void write_wrench(const Vec6& w, Wrench& to) {
  static_assert(sizeof(Wrench) == sizeof(Vec6));
  std::memcpy(static_cast<void*>(&to), w.data(), sizeof(Vec6));
}

}  // namespace

void Reactions::report(JointIndex joint, const Vec6& on_child, const Vec6& on_parent) {
  if (!reports_all_ && is_driven_[joint.value()] == 0) return;
  JointWrenches& wrenches = found_.joints[joint];
  const auto report_on = [&](Side side, const Vec6& w) {
    const Vec6 in_C = transpose_times_both(kinematics_->point(joint, side).A, w);
    for (SideWrench* to : {&wrenches.total[index(side)], &wrenches.reaction[index(side)]}) {
      write_wrench(in_C, to->in_C);
      write_wrench(w, to->in_global);
    }
  };
  report_on(Side::parent, on_parent);
  report_on(Side::child, on_child);
}

void Reactions::add_to_total(JointIndex joint, const Vec6& on_child, const Vec6& on_parent) {
  const JointWrenches& so_far = found_.joints[joint];
  report(joint, so_far.total_on(Side::child).in_global.vector() + on_child,
         so_far.total_on(Side::parent).in_global.vector() + on_parent);
}

const JointMotion& Reactions::motion_of(const ForcedJoint& forced) const {
  return forced.cut ? closure_->cuts()[*forced.cut].measure.motion_at() : kinematics_->joint_motion(forced.joint);
}

/// tau_k of a driven coordinate is S_k^T w_total, all that acts there, without what the nonholonomic constraint pushes;
/// what of it springs and couplings do not exert is the driver's (R59).
void Reactions::set_driver_forces(const ForcedJoint& forced, const VecX& lambda) {
  if (forced.driven.empty()) return;
  const JointMotion& motion = motion_of(forced);
  const Mat3& A = kinematics_->point(forced.joint, Side::parent).A;
  JointWrenches& wrenches = found_.joints[forced.joint];
  const Wrench& total = wrenches.total[index(Side::child)].in_global;
  Vec6 in_parent_axes;
  in_parent_axes << A.transpose() * total.force, A.transpose() * total.torque;
  for (const int c : forced.driven) {
    const double of_others = wrenches.tau(c);
    wrenches.tau(c) = motion.S.col(c).dot(in_parent_axes);
    if (forced.nonholonomic) {
      const SpeedConstraint& constraint = closure_->speed_constraints()[*forced.nonholonomic];
      const JointSquare& C = constraint.joints.front().C;
      wrenches.tau(c) += C.row(c).transpose().dot(lambda.segment(constraint.first_row, constraint.n_rows));
    }
    wrenches.shares[index(Actor::driver)](c) = wrenches.tau(c) - of_others;
  }
}

/// w_d with S^T w_d = tau is taken off the total on the child at P_i, and the opposite wrench off that on the parent
/// (R60).
void Reactions::split_off_coordinate_wrenches(const VecX& lambda) {
  for (const ForcedJoint& forced : forced_joints_) {
    set_driver_forces(forced, lambda);
    const JointIndex k = forced.joint;
    const JointPoint& parent = kinematics_->point(k, Side::parent);
    const JointPoint& child = kinematics_->point(k, Side::child);
    JointWrenches& wrenches = found_.joints[k];
    const Vec6 coordinate_C = kinematics_->mobilizer(k).coordinate_wrench(motion_of(forced), JointVector(wrenches.tau));
    Vec6 coordinate;
    coordinate << parent.A * coordinate_C.head<3>(), parent.A * coordinate_C.tail<3>();
    const Vec6 on_child = wrenches.total[index(Side::child)].in_global.vector() - coordinate;
    const Vec6 on_parent =
        wrenches.total[index(Side::parent)].in_global.vector() - opposite_wrench_at(coordinate, child.r, parent.r);
    wrenches.reaction[index(Side::child)] = in_both_frames(child.A, on_child);
    wrenches.reaction[index(Side::parent)] = in_both_frames(parent.A, on_parent);
  }
}

}  // namespace concord::relative
