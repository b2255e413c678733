#include "cartesian/constraints.h"

#include <algorithm>
#include <cmath>

#include "cartesian/euler_parameters.h"

namespace concord::cartesian {

namespace {

/// A row's gradient over (d, rho) as force and torque at the side's point: on the child as it is, on the parent
/// opposite and moved from P_i to P_j (C26).
template <class Column>
void write_row(const JointEquations& joint, Side side, const ConstraintRow& row, Column&& column) {
  const Mat3& A_joint = joint.marker(Side::parent).A_joint;
  const Vec3 force = A_joint * row.over_d;
  const Vec3 torque = A_joint * row.over_rho;
  if (side == Side::child) {
    write_generalized_force(joint.marker(side), force, torque, column);
  } else {
    write_generalized_force(joint.marker(side), -force, -(torque + joint.gap.cross(force)), column);
  }
}

void evaluate_rows(const Joint& stated, JointEquations& joint) {
  const int n_forbids = evaluate_forbids(*stated.type, joint.motion, joint.rows.data());
  evaluate_forbidden_speeds(*stated.type, joint.motion, joint.rows.data() + n_forbids);
  for (std::size_t j = 0; j < stated.drivers.size(); ++j) {
    joint.rows[joint.first_driver + j] =
        evaluate_read(*read_of(*stated.type, stated.drivers[j].word), stated.drivers[j].component, joint.motion);
  }
  for (std::size_t j = 0; j < joint.coupled.size(); ++j) {
    joint.rows[joint.n_rows + j] = evaluate_read(*joint.coupled[j].read, joint.coupled[j].component, joint.motion);
  }
}

/// A coupled coordinate at the last place(), turns counted.
double value_of(const JointEquations& joint, int row) {
  const CoupledCoordinate& coordinate = joint.coupled[row - joint.n_rows];
  return value_near(coordinate.turns, joint.rows[row], coordinate.known);
}

/// Sum of factor q - offset, whose whole turns and offset are summed apart: the rest has the round-off of one turn.
double residual_of(const CouplingEquations& coupling, const std::vector<JointEquations>& joints) {
  long double turned = -static_cast<long double>(coupling.offset);
  double sum = 0.0;
  for (const CouplingEquations::Term& term : coupling.terms) {
    const JointEquations& joint = joints[term.joint];
    const CoupledCoordinate& coordinate = joint.coupled[term.row - joint.n_rows];
    if (coordinate.turns) turned += term.factor * whole_turns_between(joint.rows[term.row].value, coordinate.known);
    sum += term.factor * joint.rows[term.row].value;
  }
  return sum + static_cast<double>(turned);
}

/// What gradient . a_rel + bias is without the accelerations Ydot.
double bias_of(const JointEquations& joint, const ConstraintRow& row) {
  return row.over_d.dot(joint.linear_bias) + row.over_rho.dot(joint.angular_bias) + row.bias;
}

double rate_of_coupling(const CouplingEquations& coupling, const std::vector<JointEquations>& joints) {
  double sum = 0.0;
  for (const auto& term : coupling.terms) {
    const JointEquations& joint = joints[term.joint];
    sum += term.factor * rate_of(joint.rows[term.row], joint.motion);
  }
  return sum;
}

}  // namespace

void place_relative(const Marker& parent, const Marker& child, RelativeMotion& motion) {
  motion.d = parent.A_joint.transpose() * (child.point - parent.point);
  motion.R = parent.A_joint.transpose() * child.A_joint;
}

void move_relative(const Marker& parent, const Marker& child, RelativeMotion& motion) {
  const Vec3 carried = parent.angular_velocity.cross(child.point - parent.point);
  motion.ddot = parent.A_joint.transpose() * (child.velocity - parent.velocity - carried);
  motion.omega = parent.A_joint.transpose() * (child.angular_velocity - parent.angular_velocity);
}

Constraints::Constraints(const Model& model, const Layout& layout)
    : model_(model), layout_(layout), rotations_(model.bodies.size(), Mat3::Identity()) {
  for (const Joint& joint : model.joints) {
    JointEquations equations;
    equations.first_row = n_rows_;
    equations.n_forbids = joint.type->rows();
    equations.first_driver = equations.n_forbids + joint.type->nonholonomic_rows();
    equations.n_rows = equations.first_driver + static_cast<int>(joint.drivers.size());
    for (int row = 0; row < equations.n_rows; ++row) {
      holds_positions_.push_back(row < equations.n_forbids || equations.is_driver(row));
      is_driver_.push_back(equations.is_driver(row));
    }
    n_rows_ += equations.n_rows;
    for (const Driver& driver : joint.drivers) {
      equations.driver_turns.push_back(reads_turn(*read_of(*joint.type, driver.word), driver.component));
    }
    int place = 0;
    for (const joints::Read& read : joint.type->reads) {
      if (is_elevation(read)) equations.elevation = place;
      place += n_q(read);
    }
    for (const Side side : {Side::parent, Side::child}) {
      const Attachment& attachment = joint.on(side);
      equations.markers[index(side)] = make_marker(attachment);
      const VecX none;
      concord::cartesian::place(attachment, Vec3::Zero(), Mat3::Identity(), none.head(0),
                                equations.markers[index(side)]);
    }
    joints_.push_back(std::move(equations));
  }
  add_couplings();
  allocate();
}

void Constraints::add_couplings() {
  for (const Coupling& stated : model_.couplings) {
    CouplingEquations coupling;
    coupling.row = n_rows_++;
    holds_positions_.push_back(true);
    is_driver_.push_back(false);
    coupling.offset = stated.offset;
    for (const CouplingTerm& term : stated.terms) {
      coupling.terms.push_back({term.joint, find_or_add_coupled(term), term.factor});
      joints_[term.joint].shares.push_back({coupling.terms.back().row, coupling.row, term.factor});
      for (const Attachment& side : model_.joints[term.joint].sides) {
        const bool is_new = std::count(coupling.bodies.begin(), coupling.bodies.end(), side.body) == 0;
        if (side.body != kGround && is_new) coupling.bodies.push_back(side.body);
      }
    }
    for (const int body : coupling.bodies) coupling.Phi_Y_transposed.emplace_back(MatX::Zero(layout_.size_Y(body), 1));
    couplings_.push_back(std::move(coupling));
  }
}

/// Row of a coupled coordinate among its joint's, a new one if no coupling relates it yet.
int Constraints::find_or_add_coupled(const CouplingTerm& term) {
  JointEquations& joint = joints_[term.joint];
  const joints::JointType& type = *model_.joints[term.joint].type;
  const auto found = std::find_if(joint.coupled.begin(), joint.coupled.end(), [&](const CoupledCoordinate& other) {
    return other.word == term.word && other.component == term.component;
  });
  const int row = joint.n_rows + static_cast<int>(found - joint.coupled.begin());
  if (found == joint.coupled.end()) {
    const int place = first_q(type, term.word) + term.component;
    const joints::Read* read = read_of(type, term.word);
    joint.coupled.push_back({read, term.word, term.component, place, reads_turn(*read, term.component), 0.0});
  }
  return row;
}

void Constraints::allocate() {
  for (int k = 0; k < n_joints(); ++k) {
    JointEquations& joint = joints_[k];
    joint.rows.resize(joint.n_rows + joint.coupled.size());
    for (const Side side : {Side::parent, Side::child}) {
      const int body = model_.joints[k].on(side).body;
      if (body == kGround) continue;
      joint.Phi_Y_transposed[index(side)].setZero(layout_.size_Y(body), static_cast<Eigen::Index>(joint.rows.size()));
      if (joint.n_rows > 0) blocks_.push_back({body, joint.first_row, joint.n_rows, k, side, -1, -1});
    }
  }
  for (int g = 0; g < n_couplings(); ++g) {
    const CouplingEquations& coupling = couplings_[g];
    for (std::size_t share = 0; share < coupling.bodies.size(); ++share) {
      blocks_.push_back({coupling.bodies[share], coupling.row, 1, -1, Side::child, g, static_cast<int>(share)});
    }
  }
}

bool Constraints::has_nonholonomic_rows() const {
  return std::find(holds_positions_.begin(), holds_positions_.end(), false) != holds_positions_.end();
}

void Constraints::place(const Eigen::Ref<const VecX>& q) {
  for (int i = 1; i < layout_.n_bodies(); ++i) place_body(i, q);
  for (int k = 0; k < n_joints(); ++k) place_joint(k, q);
  place_couplings();
}

/// A body may sit in several of the coupled joints: its columns add up (C30).
void Constraints::place_couplings() {
  for (CouplingEquations& coupling : couplings_) {
    for (MatX& columns : coupling.Phi_Y_transposed) columns.setZero();
    for (const CouplingEquations::Term& term : coupling.terms) {
      for (const Side side : {Side::parent, Side::child}) {
        const int body = model_.joints[term.joint].on(side).body;
        if (body == kGround) continue;
        const auto share = std::find(coupling.bodies.begin(), coupling.bodies.end(), body) - coupling.bodies.begin();
        coupling.Phi_Y_transposed[share].col(0) +=
            term.factor * joints_[term.joint].Phi_Y_transposed[index(side)].col(term.row);
      }
    }
  }
}

void Constraints::count_turns_from(const std::vector<VecX>& q) {
  for (int k = 0; k < n_joints(); ++k) {
    for (CoupledCoordinate& coordinate : joints_[k].coupled) coordinate.known = q[k](coordinate.place);
    if (!joints_[k].elevation) continue;
    joints_[k].motion.is_beyond_upright = std::cos(q[k](*joints_[k].elevation)) < 0.0;
  }
}

void Constraints::follow_turns() {
  for (JointEquations& joint : joints_) {
    for (std::size_t c = 0; c < joint.coupled.size(); ++c) {
      joint.coupled[c].known = value_of(joint, joint.n_rows + static_cast<int>(c));
    }
  }
}

void Constraints::write_turns(std::vector<VecX>& q) const {
  for (int k = 0; k < n_joints(); ++k) {
    for (const CoupledCoordinate& coordinate : joints_[k].coupled) q[k](coordinate.place) = coordinate.known;
  }
}

void Constraints::write_own_terms(double t, Eigen::Ref<VecX> terms) const {
  terms.setZero();
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    for (int row = joint.first_driver; row < joint.n_rows; ++row) {
      if (joint.driver_turns[row - joint.first_driver]) continue;
      const Driver& driver = model_.joints[k].drivers[row - joint.first_driver];
      terms(joint.first_row + row) = std::abs(evaluate(driver.law, t).f);
    }
  }
  for (const CouplingEquations& coupling : couplings_) {
    double largest = 0.0;
    for (const CouplingEquations::Term& term : coupling.terms) {
      largest = std::max(largest, std::abs(term.factor * joints_[term.joint].rows[term.row].value));
    }
    terms(coupling.row) = largest;
  }
}

