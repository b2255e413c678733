#include "compare/quantities/symptom.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"

namespace concord::compare {

namespace {

/// Part of the difference that a named pattern may leave unexplained.
constexpr double kUnexplained = 1e-3;

using Vectors = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// The three components to which a failing row belongs, of both solvers over all samples.
struct Suspect {
  const QuantityLayout& layout;
  const Series& series;
  Quantity quantity;
  int first = 0;  // row of the vector's first component
  std::array<Vectors, 2> vectors;
  double difference = 0.0;  // Frobenius norm

  [[nodiscard]] bool explains(const Vectors& predicted, int who) const {
    return (vectors[who] - predicted).norm() <= kUnexplained * difference;
  }
  [[nodiscard]] Vectors rows(int row, int who) const { return series.values[who].middleRows<3>(row); }
};

std::string samples_of(const Series& series) { return fmt::format("all {} samples", series.times.size()); }

/// The constant factor from cartesian to relative and what it explains, or an empty text.
std::string factor_pattern(const Eigen::Ref<const MatX>& one, const Eigen::Ref<const MatX>& other,
                           const Series& series) {
  const double difference = (one - other).norm();
  if (one.norm() <= kUnexplained * other.norm()) return fmt::format("cartesian gives zero in {}", samples_of(series));
  if (other.norm() <= kUnexplained * one.norm()) return fmt::format("relative gives zero in {}", samples_of(series));
  const double factor = (one.array() * other.array()).sum() / one.squaredNorm();
  if ((other - factor * one).norm() > kUnexplained * difference) return "";
  const auto is = [&](double value) { return std::abs(factor - value) < kUnexplained * std::abs(value); };
  if (is(-1.0)) {
    return fmt::format("same size, opposite sign in {}: check side, point and frame before the dynamics",
                       samples_of(series));
  }
  if (is(2.0)) return fmt::format("factor two: relative is twice cartesian in {}", samples_of(series));
  if (is(0.5)) return fmt::format("factor two: cartesian is twice relative in {}", samples_of(series));
  return fmt::format("constant factor: relative is {:.6g} times cartesian in {}", factor, samples_of(series));
}

std::string other_frame_pattern(const Suspect& suspect) {
  if (suspect.quantity.kind != Kind::reaction && suspect.quantity.kind != Kind::total) return "";
  const int block = suspect.quantity.component < 3 ? 0 : 3;
  const auto side_row = [&](Side side) {
    return suspect.layout.first_row(suspect.quantity.kind, suspect.quantity.owner, side) + block;
  };
  const int global =
      suspect.layout.first_row(Kind::reaction_global, suspect.quantity.owner, suspect.quantity.side) + block;
  const Side opposite = suspect.quantity.side == Side::child ? Side::parent : Side::child;
  for (int who = 0; who < 2; ++who) {
    if (suspect.explains(suspect.rows(global, 1 - who), who)) {
      return fmt::format("other frame: {} gives components in global axes", kSolverNames[who]);
    }
    const Vectors across = suspect.rows(side_row(opposite), 1 - who);
    if (suspect.explains(across, who))
      return fmt::format("other side: {} gives the wrench on the {}", kSolverNames[who],
                         opposite == Side::child ? "child" : "parent");
    if (suspect.explains(-across, who)) {
      return fmt::format("other frame: {} gives components in the {}'s joint frame", kSolverNames[who],
                         opposite == Side::child ? "child" : "parent");
    }
  }
  return "";
}

/// The lever c (constant in the vectors' frame) with T_relative - T_cartesian = c x F, in the sense of least squares.
Vec3 fit_lever(const Vectors& difference, const Vectors& force) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (Eigen::Index k = 0; k < force.cols(); ++k) {
    const Vec3 F = force.col(k);
    normal += F.squaredNorm() * Mat3::Identity() - F * F.transpose();
    right += F.cross(difference.col(k));
  }
  return smallest_least_squares(normal, right);
}

std::string other_point_pattern(const Suspect& suspect) {
  const bool is_torque = suspect.quantity.kind != Kind::acceleration && suspect.quantity.component >= 3;
  if (!is_torque) return "";
  const Vectors force = suspect.rows(suspect.first - 3, 0);
  const Vectors other_force = suspect.rows(suspect.first - 3, 1);
  if ((force - other_force).norm() > kUnexplained * force.norm()) return "";
  const Vec3 lever = fit_lever(suspect.vectors[1] - suspect.vectors[0], force);
  Vectors predicted = suspect.vectors[0];
  for (Eigen::Index k = 0; k < force.cols(); ++k) predicted.col(k) += lever.cross(force.col(k));
  if (!suspect.explains(predicted, 1)) return "";
  return fmt::format("other point: the torques differ by lever x force, lever = ({:.6g}, {:.6g}, {:.6g}) m, in {}",
                     lever(0), lever(1), lever(2), samples_of(suspect.series));
}

/// The rotation Q that turns cartesian's vectors best into relative's.
Mat3 fit_rotation(const Vectors& from, const Vectors& to) {
  const Mat3 correlation = to * from.transpose();
  const Eigen::JacobiSVD<MatX> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 U = svd.matrixU();
  const Mat3 V = svd.matrixV();
  Vec3 signs = Vec3::Ones();
  signs(2) = U.determinant() * V.determinant() > 0.0 ? 1.0 : -1.0;
  return U * signs.asDiagonal() * V.transpose();
}

std::string rotation_pattern(const Suspect& suspect) {
  const Mat3 Q = fit_rotation(suspect.vectors[0], suspect.vectors[1]);
  if (suspect.explains(Q * suspect.vectors[0], 1)) {
    const double degrees = angle_between(Mat3::Identity(), Q) * 180.0 / std::numbers::pi;
    return fmt::format("other frame: the same vectors, turned by {:.4g} deg, in {}", degrees,
                       samples_of(suspect.series));
  }
  const Eigen::RowVectorXd norms = suspect.vectors[0].colwise().norm();
  const Eigen::RowVectorXd others = suspect.vectors[1].colwise().norm();
  if ((norms - others).norm() > kUnexplained * suspect.difference) return "";
  return fmt::format("other frame: same size, other direction in {}: check frames and axes",
                     samples_of(suspect.series));
}

/// No pattern: where the difference stands shows at least whether it grows.
std::string growth_pattern(const Suspect& suspect) {
  const Eigen::Index samples = suspect.vectors[0].cols();
  const Eigen::Index early = std::max<Eigen::Index>(1, samples / 10);
  const Vectors difference = suspect.vectors[1] - suspect.vectors[0];
  if (difference.leftCols(early).norm() > 0.1 * difference.rightCols(early).norm()) {
    return "no known pattern: not sign, factor, frame or point";
  }
  return "no known pattern: not sign, factor, frame or point; the difference grows along the samples";
}

}  // namespace

std::string diagnose(const QuantityLayout& layout, const Series& series, int row) {
  const Quantity quantity = layout.quantities()[row];
  const auto line = [&](int who) { return series.values[who].row(row); };
  if (is_scalar_force(quantity.kind) || (quantity.kind == Kind::acceleration && quantity.component >= 6)) {
    const std::string text = factor_pattern(line(0), line(1), series);
    return text.empty() ? "no known pattern: neither sign nor factor" : text;
  }
  const int first = row - quantity.component % 3;
  Suspect suspect{layout, series, quantity, first, {}, 0.0};
  for (int who = 0; who < 2; ++who) suspect.vectors[who] = suspect.rows(first, who);
  suspect.difference = (suspect.vectors[0] - suspect.vectors[1]).norm();
  std::string text = factor_pattern(suspect.vectors[0], suspect.vectors[1], series);
  if (text.empty()) text = factor_pattern(line(0), line(1), series);
  if (text.empty()) text = other_frame_pattern(suspect);
  if (text.empty()) text = other_point_pattern(suspect);
  if (text.empty()) text = rotation_pattern(suspect);
  return text.empty() ? growth_pattern(suspect) : text;
}

}  // namespace concord::compare
