#include "compare/equilibrium/free_directions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/error.h"
#include "compare/states/motion_names.h"

namespace concord::compare {

std::vector<FreeDirection> name_free_directions(const Model& model, const Chart& chart, const MatX& directions) {
  if (directions.cols() == 0) return {};
  MatX motions(chart.basis().rows(), directions.cols());
  for (Eigen::Index k = 0; k < directions.cols(); ++k) motions.col(k) = chart.velocities(directions.col(k));
  motions = separate_motions(model, chart.origin(), std::move(motions));
  std::vector<FreeDirection> named;
  for (const auto& motion : motions.colwise()) named.push_back({describe_motion(model, chart.origin(), motion)});
  // Round-off decides in which order they are told apart.
  std::sort(named.begin(), named.end(), [](const auto& one, const auto& other) { return one.name < other.name; });
  return named;
}

void refuse_singular(Chart& chart, const std::string& name) {
  VecX direction(chart.n());
  for (Eigen::Index k = 0; k < direction.size(); ++k) direction(k) = std::cos(2.0 * static_cast<double>(k));
  direction.normalize();
  for (const double step : {1e-3, 1e-4, 1e-5, 1e-6}) {
    if (chart.at(step * direction, VecX::Zero(chart.n()))) return;
  }
  if (const std::string refusal = chart.refusal_at(1e-6 * direction); !refusal.empty()) throw SolverError(refusal);
  throw SingularPose(
      fmt::format("{}: the constraints permit {}, but no closed states with as many directions of motion are found "
                  "along it: the pose is singular",
                  name, chart.describe(direction)));
}

}  // namespace concord::compare
