#include "compare/resolution/open_reactions.h"

#include <fmt/format.h>

#include <set>

#include "common/error.h"
#include "compare/audit/carried_components.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

bool is_known(const RankReport& report, std::size_t joint, int side, int c) {
  return report.decided.empty() || report.decided.at(joint).unique[side][c];
}

/// Whether both solvers and the audit say the same, without doubt, of every component that the joint can carry.
bool is_agreed(const Model& model, const RankReport& audit, const std::array<RankReport, 2>& reports,
               std::size_t joint) {
  for (const Side side : kSides) {
    for (int c = 0; c < 6; ++c) {
      if (!carries(*model.joints[joint].type, side, c)) continue;
      const bool is_unique = audit.joints[joint].unique[index(side)][c];
      if (!audit.decided[joint].unique[index(side)][c]) return false;
      for (const RankReport& report : reports) {
        if (!is_known(report, joint, index(side), c)) return false;
        if (report.joints.at(joint).unique[index(side)][c] != is_unique) return false;
      }
    }
  }
  return true;
}

bool finds_all_unique(const Model& model, const RankReport& report) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      for (int c = 0; c < 6; ++c) {
        if (!report.joints.at(k).unique[index(side)][c] && carries(*model.joints[k].type, side, c)) return false;
      }
    }
  }
  return true;
}

/// A component that is unique has no part along what is open, and one that is open has some.
void require_as_components(const Model& model, const RankReport& report, const OpenReaction& one) {
  constexpr double kNone = 1e-3;
  constexpr double kSome = 1e-8;
  const Joint& joint = model.joints[static_cast<std::size_t>(one.of.owner)];
  const auto& unique = report.joints[static_cast<std::size_t>(one.of.owner)].unique[index(one.of.side)];
  for (int c = 0; c < 3; ++c) {
    const int component = one.of.component + c;
    if (!carries(*joint.type, one.of.side, component)) continue;
    const double left_out = (Vec3::Unit(c) - one.open.projector() * Vec3::Unit(c)).norm();
    if (unique[static_cast<std::size_t>(component)] ? left_out < kNone : left_out > kSome) continue;
    throw SolverError(fmt::format(
        "{}: concord's own directions in which it is open are wrong, neither the model nor a solver is: {} is {}unique",
        describe_owner(model, one.of), component_names()[static_cast<std::size_t>(component)],
        unique[static_cast<std::size_t>(component)] ? "" : "not "));
  }
}

}  // namespace

std::optional<std::vector<OpenReaction>> open_reactions(const Model& model, const State& state,
                                                        const std::array<RankReport, 2>& reports) {
  std::vector<OpenReaction> found;
  if (finds_all_unique(model, reports[0]) && finds_all_unique(model, reports[1])) return found;
  const MachineConstraints constraints(model, state);
  const RankReport& audit = constraints.report();
  if (!constraints.is_sure()) return std::nullopt;
  for (const RankReport& report : reports) {
    if (report.undecided || report.constraints - report.rank != audit.constraints - audit.rank) return std::nullopt;
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (!is_agreed(model, audit, reports, k)) return std::nullopt;
    const auto joint = static_cast<int>(k);
    for (const Side side : kSides) {
      for (int part = 0; part < 2; ++part) {
        const OpenReaction one{{Kind::reaction, joint, side, 3 * part},
                               open_directions(constraints, joint, side, part)};
        if (!one.open.is_clear) return std::nullopt;
        require_as_components(model, audit, one);
        if (one.open.directions.cols() > 0) found.push_back(one);
      }
    }
  }
  return found;
}

OpenReactions open_reactions(const Model& model, const std::vector<SharedState>& states, const RankReports& reports) {
  OpenReactions open;
  open.reserve(states.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    open.push_back(open_reactions(model, states[k].state, reports[k]));
  }
  return open;
}

Projections projections_of(const QuantityLayout& layout, const OpenReactions& open) {
  Projections all(open.size());
  for (std::size_t k = 0; k < open.size(); ++k) {
    if (!open[k]) continue;
    for (const OpenReaction& one : *open[k]) all[k].push_back({layout.row_of(one.of), one.open.projector()});
  }
  return all;
}

std::optional<PlanarLoops> planar_loops(const Model& model, const State& state, const std::vector<OpenReaction>& open) {
  constexpr double kAlong = 1e-7;
  PlanarLoops found;
  const auto global = [&](const OpenReaction& one) {
    const Attachment& side = model.joints[static_cast<std::size_t>(one.of.owner)].on(one.of.side);
    return Mat3X(place(side, state.bodies[static_cast<std::size_t>(side.body)]).A_joint * one.open.directions);
  };
  for (const OpenReaction& one : open) {
    if (found.joints.empty() || found.joints.back() != one.of.owner) found.joints.push_back(one.of.owner);
    found.has_torques = found.has_torques || one.of.component > 0;
    if (one.of.component > 0) continue;
    const Mat3X directions = global(one);
    if (directions.cols() > 1) return std::nullopt;
    if (found.normal.isZero()) found.normal = directions.col(0);
    if (found.normal.cross(Vec3(directions.col(0))).norm() > kAlong) return std::nullopt;
  }
  std::set<int> bodies;
  for (const int joint : found.joints) {
    for (const Attachment& side : model.joints[static_cast<std::size_t>(joint)].sides) bodies.insert(side.body);
  }
  if (bodies.size() < 3 || found.normal.isZero()) return std::nullopt;
  for (const OpenReaction& one : open) {
    if (one.of.component > 0 && (found.normal.transpose() * global(one)).norm() > kAlong) return std::nullopt;
  }
  Eigen::Index largest = 0;
  found.normal.cwiseAbs().maxCoeff(&largest);
  if (found.normal(largest) < 0.0) found.normal = -found.normal;
  return found;
}

}  // namespace concord::compare