void Constraints::write_reaches(double reach, Eigen::Ref<VecX> reaches) const {
  const auto of = [reach](const ConstraintRow& row) { return row.reads_places() ? reach : 1.0; };
  for (const JointEquations& joint : joints_) {
    for (int row = 0; row < joint.n_rows; ++row) reaches(joint.first_row + row) = of(joint.rows[row]);
  }
  for (const CouplingEquations& coupling : couplings_) {
    double& largest = reaches(coupling.row);
    largest = 1.0;
    for (const CouplingEquations::Term& term : coupling.terms) {
      largest = std::max(largest, of(joints_[term.joint].rows[term.row]));
    }
  }
}

Eigen::Ref<const MatX> Constraints::columns(const RowBlock& block) const {
  if (block.joint < 0) return couplings_[block.coupling].Phi_Y_transposed[block.share];
  return joints_[block.joint].Phi_Y_transposed[index(block.side)].leftCols(block.n_rows);
}

VecX Constraints::joint_multipliers(int k, const Eigen::Ref<const VecX>& lambda) const {
  const JointEquations& joint = joints_[k];
  VecX own = VecX::Zero(static_cast<Eigen::Index>(joint.rows.size()));
  own.head(joint.n_rows) = lambda.segment(joint.first_row, joint.n_rows);
  for (const CoupledShare& share : joint.shares) own(share.row) += share.factor * lambda(share.coupling_row);
  return own;
}

