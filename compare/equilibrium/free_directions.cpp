#include "compare/equilibrium/free_directions.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "common/error.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/verdict/motion_names.h"

namespace concord::compare {

std::vector<FreeDirection> name_free_directions(const Model& model, const Chart& chart, const MatX& directions) {
  if (directions.cols() == 0) return {};
  MatX motions(chart.basis().rows(), directions.cols());
  for (Eigen::Index k = 0; k < directions.cols(); ++k) motions.col(k) = chart.velocities(directions.col(k));
  motions = separate_motions(model, chart.origin(), std::move(motions));
  std::vector<FreeDirection> named;
  for (const auto& motion : motions.colwise()) named.push_back({describe_motion(model, chart.origin(), motion)});
  return named;
}

std::string describe_sense(const Model& model, const State& state, const VecX& velocities) {
  State moving = state;
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < moving.bodies.size(); ++i) {
    BodyState& body = moving.bodies[i];
    body.v = velocities.segment<3>(row);
    body.omega = velocities.segment<3>(row + 3);
    body.adot = velocities.segment(row + 6, body.adot.size());
    row += 6 + body.adot.size();
  }
  const std::string motion = describe_motion(model, state, velocities);
  const VecX speeds = joint_speeds(model, moving);
  if (speeds.size() == 0) return motion;
  Eigen::Index fastest = 0;
  if (!(speeds.cwiseAbs().maxCoeff(&fastest) > 0.0)) return motion;
  const char* sense = speeds(fastest) > 0.0 ? "grows" : "falls";
  for (const Joint& joint : model.joints) {
    const std::vector<std::string> names = speed_names(*joint.type);
    const auto n = static_cast<Eigen::Index>(names.size());
    if (fastest < n) {
      return fmt::format("{} ({} of {} {})", motion, names[static_cast<std::size_t>(fastest)], joint.name, sense);
    }
    fastest -= n;
  }
  return motion;
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
