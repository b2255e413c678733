#include "compare/random_machines/machine.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

namespace concord::compare::fuzz {

std::string number_text(double value) { return fmt::format("{}", value == 0.0 ? 0.0 : value); }

std::string list_text(const VecX& values) {
  std::string text = "[";
  for (Eigen::Index k = 0; k < values.size(); ++k) text += (k > 0 ? ", " : "") + number_text(values(k));
  return text + "]";
}

Mat3 rotation_of(const Vec4& p) { return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).normalized().toRotationMatrix(); }

Vec4 parameters_of(const Mat3& A) {
  const Eigen::Quaterniond turned(A);
  Vec4 p(turned.w(), turned.x(), turned.y(), turned.z());
  p.normalize();
  return p(0) < 0.0 ? Vec4(-p) : p;
}

joints::JointType JointPlan::own_type() const { return parameters.empty() ? *type : type->with_parameters(parameters); }

}  // namespace concord::compare::fuzz
