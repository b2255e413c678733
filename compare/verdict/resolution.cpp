#include "compare/verdict/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "compare/verdict/draws.h"
#include "compare/verdict/term_sizes.h"

namespace concord::compare {

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double largest_of(const VecX& values) { return values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0.0; }

/// Adds up to one unit of round-off of `size` to every number.
template <class Values>
void move_by_roundoff(Values& values, double size, Draws& draws) {
  for (double& one : values) one += kEps * size * draws.next();
}

/// Of each mode with unit amplitude, over the body's mass points.
VecX largest_displacements(const Body& body) {
  VecX largest = VecX::Zero(body.n_modes());
  if (!body.modal) return largest;
  for (const MassPoint& point : body.modal->mass_points) {
    largest = largest.cwiseMax(point.Psi_t_L.colwise().norm().transpose());
  }
  return largest;
}

/// How far two states are from each other, relative to the sizes of their numbers; modes by how far they move a body,
/// as they may be nothing but round-off.
double distance(const State& one, const State& other, const StateSizes& sizes) {
  double largest = 0.0;
  const auto take = [&](const VecX& difference, double size) {
    if (size > 0.0) largest = std::max(largest, largest_of(difference) / size);
  };
  for (std::size_t i = 1; i < one.bodies.size(); ++i) {
    const BodyState& a = one.bodies[i];
    const BodyState& b = other.bodies[i];
    take(a.r - b.r, sizes.place);
    largest = std::max(largest, std::min((a.p - b.p).norm(), (a.p + b.p).norm()));
    take(a.v - b.v, sizes.velocity);
    take(a.omega - b.omega, sizes.turning);
    take((a.a - b.a).cwiseProduct(sizes.shapes[i]), sizes.place);
    take((a.adot - b.adot).cwiseProduct(sizes.shapes[i]), sizes.velocity);
  }
  return largest;
}

/// The largest over the components that belong together: three of a force, of a torque and of an acceleration, all
/// modes.
void take_largest_of_blocks(const QuantityLayout& layout, VecX& values) {
  const auto& quantities = layout.quantities();
  const auto block_of = [&](std::size_t row) {
    const Quantity& one = quantities[row];
    return std::tuple(one.kind, one.owner, one.side, std::min(one.component / 3, one.kind == Kind::driver ? 0 : 2));
  };
  for (std::size_t first = 0; first < quantities.size();) {
    std::size_t end = first + 1;
    if (quantities[first].kind != Kind::driver && quantities[first].kind != Kind::coupling) {
      while (end < quantities.size() && block_of(end) == block_of(first)) ++end;
    }
    auto block = values.segment(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(end - first));
    block.setConstant(block.maxCoeff());
    first = end;
  }
}

}  // namespace

StateSizes sizes_of(const Model& model, const State& state) {
  const double length = model.length_scale();
  StateSizes sizes;
  sizes.place = length;
  sizes.modal.assign(state.bodies.size(), 0.0);
  for (const Body& body : model.bodies) sizes.shapes.push_back(largest_displacements(body));
  sizes.modal_rate.assign(state.bodies.size(), 0.0);
  double fastest = 0.0;
  double turning = 0.0;
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    const BodyState& body = state.bodies[i];
    sizes.place = std::max(sizes.place, body.r.cwiseAbs().maxCoeff());
    fastest = std::max(fastest, body.v.cwiseAbs().maxCoeff());
    turning = std::max(turning, body.omega.cwiseAbs().maxCoeff());
    sizes.modal[i] = largest_of(body.a);
    sizes.modal_rate[i] = largest_of(body.adot);
  }
  sizes.velocity = std::max(fastest, turning * length);
  sizes.turning = std::max(turning, fastest / length);
  return sizes;
}

State draw_within_roundoff(const State& state, const StateSizes& sizes, std::uint64_t seed) {
  State drawn = state;
  Draws draws(seed);
  for (std::size_t i = 1; i < drawn.bodies.size(); ++i) {
    BodyState& body = drawn.bodies[i];
    move_by_roundoff(body.r, sizes.place, draws);
    move_by_roundoff(body.p, 1.0, draws);
    move_by_roundoff(body.v, sizes.velocity, draws);
    move_by_roundoff(body.omega, sizes.turning, draws);
    move_by_roundoff(body.a, sizes.modal[i], draws);
    move_by_roundoff(body.adot, sizes.modal_rate[i], draws);
  }
  return drawn;
}