void Constraints::place_body(int body, const Eigen::Ref<const VecX>& q) {
  rotations_[body] = rotation_of(layout_.p(q, body));
}

void Constraints::place_joint(int k, const Eigen::Ref<const VecX>& q) {
  JointEquations& joint = joints_[k];
  const Joint& stated = model_.joints[k];
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    const int body = attachment.body;
    if (body == kGround) continue;  // placed once, at construction
    concord::cartesian::place(attachment, layout_.r(q, body), rotations_[body], layout_.a(q, body),
                              joint.markers[index(side)]);
  }
  const Marker& on_parent = joint.marker(Side::parent);
  const Marker& on_child = joint.marker(Side::child);
  joint.gap = on_child.point - on_parent.point;
  place_relative(on_parent, on_child, joint.motion);
  joint.motion.ddot.setZero();
  joint.motion.omega.setZero();
  evaluate_rows(stated, joint);
  for (const Side side : {Side::parent, Side::child}) {
    if (stated.on(side).body == kGround) continue;
    auto& Phi_Y_transposed = joint.Phi_Y_transposed[index(side)];
    for (std::size_t row = 0; row < joint.rows.size(); ++row) {
      write_row(joint, side, joint.rows[row], Phi_Y_transposed.col(static_cast<Eigen::Index>(row)));
    }
  }
}

