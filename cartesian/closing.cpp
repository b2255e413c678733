#include "cartesian/closing.h"

#include <algorithm>
#include <cmath>

#include "cartesian/euler_parameters.h"
#include "cartesian/rank.h"

namespace concord::cartesian {

namespace {

constexpr double kClosed = 1e-13;  // of the largest coordinate, in m or rad, if that is beyond 1
constexpr int kMaxSteps = 80;

/// A row that is no constraint of the machine: a coordinate or speed that the start keeps.
struct KeptRow {
  int joint;
  Row row;        // gradient and, for coordinates, value less the kept value
  double target;  // of a speed
};

/// The turn Q as axis times angle, angle in [0, pi]. Its rate is the angular velocity at Q = 1 and, for any Q, along
/// its own axis: unlike the axial vector of Q it vanishes at Q = 1 alone, so that Newton's steps cannot end at a half
/// turn.
Vec3 rotation_vector(const Mat3& Q) {
  const Eigen::AngleAxisd turn(Q);
  return turn.angle() * turn.axis();
}

enum class Kept { coordinates, speeds };

std::vector<KeptRow> kept_rows(const Equations& equations, Kept what) {
  std::vector<KeptRow> kept;
  const Model& model = equations.model();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& stated = model.joints[k];
    const RelativeMotion& motion = equations.constraints().joint(static_cast<int>(k)).motion;
    for (std::size_t word = 0; word < stated.start.size(); ++word) {
      const WordStart& start = stated.start[word];
      if ((what == Kept::coordinates ? start.role_q : start.role_u) != StartRole::keep) continue;
      const joints::Read* read = read_of(*stated.type, static_cast<int>(word));
      if (read == nullptr) continue;
      const int n = n_speeds(*read);
      Row rows[kMaxRows];
      if (std::holds_alternative<joints::OrientationOf>(*read)) {
        const Vec3 turn = rotation_vector(motion.R * rotation_of(start.q.normalized()).transpose());
        for (int c = 0; c < n; ++c) rows[c] = {.value = turn(c), .over_rho = Vec3::Unit(c)};
      } else {
        for (int c = 0; c < n; ++c) {
          rows[c] = evaluate_read(*read, c, motion);
          const double error = rows[c].value - start.q(c);
          rows[c].value = reads_turn(*read, c) ? std::remainder(error, 2.0 * EIGEN_PI) : error;
        }
      }
      for (int c = 0; c < n; ++c) {
        const bool follows_law = driver_of(stated, static_cast<int>(word), c) != nullptr;
        if (!follows_law) kept.push_back({static_cast<int>(k), rows[c], start.u(c)});
      }
    }
  }
  return kept;
}

/// What a unit of a closing step moves over Y: v by the length, omega by a radian, modes as far as they move a joint by
/// the length, or not at all.
VecX units_of_steps(const Equations& equations, Modes modes) {
  VecX units = column_scales(equations);
  const Layout& layout = equations.layout();
  if (modes == Modes::moving) return units;
  for (int i = 1; i < layout.n_bodies(); ++i) layout.adot(units, i).setZero();
  return units;
}

/// Jacobian over steps in these units: constraints first, then the kept rows. For coordinates the rows that hold for
/// velocities alone are empty, as is their residual.
SparseMatrix closing_jacobian(const Equations& equations, Kept what, const std::vector<KeptRow>& kept,
                              const VecX& units) {
  const Constraints& constraints = equations.constraints();
  const Layout& layout = equations.layout();
  std::vector<Eigen::Triplet<double, SuiteSparse_long>> entries;
  const auto add = [&](int row, int body, const auto& gradient) {
    for (int c = 0; c < layout.size_Y(body); ++c) {
      const int column = layout.first_Y(body) + c;
      if (units(column) > 0.0) entries.emplace_back(row, column, gradient(c) * units(column));
    }
  };
  for (const RowBlock& block : constraints.blocks()) {
    for (int row = 0; row < block.n_rows; ++row) {
      const bool counts = what == Kept::speeds || constraints.holds_positions(block.first_row + row);
      if (counts) add(block.first_row + row, block.body, constraints.columns(block).col(row));
    }
  }
  for (std::size_t k = 0; k < kept.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      const int body = equations.model().joints[kept[k].joint].on(side).body;
      if (body == kGround) continue;
      VecX gradient(layout.size_Y(body));
      constraints.write_transposed(kept[k].joint, side, kept[k].row, gradient);
      add(constraints.n_rows() + static_cast<int>(k), body, gradient);
    }
  }
  SparseMatrix jacobian(constraints.n_rows() + static_cast<Eigen::Index>(kept.size()), layout.n_Y());
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

/// Rank of a closing Jacobian over steps in these units, its rows by their sizes.
int rank_of_rows(const Equations& equations, SparseMatrix jacobian, const VecX& units) {
  const int n_constraints = equations.constraints().n_rows();
  VecX sizes = VecX::Zero(jacobian.rows());
  for (Eigen::Index column = 0; column < jacobian.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(jacobian, column); entry; ++entry) {
      sizes(entry.row()) += entry.value() * entry.value();
    }
  }
  sizes = sizes.cwiseSqrt();
  sizes.head(n_constraints) = row_sizes(equations, units);
  jacobian = sizes.unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 1.0; }).asDiagonal() * jacobian;
  return decide_rank(jacobian).rank;
}

