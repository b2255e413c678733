#include "common/reading/model_checks.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/decompositions.h"

namespace concord {

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

std::optional<std::string> complaint_about_inertia(const Mat3& inertia) {
  constexpr double kSlack = 1e-9;
  const Vec3 moments = symmetric_eigenvalues(inertia);
  const double slack = kSlack * std::abs(moments.z());
  const std::string found =
      fmt::format("principal moments {:.6g}, {:.6g}, {:.6g} kg m2", moments.x(), moments.y(), moments.z());
  if (moments.x() < -slack || moments.z() < 0.0) return found + ": none may be negative";
  if (moments.z() > moments.x() + moments.y() + slack) {
    return found + ": the largest exceeds the sum of the others, which no mass distribution can have";
  }
  return std::nullopt;
}

std::optional<std::string> complaint_about_symmetry(const MatX& matrix) {
  constexpr double kSlack = 1e-12;
  const double allowed = kSlack * matrix.cwiseAbs().maxCoeff();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = row + 1; column < matrix.cols(); ++column) {
      if (std::abs(matrix(row, column) - matrix(column, row)) <= allowed) continue;
      return fmt::format("entries ({0}, {1}) and ({1}, {0}) differ: {2} and {3}", row + 1, column + 1,
                         matrix(row, column), matrix(column, row));
    }
  }
  return std::nullopt;
}

std::optional<std::string> complaint_about_semidefiniteness(const MatX& matrix) {
  constexpr double kSlack = 1e-12;
  const VecX values = symmetric_eigenvalues(matrix);
  const double smallest = values.minCoeff();
  const double largest = values.maxCoeff();
  if (smallest >= -kSlack * std::abs(largest)) return std::nullopt;
  return fmt::format("its smallest eigenvalue is {:.6g}, its largest {:.6g}", smallest, largest);
}

std::vector<int> bodies_without_ground(const Model& model) {
  std::vector<bool> connected(model.bodies.size(), false);
  connected[kGround] = true;
  const auto spread = [&](const Joint& joint) {
    const int parent = joint.on(Side::parent).body;
    const int child = joint.on(Side::child).body;
    if (connected[parent] == connected[child]) return false;
    connected[parent] = connected[child] = true;
    return true;
  };
  while (std::any_of(model.joints.begin(), model.joints.end(), spread)) {
  }
  std::vector<int> left;
  for (std::size_t i = 0; i < connected.size(); ++i) {
    if (!connected[i]) left.push_back(static_cast<int>(i));
  }
  return left;
}

}  // namespace concord
