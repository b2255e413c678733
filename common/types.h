#pragma once

#include <Eigen/Dense>
#include <array>

/// Names for the small shapes that cross folder borders. SI units and radians everywhere.
namespace concord {

using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using VecX = Eigen::VectorXd;
using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using MatX = Eigen::MatrixXd;
using Mat3X = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using Mat6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Index of ground in every list of bodies; the moving bodies are 1, 2, ...
inline constexpr int kGround = 0;

enum class Axis { x = 0, y = 1, z = 2 };

constexpr int index(Axis axis) { return static_cast<int>(axis); }

/// The two sides of a joint: motion is measured from the parent to the child.
enum class Side { parent = 0, child = 1 };

constexpr int index(Side side) { return static_cast<int>(side); }

inline constexpr std::array kSides{Side::parent, Side::child};

}  // namespace concord
