#include "cartesian/start/open_joint.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

#include "cartesian/rank/closing_system.h"
#include "common/decompositions.h"

namespace concord::cartesian {

namespace {

/// Joints left open that forbid something, the one first that should be the place of the gap.
std::vector<JointIndex> places_to_try(const Model& model, const Closing& closing) {
  std::vector<JointIndex> places;
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& joint = pick(model.joints, k);
    const auto& open = closing.joints_left_open;
    const bool is_open = std::find(open.begin(), open.end(), joint.name) != open.end();
    if (is_open && joint.type->rows() > 0) places.push_back(k);
  }
  std::reverse(places.begin(), places.end());
  std::stable_partition(places.begin(), places.end(), [&](JointIndex k) { return pick(model.joints, k).named_as_cut; });
  return places;
}

/// The gap of a joint at the last update, and how it counts in the machine's units.
std::optional<JointGap> gap_at(const Equations& equations, JointIndex k) {
  const JointEquations& joint = equations.moving_constraints().joint(k);
  auto gap = gap_of(*pick(equations.model().joints, k).type, joint.motion, equations.length());
  if (gap) gap->A_C = joint.marker(Side::parent).A_joint;
  return gap;
}

double size_of(const JointGap& gap, double length) {
  return std::max(gap.apart_C.norm() / length, gap.turned_C.norm());
}

}  // namespace

namespace {

double largest_of(const VecX& residual) { return residual.size() == 0 ? 0.0 : residual.lpNorm<Eigen::Infinity>(); }

/// The step against the residuals by least squares, each column damped by a row of its own.
VecX damped_step(const ClosingSystem& system, double damping) {
  const Eigen::Index rows = system.jacobian.rows();
  const Eigen::Index columns = system.jacobian.cols();
  MatX damped = MatX::Zero(rows + columns, columns);
  damped.topRows(rows) = system.jacobian;
  damped.bottomRows(columns).diagonal().setConstant(damping);
  VecX right = VecX::Zero(rows + columns);
  right.head(rows) = -system.residual;
  return least_squares(damped, right);
}

/// Levenberg's and Marquardt's method on the sum of the squared residuals, which need not vanish; returns what is left.
VecX come_nearest(Equations& equations, double t, const Holding& hold, VecX& q, const VecX& Y) {
  constexpr int kMostTried = 100;
  constexpr double kLeastDamping = 1e-6;
  constexpr double kMostDamping = 1e3;
  constexpr double kFarthest = 0.5;  // the machine's length, rad
  constexpr double kStands = 1e-12;
  const VecX units = units_of_steps(equations, Kept::coordinates, Modes::kept);
  const RoundOffShares none(equations.constraints());
  const auto system_at = [&](const VecX& at) {
    equations.update(t, at, Y);
    ClosingSystem system =
        make_system(equations, hold, Kept::coordinates, units, none, kept_at(equations, hold.what, Kept::coordinates));
    write_jacobian(equations, Kept::coordinates, units, system);
    return system;
  };
  ClosingSystem system = system_at(q);
  double damping = kLeastDamping;
  for (int tried = 0; tried < kMostTried && damping < kMostDamping; ++tried) {
    VecX move = damped_step(system, damping);
    const double farthest = move.lpNorm<Eigen::Infinity>();
    if (!(farthest > kStands)) break;
    move *= std::min(1.0, kFarthest / farthest);
    VecX moved = q;
    equations.layout().displace(units.cwiseProduct(move), moved);
    ClosingSystem reached = system_at(moved);
    if (reached.residual.norm() < system.residual.norm()) {
      q = std::move(moved);
      system = std::move(reached);
      damping = std::max(0.1 * damping, kLeastDamping);
    } else {
      damping *= 10.0;
    }
  }
  equations.update(t, q, Y);
  return system.residual;
}

/// Moves q so that all that is held closes but for what the joint `giving_way` forbids, whose gap becomes as small as
/// the others let it, modes kept. Whether the others close.
bool close_others(Equations& equations, double t, Hold hold, JointIndex giving_way, VecX& q, const VecX& Y) {
  constexpr double kLeastWeight = 1e-4;
  constexpr double kOthersClosed = 1e-6;  // of what is left open: the weights by which it was found, squared
  constexpr int kMostRows = 120;          // of dense matrices
  if (equations.constraints().n_rows() > kMostRows) return false;
  VecX left;
  double weight = 1.0;
  for (; weight >= kLeastWeight; weight *= 0.3) {
    left = come_nearest(equations, t, {hold, giving_way, weight}, q, Y);
  }
  weight /= 0.3;
  const JointLayout& joint = equations.constraints().joint(giving_way);
  auto own = left.segment(joint.first_row.value, joint.n_forbids);
  const double open = largest_of(own) / weight;
  own.setZero();
  return largest_of(left) <= kOthersClosed * open;
}

}  // namespace

