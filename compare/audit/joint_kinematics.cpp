#include "compare/audit/joint_kinematics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "compare/audit/differences.h"

namespace concord::compare {

namespace {

/// A difference quotient moves the machine by this part of what it does in the time in which something turns by 1 rad.
constexpr double kLookAhead = 1.5e-3;
/// A quotient that errs by less than this part of the terms is good enough.
constexpr double kGoodRate = 1e-11;

/// Euler parameters after a rotation vector in global axes [rad].
Vec4 turned(const Vec4& p, const Vec3& turn) {
  const Vec3 half_turn = 0.5 * turn;
  const double angle = half_turn.norm();
  const double sinc = angle < 1e-4 ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  const Vec3 w = sinc * half_turn;
  const Vec3 e = p.tail<3>();
  Vec4 after;
  after << std::cos(angle) * p(0) - w.dot(e), std::cos(angle) * e + p(0) * w + w.cross(e);
  return after;
}

/// A body `h` seconds on, with velocities that change at constant rates, seen from a frame that moves like the origin
/// of `parent`: exact to first order, which is all that a derivative needs.
struct BodyAlongMotion {
  const BodyState& body;
  const BodyAcceleration& rates;

  [[nodiscard]] BodyState after(double h, const BodyAlongMotion& parent) const {
    BodyState moved;
    const Vec3 v = body.v - parent.body.v;
    moved.r = body.r - parent.body.r + h * v;
    moved.v = v + h * (rates.vdot - parent.rates.vdot);
    moved.p = turned(body.p, h * body.omega);
    moved.omega = body.omega + h * rates.omegadot;
    moved.a = body.a + h * body.adot;
    moved.adot = body.adot;
    if (rates.addot.size() == body.adot.size()) moved.adot += h * rates.addot;
    return moved;
  }
};

/// What of v_rel no permitted speed gives, and then the joint speeds.
using BothRates = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6 + kMostSpeeds, 1>;

/// The two bodies of a joint, moved along their motion.
class JointAlongMotion {
 public:
  JointAlongMotion(const Joint& joint, const State& state, const Evaluation& evaluation, const VecX& hint,
                   double length)
      : joint_(joint),
        hint_(hint),
        weights_((Vec6() << Vec3::Constant(1.0 / length), Vec3::Ones()).finished()),
        bodies_{of(Side::parent, state, evaluation), of(Side::child, state, evaluation)} {}

  /// What of v_rel no permitted speed gives, and then the joint speeds, if they are wanted, h seconds on.
  [[nodiscard]] BothRates after(double h, bool wants_speeds) const {
    const RelativeMotion relative = relative_after(h);
    if (!wants_speeds) return not_permitted(read_pose(*joint_.type, relative, hint_), relative.v_rel);
    const JointMotion motion = read_motion(*joint_.type, relative, hint_);
    BothRates both(6 + motion.u.size());
    both << not_permitted(motion, relative.v_rel), motion.u;
    return both;
  }

  /// The joint speeds h seconds on.
  [[nodiscard]] SpeedVector speeds_after(double h) const {
    return read_motion(*joint_.type, relative_after(h), hint_).u;
  }

  [[nodiscard]] const joints::JointType& type() const { return *joint_.type; }

  [[nodiscard]] RelativeMotion relative_after(double h) const {
    const BodyState parent = bodies_[0].after(h, bodies_[0]);
    const BodyState child = bodies_[1].after(h, bodies_[0]);
    return relative_motion(place(joint_.on(Side::parent), parent), place(joint_.on(Side::child), child));
  }

  /// The part of v_rel that is farthest from the permitted directions, lengths in units of the machine's.
  [[nodiscard]] Vec6 not_permitted(const JointMotion& motion, const Vec6& v_rel) const {
    const SpeedColumns directions = weights_.asDiagonal() * (motion.S * motion.free);
    if (directions.cols() == 0) return v_rel;
    const SpeedVector nearest = nearest_combination(directions, weights_.asDiagonal() * v_rel);
    return v_rel - motion.S * (motion.free * nearest);
  }

 private:
  [[nodiscard]] BodyAlongMotion of(Side side, const State& state, const Evaluation& evaluation) const {
    const int body = joint_.on(side).body;
    return {state.bodies[body], evaluation.bodies[body]};
  }

