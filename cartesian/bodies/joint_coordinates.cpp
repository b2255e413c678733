#include "cartesian/bodies/joint_coordinates.h"

#include <cmath>

#include "cartesian/bodies/euler_parameters.h"

namespace concord::cartesian {

namespace {

/// A turn that the model says nothing of, alone in its coupling, starts as many times round as the others ask for.
void choose_turns(const Model& model, const Coupling& coupling, std::vector<VecX>& q) {
  constexpr double kWholeTurn = 2.0 * EIGEN_PI;
  double missing = coupling.offset;
  int unsaid = 0;
  CouplingTerm last;
  for (const CouplingTerm& term : coupling.terms) {
    const Joint& joint = model.joints[term.joint];
    missing -= term.factor * q[term.joint](first_q(*joint.type, term.word) + term.component);
    const bool is_driven = driver_of(joint, term.word, term.component) != nullptr;
    if (is_driven || joint.start[term.word].role_q != StartRole::unsaid) continue;
    ++unsaid;
    last = term;
  }
  if (unsaid != 1) return;
  const joints::JointType& type = *model.joints[last.joint].type;
  if (!reads_turn(*read_of(type, last.word), last.component)) return;
  q[last.joint](first_q(type, last.word) + last.component) +=
      kWholeTurn * std::round(missing / (last.factor * kWholeTurn));
}

}  // namespace

void read_joint_coordinates(const Model& model, const MovingConstraints& constraints, std::vector<VecX>& q,
                            std::vector<VecX>& u) {
  for (const JointIndex k : indices_of(model.joints)) {
    const joints::JointType& type = *pick(model.joints, k).type;
    const RelativeMotion& motion = constraints.joint(k).motion;
    int at_q = 0;
    int at_u = 0;
    for (const joints::Read& read : type.reads) {
      if (is_orientation(read)) {
        const Vec4 p = euler_parameters_of(motion.R);
        auto known = q[k.value].segment<4>(at_q);
        known = known.dot(p) < 0.0 ? Vec4(-p) : p;
        u[k.value].segment<3>(at_u) = motion.omega;
        at_q += n_q(read);
        at_u += n_u(read);
        continue;
      }
      for (int component = 0; component < n_u(read); ++component) {
        const ConstraintRow row = evaluate_read(read, component, motion);
        double& known = q[k.value](at_q++);
        known = value_near(reads_turn(read, component), row, known);
        u[k.value](at_u++) = rate_of(row, motion);
      }
    }
  }
}

std::vector<VecX> start_coordinates(const Model& model) {
  std::vector<VecX> all;
  for (const Joint& joint : model.joints) {
    VecX q = VecX::Zero(joint.type->n_q());
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const int first = first_q(*joint.type, static_cast<int>(word));
      q.segment(first, joint.start[word].q.size()) = joint.start[word].q;
      for (const Driver& driver : joint.drivers) {
        if (driver.word == static_cast<int>(word)) q(first + driver.component) = evaluate(driver.law, 0.0).f;
      }
    }
    all.push_back(std::move(q));
  }
  for (const Coupling& coupling : model.couplings) choose_turns(model, coupling, all);
  return all;
}

std::vector<VecX> zero_speeds(const Model& model) {
  std::vector<VecX> all;
  for (const Joint& joint : model.joints) all.emplace_back(VecX::Zero(joint.type->n_u()));
  return all;
}

}  // namespace concord::cartesian