std::string named_open(const Closing& closing) {
  std::string names = fmt::format("joints {}", fmt::join(closing.joints_left_open, ", "));
  if (closing.joints_left_open.empty()) names.clear();
  for (const std::string& coupling : closing.couplings_left_open) {
    names += fmt::format("{}coupling '{}'", names.empty() ? "" : " and ", coupling);
  }
  return names;
}

std::optional<JointGap> gap_of(const joints::JointType& type, const RelativeMotion& motion, double length) {
  constexpr int kMostSteps = 50;
  constexpr double kConverged = 1e-12;
  constexpr double kLongestStep = 0.5;
  RelativeMotion nearest;
  nearest.d = motion.d;
  nearest.R = motion.R;
  ConstraintRow rows[kMaxRows];
  for (int step = 0; step < kMostSteps; ++step) {
    const int n = evaluate_forbids(type, nearest, rows);
    MatX gradients(n, 6);
    VecX values(n);
    for (int k = 0; k < n; ++k) {
      gradients.row(k) << length * rows[k].over_d.transpose(), rows[k].over_rho.transpose();
      values(k) = rows[k].value;
    }
    Vec6 move = smallest_least_squares(gradients, -values);
    if (!move.allFinite()) return std::nullopt;
    const double farthest = move.lpNorm<Eigen::Infinity>();
    if (farthest > kLongestStep) move *= kLongestStep / farthest;
    nearest.d += length * move.head<3>();
    nearest.R = exponential_rotation(move.tail<3>()) * nearest.R;
    if (farthest > kConverged) continue;
    const Eigen::AngleAxisd turned(motion.R * nearest.R.transpose());
    return JointGap{motion.d - nearest.d, turned.angle() * turned.axis()};
  }
  return std::nullopt;
}

std::string words_of_open_joint(Equations& equations, double t, Hold hold, const Closing& closing, const VecX& q,
                                const VecX& Y) {
  constexpr std::size_t kMostTried = 4;
  constexpr double kClosed = 1e-12;  // rad, or of the machine's length: closed after all, by this way
  const Model& model = equations.model();
  std::vector<JointIndex> places = places_to_try(model, closing);
  places.resize(std::min(places.size(), kMostTried));
  for (const JointIndex k : places) {
    VecX moved = q;
    if (!close_others(equations, t, hold, k, moved, Y)) continue;
    const auto gap = gap_at(equations, k);
    if (gap && size_of(*gap, equations.length()) > kClosed) {
      return fmt::format("where the others are closed, joint '{}' is left open by {}", pick(model.joints, k).name,
                         words_of(*gap, equations.length()));
    }
  }
  equations.update(t, q, Y);
  std::string words;
  double largest = kClosed;
  for (const JointIndex k : places) {
    const auto gap = gap_at(equations, k);
    if (!gap || size_of(*gap, equations.length()) <= largest) continue;
    largest = size_of(*gap, equations.length());
    words = fmt::format("joint '{}' is left open most, by {}", pick(model.joints, k).name,
                        words_of(*gap, equations.length()));
  }
  return words;
}

}  // namespace concord::cartesian
