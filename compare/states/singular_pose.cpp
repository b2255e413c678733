#include "compare/states/singular_pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "common/error.h"
#include "compare/quantities/agreement.h"

namespace concord::compare {

RankReports report_ranks(const std::array<Solver*, 2>& solvers, std::vector<SharedState>& states, int& dropped,
                         std::string& why) {
  RankReports reports;
  std::vector<SharedState> kept;
  for (SharedState& shared : states) {
    try {
      std::array<RankReport, 2> both{solvers[0]->rank(shared.state), solvers[1]->rank(shared.state)};
      reports.push_back(std::move(both));
      kept.push_back(std::move(shared));
    } catch (const SolverError& error) {
      if (dropped++ == 0) why = error.what();
    }
  }
  states = std::move(kept);
  return reports;
}

bool is_beside_singular(const RankReport& report) { return report.smallest_kept <= kBesideSingular; }

double known_from_closing(const RankReport& report) {
  constexpr double kElsewhere = 1e-4;
  const double sigma = report.smallest_kept;
  if (!(sigma > 0.0)) return 0.0;
  return std::min(kWithinResolution * std::numeric_limits<double>::epsilon() / (sigma * sigma), kElsewhere);
}

namespace {

/// Whether a body that joints hold redundantly stands elsewhere in the other pose, by 1e-4 of the model's length, or is
/// turned by so much; any body where no joint does. What moves beside a locked loop says nothing of it.
bool are_apart(const Model& model, const RankReport& report, const State& one, const State& other) {
  constexpr double kElsewhere = 1e-4;
  const double away = kElsewhere * model.length_scale();
  std::set<int> bodies;
  for (std::size_t k = 0; k < report.joints.size(); ++k) {
    const auto& unique = report.joints[k].unique;
    const auto has_redundant = [](const auto& flags) {
      return !std::all_of(flags.begin(), flags.end(), std::identity());
    };
    if (!std::any_of(unique.begin(), unique.end(), has_redundant)) continue;
    for (const Attachment& side : model.joints[k].sides) bodies.insert(side.body);
  }
  for (int i = 1; bodies.empty() && i < static_cast<int>(one.bodies.size()); ++i) bodies.insert(bodies.end(), i);
  return std::any_of(bodies.begin(), bodies.end(), [&](int i) {
    const BodyState& here = one.bodies[static_cast<std::size_t>(i)];
    const BodyState& there = other.bodies[static_cast<std::size_t>(i)];
    return (here.r - there.r).norm() > away ||
           std::min((here.p - there.p).norm(), (here.p + there.p).norm()) > kElsewhere;
  });
}

}  // namespace

SingularPoses::SingularPoses(const Model& model, const std::vector<SharedState>& states, const RankReports& reports) {
  for (std::size_t who = 0; who < 2; ++who) {
    int largest = 0;
    int clear = 0;
    bool moves = false;
    std::optional<std::size_t> first;
    for (std::size_t k = 0; k < reports.size(); ++k) {
      const RankReport& report = reports[k][who];
      largest = std::max(largest, report.rank);
      if (is_beside_singular(report)) continue;
      clear = std::max(clear, report.rank);
      if (!first) first = k;
      moves = moves || (k != *first && are_apart(model, report, states[*first].state, states[k].state));
    }
    // A machine that is locked in a singular pose is apart from it in no other.
    general_[who] = {moves ? clear : largest, moves};
  }
}

std::vector<std::string> SingularPoses::reasons(const std::array<Solver*, 2>& solvers,
                                                const std::vector<SharedState>& states,
                                                const RankReports& reports) const {
  std::vector<std::string> why(states.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    for (std::size_t who = 0; who < 2 && why[k].empty(); ++who) {
      if (!is_singular(reports[k][who], who)) continue;
      why[k] =
          fmt::format("{}: at t = {:.6g} s the pose is singular: the constraints have rank {} there, {} in other poses",
                      solvers[who]->name(), states[k].state.t, reports[k][who].rank, general_rank(who));
    }
  }
  return why;
}

int SingularPoses::leave_out_beside(std::vector<SharedState>& states, RankReports& reports) const {
  const auto is_left_out = [&](std::size_t k) {
    const auto is_beside = [&](std::size_t who) {
      return general_[who].is_clear && is_beside_singular(reports[k][who]);
    };
    return states[k].row < 0 && (is_beside(0) || is_beside(1));
  };
  std::size_t kept = 0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (is_left_out(k)) continue;
    if (kept != k) {
      states[kept] = std::move(states[k]);
      reports[kept] = std::move(reports[k]);
    }
    ++kept;
  }
  const auto left_out = static_cast<int>(states.size() - kept);
  states.resize(kept);
  reports.resize(kept);
  return left_out;
}

}  // namespace concord::compare