  const Joint& joint_;
  const VecX& hint_;
  Vec6 weights_;
  std::array<BodyAlongMotion, 2> bodies_;
};

/// Sizes of what makes up the velocity and the acceleration of a place on a body.
struct Sizes {
  LineAndTurn speed;
  LineAndTurn rate_of_speed;
};

Sizes sizes_at(const Attachment& side, const BodyState& body, const BodyAcceleration& rates) {
  const double lever = place(side, body).lever.norm();
  const double omega = body.omega.norm();
  const VecX addot = rates.addot.size() == body.adot.size() ? rates.addot : VecX::Zero(body.adot.size());
  const double sway = (side.Psi_t_L * body.adot).norm();
  const double twist = (side.Psi_r_L * body.adot).norm();
  Sizes sizes;
  sizes.speed = {body.v.norm() + omega * lever + sway, omega + twist};
  const double turn = rates.omegadot.norm() + omega * (omega + twist) + twist * twist + (side.Psi_r_L * addot).norm();
  sizes.rate_of_speed = {rates.vdot.norm() + turn * lever + 2.0 * omega * sway + (side.Psi_t_L * addot).norm(), turn};
  return sizes;
}

void raise(LineAndTurn& sizes, const LineAndTurn& others) {
  sizes.line = std::max(sizes.line, others.line);
  sizes.turn = std::max(sizes.turn, others.turn);
}

/// The inverse of the time in which something turns by 1 rad or the joint moves by the machine's length; at rest, in
/// which the accelerations do so. That both bodies travel together matters to nothing here.
double rate_of(const joints::JointType& type, const JointKinematics& found, double length) {
  double rate =
      std::max({found.speed.turn, found.relative.v_rel.head<3>().norm() / length, std::sqrt(found.rate_of_speed.turn)});
  if (!(rate > 0.0)) rate = std::sqrt(found.rate_of_speed.line / length);
  if (!(rate > 0.0) || !std::isfinite(rate)) rate = 1.0;
  // Near a pose where a coordinate has no meaning the coordinate hurries more than the bodies do.
  const std::vector<bool> turns = turning_speeds(type);
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const double speed = std::abs(found.motion.u(static_cast<Eigen::Index>(k)));
    rate = std::max(rate, turns[k] ? speed : speed / length);
  }
  return rate;
}

/// Where the joint is and how large what moves it is.
void measure(const JointAlongMotion& on_its_way, const Joint& joint, const State& state, const Evaluation& evaluation,
             const VecX& hint, JointKinematics& found) {
  found.relative = on_its_way.relative_after(0.0);
  found.motion = read_motion(*joint.type, found.relative, hint);
  for (const Attachment& side : joint.sides) {
    const Sizes sizes = sizes_at(side, state.bodies[side.body], evaluation.bodies[side.body]);
    raise(found.speed, sizes.speed);
    raise(found.rate_of_speed, sizes.rate_of_speed);
  }
}

/// A difference along the motion: what of a_rel is neither permitted nor Sdot u, and the joint accelerations, if they
/// are asked for, are expected to be so; their sizes; and the first step [s].
struct Question {
  VecX expected;
  VecX scales;
  double step = 0.0;
};

Question question_of(const JointAlongMotion& joint, const VecX& expected_udot, double length,
                     const JointKinematics& found) {
  const double rate = rate_of(joint.type(), found, length);
  const std::vector<bool> turns = turning_speeds(joint.type());
  const auto n_u = expected_udot.size();
  VecX expected(6 + n_u);
  expected << Vec6::Zero(), expected_udot;
  VecX scales = VecX::Constant(6 + n_u, rate * rate);
  scales.head<3>() *= length;
  for (Eigen::Index k = 0; k < n_u; ++k) scales(6 + k) *= turns[static_cast<std::size_t>(k)] ? 1.0 : length;
  return {std::move(expected), std::move(scales), kLookAhead / rate};
}

SlopeMisfit answer(const Question& question, const JointAlongMotion& joint) {
  const bool asks_for_udot = question.expected.size() > 6;
  return slope_misfit([&](double h) { return joint.after(h, asks_for_udot); }, question.expected, question.scales,
                      question.step, kGoodRate);
}

/// How much of motion the joint's speeds make at least, lengths in units of the machine's: 1 of most joints, 0 in a
/// pose where a coordinate has no meaning.
double least_motion(const joints::JointType& type, const JointMotion& motion, double length) {
  if (motion.S.cols() == 0) return 1.0;
  Mat6X directions = motion.S;
  directions.topRows(3) /= length;
  const std::vector<bool> turns = turning_speeds(type);
  for (std::size_t k = 0; k < turns.size(); ++k) {
    if (!turns[k]) directions.col(static_cast<Eigen::Index>(k)) *= length;
  }
  return singular_values(directions).minCoeff();
}

/// Whether the joint's speeds follow from the motion with more than ten times its errors.
bool magnifies(const joints::JointType& type, const JointMotion& motion, double length) {
  constexpr double kPlain = 0.1;
  return least_motion(type, motion, length) < kPlain;
}

/// The state with one of its bodies off by as much as solvers leave states open: by a part of the length, of 1 rad, and
/// of the joint's speeds, in the k-th of twelve ways.
State nudged(State state, int body, int k, double length, const LineAndTurn& speed) {
  constexpr double kClosed = 1e-13;
  BodyState& moved = state.bodies[static_cast<std::size_t>(body)];
  const Vec3 axis = Vec3::Unit(k % 3);
  if (k < 3) {
    moved.r += kClosed * length * axis;
  } else if (k < 6) {
    moved.p = turned(moved.p, kClosed * axis);
  } else if (k < 9) {
    moved.v += kClosed * speed.line * axis;
  } else {
    moved.omega += kClosed * speed.turn * axis;
  }
  return state;
}

/// Adds what such states leave open in the joint's coordinates, speeds and accelerations.
void doubt_magnified(const Joint& joint, const State& state, const Evaluation& evaluation, const VecX& hint,
                     double length, const Question& question, JointKinematics& found) {
  const int child = joint.on(Side::child).body;
  const int body = child != 0 ? child : joint.on(Side::parent).body;
  for (int k = 0; k < 12; ++k) {
    const State off = nudged(state, body, k, length, found.speed);
    const JointAlongMotion moved(joint, off, evaluation, hint, length);
    const JointMotion motion = read_motion(*joint.type, moved.relative_after(0.0), hint);
    found.doubt_of_q += (motion.q - found.motion.q).cwiseAbs();
    found.doubt_of_u += (motion.u - found.motion.u).cwiseAbs();
    found.doubt_of_udot += (answer(question, moved).slope.tail(found.udot.size()) - found.udot).cwiseAbs();
  }
}

}  // namespace

