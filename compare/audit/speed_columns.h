#pragma once

#include "common/types.h"

/// Matrices over the speeds of one joint, of which there are at most six: they hold their numbers themselves, because
/// the audit makes a dozen of them for each joint and sample.
namespace concord::compare {

inline constexpr int kMostSpeeds = 6;

/// A number for each speed.
using SpeedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostSpeeds, 1>;
/// A motion [ddot; omega_rel] for each speed.
using SpeedColumns = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMostSpeeds>;
/// n_u numbers in each column.
using SpeedMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostSpeeds, kMostSpeeds>;

/// x (n_u x columns of `motions`) with which columns x comes closest to the motions; if the columns lack rank, one of
/// them.
SpeedMatrix nearest_combination(const SpeedColumns& columns, const SpeedColumns& motions);

}  // namespace concord::compare