namespace {

/// Of one state, by one solver: the largest change of each quantity; nothing if too few draws were valid.
class StateResolution {
 public:
  StateResolution(const QuantityLayout& layout, const SharedState& shared, std::uint64_t seed, Resolution& result)
      : layout_(layout), shared_(shared), sizes_(sizes_of(layout.model(), shared.state)), result_(result) {
    for (int draw = 0; draw < kDraws; ++draw) {
      drawn_.push_back(draw_within_roundoff(shared.state, sizes_, seed + static_cast<std::uint64_t>(draw)));
    }
  }

  /// Why the state is singular within round-off; empty if it is not.
  [[nodiscard]] const std::string& singular() const { return singular_; }

  std::optional<VecX> of(Solver& solver, const VecX& said) {
    VecX change = VecX::Zero(said.size());
    int valid = 0;
    for (const State& drawn : drawn_) {
      const auto moved = answer(solver, drawn);
      if (!moved) continue;
      change = change.cwiseMax((*moved - said).cwiseAbs());
      ++valid;
    }
    if (valid < kFewestDraws) return std::nullopt;
    if (const auto closed = solver.close(shared_.state)) {
      if (distance(*closed, shared_.state, sizes_) > kSameClosing) {
        ++result_.closings_left_out;
      } else if (const auto moved = answer(solver, *closed)) {
        change = change.cwiseMax((*moved - said).cwiseAbs());
      }
    }
    take_largest_of_blocks(layout_, change);
    return change;
  }

 private:
  std::optional<VecX> answer(Solver& solver, const State& state) {
    try {
      VecX values = layout_.observe(state, solver.evaluate(state));
      if (values.allFinite()) return values;
    } catch (const SingularPose& error) {
      singular_ = error.what();
    } catch (const SolverError&) {  // less than round-off away from a limit
    }
    return std::nullopt;
  }

  const QuantityLayout& layout_;
  const SharedState& shared_;
  StateSizes sizes_;
  Resolution& result_;
  std::vector<State> drawn_;
  std::string singular_;
};

/// Seeds of different states.
std::uint64_t seed_of(std::uint64_t seed, Eigen::Index state) {
  constexpr std::uint64_t kApart = 1000003;
  return seed + kApart * static_cast<std::uint64_t>(state);
}

}  // namespace

Resolution measure_resolution(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers,
                              const std::vector<SharedState>& states, const std::vector<Measured>& measured,
                              std::uint64_t seed) {
  const auto rows = static_cast<Eigen::Index>(layout.quantities().size());
  const auto columns = static_cast<Eigen::Index>(states.size());
  Resolution result;
  result.both = MatX::Constant(rows, columns, kUnknown);
  result.own = {result.both, result.both};
  VecX scales(rows);
  for (Eigen::Index row = 0; row < rows; ++row) scales(row) = measured[static_cast<std::size_t>(row)].scale;
  for (Eigen::Index column = 0; column < columns; ++column) {
    const SharedState& shared = states[static_cast<std::size_t>(column)];
    StateResolution one(layout, shared, seed_of(seed, column), result);
    bool known = true;
    for (const Who who : {Who::cartesian, Who::relative}) {
      const VecX said = layout.observe(shared.state, shared.evaluations[index(who)]);
      const auto change = one.of(*solvers[index(who)], said);
      known = known && change.has_value();
      if (change) result.own[index(who)].col(column) = *change;
    }
    result.singular.push_back(one.singular());
    if (!known) {
      ++result.unknown_states;
      continue;
    }
    const VecX floor = kEps * scales.cwiseMax(term_sizes(layout, shared));
    result.both.col(column) = result.own[0].col(column).cwiseMax(result.own[1].col(column)) + floor;
  }
  return result;
}

MatX measure_own_resolution(const QuantityLayout& layout, Solver& solver, Who who,
                            const std::vector<SharedState>& states, std::uint64_t seed) {
  Resolution counts;
  MatX own = MatX::Constant(static_cast<Eigen::Index>(layout.quantities().size()),
                            static_cast<Eigen::Index>(states.size()), kUnknown);
  for (Eigen::Index column = 0; column < own.cols(); ++column) {
    const SharedState& state = states[static_cast<std::size_t>(column)];
    StateResolution one(layout, state, seed_of(seed, column), counts);
    if (const auto change = one.of(solver, layout.observe(state.state, state.evaluations[index(who)]))) {
      own.col(column) = *change;
    }
  }
  return own;
}

MatX resolution_of_run(const Resolution& resolution, const std::vector<SharedState>& states, int samples) {
  MatX of_run = MatX::Constant(resolution.both.rows(), samples, kUnknown);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const int row = states[k].row;
    if (row < 0 || row >= samples) continue;
    auto column = of_run.col(row);
    const auto found = resolution.both.col(static_cast<Eigen::Index>(k));
    column = column.array().isNaN().select(found, column.cwiseMax(found)).eval();
  }
  return of_run;
}

}  // namespace concord::compare
