#include "cartesian/joint_coordinates.h"

#include "cartesian/euler_parameters.h"

namespace concord::cartesian {

void read_joint_coordinates(const Model& model, const Constraints& constraints, std::vector<VecX>& q,
                            std::vector<VecX>& u) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const joints::JointType& type = *model.joints[k].type;
    const RelativeMotion& motion = constraints.joint(static_cast<int>(k)).motion;
    int at_q = 0;
    int at_u = 0;
    for (const joints::Read& read : type.reads) {
      if (std::holds_alternative<joints::OrientationOf>(read)) {
        const Vec4 p = euler_parameters_of(motion.R);
        auto known = q[k].segment<4>(at_q);
        known = known.dot(p) < 0.0 ? Vec4(-p) : p;
        u[k].segment<3>(at_u) = motion.omega;
        at_q += 4;
        at_u += 3;
        continue;
      }
      for (int component = 0; component < n_speeds(read); ++component) {
        const Row row = evaluate_read(read, component, motion);
        double& known = q[k](at_q++);
        known = value_near(read, component, row, known);
        u[k](at_u++) = rate_of(row, motion);
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
  return all;
}

std::vector<VecX> zero_speeds(const Model& model) {
  std::vector<VecX> all;
  for (const Joint& joint : model.joints) all.emplace_back(VecX::Zero(joint.type->n_u()));
  return all;
}

}  // namespace concord::cartesian