JointKinematics read_kinematics(const Joint& joint, const State& state, const Evaluation& evaluation, const VecX& hint,
                                const VecX& expected_udot, double length) {
  const JointAlongMotion on_its_way(joint, state, evaluation, hint, length);
  JointKinematics found;
  measure(on_its_way, joint, state, evaluation, hint, found);
  found.place << found.relative.d - found.motion.d, rotation_vector_of(found.relative.R * found.motion.R.transpose());
  found.velocity = on_its_way.not_permitted(found.motion, found.relative.v_rel);
  const bool is_asked = !expected_udot.array().isNaN().all();
  const VecX asked = is_asked ? expected_udot : VecX();
  const Question question = question_of(on_its_way, asked, length, found);
  const SlopeMisfit misfit = answer(question, on_its_way);
  found.acceleration = misfit.slope.head(6);
  found.udot = is_asked ? VecX(misfit.slope.tail(asked.size())) : expected_udot;
  found.doubt_of_acceleration = misfit.doubt.head(6);
  found.doubt_of_udot = VecX::Zero(expected_udot.size());
  found.doubt_of_udot.head(asked.size()) = misfit.doubt.tail(asked.size());
  found.doubt_of_q = VecX::Zero(found.motion.q.size());
  found.doubt_of_u = VecX::Zero(found.motion.u.size());
  if (is_asked && magnifies(*joint.type, found.motion, length)) {
    doubt_magnified(joint, state, evaluation, hint, length, question, found);
  }
  return found;
}

VecX joint_accelerations(const Joint& joint, const State& state, const Evaluation& evaluation, const VecX& hint,
                         double length) {
  constexpr double kStep = 0.015;  // rad: errs by its eighth power over 630
  constexpr double kLeast = 1e-3;
  constexpr double kWeights[] = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
  const JointAlongMotion on_its_way(joint, state, evaluation, hint, length);
  JointKinematics found;
  measure(on_its_way, joint, state, evaluation, hint, found);
  // Where speeds make little of motion, they change over as little of it.
  const double part = std::clamp(least_motion(*joint.type, found.motion, length), kLeast, 1.0);
  const double h = kStep * part / rate_of(*joint.type, found, length);
  VecX udot = VecX::Zero(found.motion.u.size());
  for (int k = 1; k <= 4; ++k)
    udot += kWeights[k - 1] / h * (on_its_way.speeds_after(k * h) - on_its_way.speeds_after(-k * h));
  return udot;
}

}  // namespace concord::compare
