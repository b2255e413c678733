#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/types.h"

/// What no machine can be, whatever its file looks like: checks on numbers and on the graph.
namespace concord {

/// Angle between two directions [rad], 0 to pi.
double angle_between(const Vec3& a, const Vec3& b);

/// What is wrong with an inertia tensor about the centre of mass [kg m2]: a negative principal moment, or one that
/// exceeds the sum of the others (by more than 1e-9 of the largest). Nothing if a mass distribution can have it (S2).
std::optional<std::string> complaint_about_inertia(const Mat3& inertia);

/// "entries (1, 2) and (2, 1) differ: 3 and 4", if a matrix is not symmetric within 1e-12 of its largest entry. Rows
/// and columns count from 1.
std::optional<std::string> complaint_about_symmetry(const MatX& matrix);

/// "its smallest eigenvalue is -2, its largest 5", if a symmetric matrix is not positive semidefinite within 1e-12 of
/// its largest eigenvalue.
std::optional<std::string> complaint_about_semidefiniteness(const MatX& matrix);

/// Indices of the bodies that no chain of joints connects to ground, in order.
std::vector<int> bodies_without_ground(const Model& model);

}  // namespace concord