void Constraints::move(const Eigen::Ref<const VecX>& Y) {
  for (int k = 0; k < n_joints(); ++k) move_joint(k, Y);
}

void Constraints::move_joint(int k, const Eigen::Ref<const VecX>& Y) {  // (C14)
  JointEquations& joint = joints_[k];
  const Joint& stated = model_.joints[k];
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    const int body = attachment.body;
    if (body == kGround) continue;
    concord::cartesian::move(attachment, rotations_[body], layout_.v(Y, body), layout_.omega(Y, body),
                             layout_.adot(Y, body), joint.markers[index(side)]);
  }
  const Marker& parent = joint.marker(Side::parent);
  const Marker& child = joint.marker(Side::child);
  const Mat3& A_joint = parent.A_joint;
  const Vec3& omega_j = parent.angular_velocity;
  const Vec3 closing = child.velocity - parent.velocity;
  const Vec3 carried = omega_j.cross(joint.gap);
  move_relative(parent, child, joint.motion);
  joint.linear_bias = A_joint.transpose() *
                      (child.velocity_bias - parent.velocity_bias - parent.angular_velocity_bias.cross(joint.gap) -
                       2.0 * omega_j.cross(closing) + omega_j.cross(carried));
  joint.angular_bias = A_joint.transpose() * (child.angular_velocity_bias - parent.angular_velocity_bias -
                                              omega_j.cross(child.angular_velocity));
  evaluate_rows(stated, joint);
}

void Constraints::write_residual(double t, Eigen::Ref<VecX> residual) const {
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = model_.joints[k];
    for (int row = 0; row < joint.first_driver; ++row) residual(joint.first_row + row) = joint.rows[row].value;
    for (int row = joint.first_driver; row < joint.n_rows; ++row) {
      const Driver& driver = stated.drivers[row - joint.first_driver];
      const double value = joint.rows[row].value;
      const double asked = evaluate(driver.law, t).f;
      residual(joint.first_row + row) =
          joint.driver_turns[row - joint.first_driver] ? turn_from(asked, value) : value - asked;
    }
  }
  for (const CouplingEquations& coupling : couplings_) residual(coupling.row) = residual_of(coupling, joints_);
}

void Constraints::write_velocity_residual(double t, Eigen::Ref<VecX> residual) const {
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = model_.joints[k];
    for (int row = 0; row < joint.n_rows; ++row) {
      double rate = rate_of(joint.rows[row], joint.motion);
      if (joint.is_driver(row)) rate -= evaluate(stated.drivers[row - joint.first_driver].law, t).fdot;
      residual(joint.first_row + row) = rate;
    }
  }
  for (const CouplingEquations& coupling : couplings_) residual(coupling.row) = rate_of_coupling(coupling, joints_);
}

double Constraints::row_rate(const RowBlock& block, int row) const {
  if (block.joint < 0) return rate_of_coupling(couplings_[block.coupling], joints_);
  const JointEquations& joint = joints_[block.joint];
  return rate_of(joint.rows[row], joint.motion);
}

void Constraints::place_and_move(const RowBlock& block, const Eigen::Ref<const VecX>& q,
                                 const Eigen::Ref<const VecX>& Y) {
  const auto put = [&](int k) {
    place_joint(k, q);
    move_joint(k, Y);
  };
  if (block.joint >= 0) {
    put(block.joint);
  } else {
    for (const CouplingEquations::Term& term : couplings_[block.coupling].terms) put(term.joint);
  }
}

void Constraints::write_gamma(double t, Eigen::Ref<VecX> gamma) const {
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = model_.joints[k];
    for (int row = 0; row < joint.n_rows; ++row) {
      double rest = bias_of(joint, joint.rows[row]);
      if (joint.is_driver(row)) rest -= evaluate(stated.drivers[row - joint.first_driver].law, t).fddot;
      gamma(joint.first_row + row) = -rest;
    }
  }
  for (const CouplingEquations& coupling : couplings_) {
    double rest = 0.0;
    for (const auto& term : coupling.terms) {
      const JointEquations& joint = joints_[term.joint];
      rest += term.factor * bias_of(joint, joint.rows[term.row]);
    }
    gamma(coupling.row) = -rest;
  }
}

void Constraints::write_transposed(int joint, Side side, const ConstraintRow& row, Eigen::Ref<VecX> column) const {
  write_row(joints_[joint], side, row, column);
}

std::optional<int> Constraints::first_joint_off_branch() const {
  for (int k = 0; k < n_joints(); ++k) {
    if (!on_branch(*model_.joints[k].type, joints_[k].motion)) return k;
  }
  return std::nullopt;
}

}  // namespace concord::cartesian