VecX position_residual(const Equations& equations, const std::vector<KeptRow>& kept) {
  VecX residual(equations.constraints().n_rows() + static_cast<Eigen::Index>(kept.size()));
  residual.head(equations.constraints().n_rows()) = equations.residual();
  for (std::size_t k = 0; k < kept.size(); ++k) residual(equations.constraints().n_rows() + k) = kept[k].row.value;
  return residual;
}

VecX velocity_residual(const Equations& equations, const std::vector<KeptRow>& kept) {
  VecX residual(equations.constraints().n_rows() + static_cast<Eigen::Index>(kept.size()));
  residual.head(equations.constraints().n_rows()) = equations.velocity_residual();
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const RelativeMotion& motion = equations.constraints().joint(kept[k].joint).motion;
    residual(equations.constraints().n_rows() + k) = rate_of(kept[k].row, motion) - kept[k].target;
  }
  return residual;
}

double size_of(const VecX& residual) { return residual.size() == 0 ? 0.0 : residual.lpNorm<Eigen::Infinity>(); }

void name_open(const Equations& equations, const std::vector<KeptRow>& kept, const VecX& residual, Closing& closing) {
  const Model& model = equations.model();
  const double large = 0.05 * size_of(residual);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const JointEquations& joint = equations.constraints().joint(static_cast<int>(k));
    double own = size_of(residual.segment(joint.first_row, joint.n_rows));
    for (std::size_t row = 0; row < kept.size(); ++row) {
      if (kept[row].joint != static_cast<int>(k)) continue;
      own = std::max(own, std::abs(residual(equations.constraints().n_rows() + row)));
    }
    if (own >= large) closing.joints_left_open.push_back(model.joints[k].name);
  }
  for (std::size_t g = 0; g < model.couplings.size(); ++g) {
    const double own = std::abs(residual(equations.constraints().coupling(static_cast<int>(g)).row));
    if (own >= large) closing.couplings_left_open.push_back(model.couplings[g].name);
  }
}

/// Whether another Newton step is worth while: not yet closed, or still falling.
bool goes_on(double size, double last, double closed) {
  return size > closed ? true : size > 0.0 && size < 0.25 * last;
}

}  // namespace

bool restrict_modes(const Equations& equations) {
  const auto rank = [&](Modes modes) {
    const VecX units = units_of_steps(equations, modes);
    return rank_of_rows(equations, closing_jacobian(equations, Kept::speeds, {}, units), units);
  };
  return equations.model().is_flexible() && rank(Modes::moving) > rank(Modes::kept);
}

Closing close_machine(Equations& equations, double t, bool keep_start, Modes modes, VecX& q, VecX& Y) {
  constexpr double kLargestTurn = 0.5;  // rad, of one Newton step
  const Layout& layout = equations.layout();
  const VecX units = units_of_steps(equations, modes);
  const auto kept = [&](Kept what) { return keep_start ? kept_rows(equations, what) : std::vector<KeptRow>{}; };

  Closing closing;
  layout.normalize(q);
  const auto closed = [&] { return kClosed * std::max({1.0, size_of(q), equations.constraints().largest_coupled()}); };
  equations.update(t, q, Y);
  VecX residual = position_residual(equations, kept(Kept::coordinates));
  VecX best_q = q;
  double best = size_of(residual);
  double last = HUGE_VAL;
  for (int step = 0; step < kMaxSteps && goes_on(size_of(residual), last, closed()); ++step) {
    last = size_of(residual);
    VecX move =
        solve_shortest(closing_jacobian(equations, Kept::coordinates, kept(Kept::coordinates), units), -residual);
    if (!move.allFinite()) break;
    move *= std::min(1.0, kLargestTurn / (1e-300 + size_of(move)));
    layout.displace(units.cwiseProduct(move), q);
    equations.update(t, q, Y);
    equations.constraints().follow_turns();
    residual = position_residual(equations, kept(Kept::coordinates));
    if (size_of(residual) <= best) {
      best = size_of(residual);
      best_q = q;
    }
  }
  q = best_q;
  equations.update(t, q, Y);
  residual = position_residual(equations, kept(Kept::coordinates));
  closing.position_residual = size_of(residual);
  if (!(closing.position_residual <= closed())) {
    name_open(equations, kept(Kept::coordinates), residual, closing);
    return closing;
  }
  if (const int joint = equations.constraints().first_joint_off_branch(); joint >= 0) {
    closing.joints_left_open = {equations.model().joints[joint].name};
    return closing;
  }

  residual = velocity_residual(equations, kept(Kept::speeds));
  last = HUGE_VAL;
  const double speed = 1.0 + size_of(residual) + size_of(Y);
  for (int step = 0; step < 4 && size_of(residual) > 1e-16 * speed && size_of(residual) < 0.5 * last; ++step) {
    last = size_of(residual);
    const SparseMatrix jacobian = closing_jacobian(equations, Kept::speeds, kept(Kept::speeds), units);
    Y += units.cwiseProduct(solve_shortest(jacobian, -residual));
    equations.update(t, q, Y);
    residual = velocity_residual(equations, kept(Kept::speeds));
  }
  closing.velocity_residual = size_of(residual);
  closing.closed = closing.velocity_residual <= kClosed * (1.0 + size_of(Y));
  if (!closing.closed) name_open(equations, kept(Kept::speeds), residual, closing);
  return closing;
}

KeptCount count_kept(Equations& equations, double t, const VecX& q, const VecX& Y) {
  equations.update(t, q, Y);
  const VecX units = units_of_steps(equations, Modes::kept);
  const auto columns = static_cast<int>((units.array() > 0.0).count());
  const auto rank_with = [&](Kept what, const std::vector<KeptRow>& kept) {
    return rank_of_rows(equations, closing_jacobian(equations, what, kept, units), units);
  };
  const std::vector<KeptRow> coordinates = kept_rows(equations, Kept::coordinates);
  const std::vector<KeptRow> speeds = kept_rows(equations, Kept::speeds);
  const int constrained = rank_with(Kept::coordinates, {});
  const bool has_slip_rows = equations.constraints().has_slip_rows();
  const int speeds_constrained = has_slip_rows ? rank_with(Kept::speeds, {}) : constrained;
  KeptCount count;
  count.coordinates = static_cast<int>(coordinates.size());
  count.speeds = static_cast<int>(speeds.size());
  count.coordinate_freedom = columns - constrained;
  count.speed_freedom = columns - speeds_constrained;
  count.independent_coordinates = rank_with(Kept::coordinates, coordinates) - constrained;
  count.independent_speeds = rank_with(Kept::speeds, speeds) - speeds_constrained;
  return count;
}

}  // namespace concord::cartesian
