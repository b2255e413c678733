#include "compare/resolution/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/error.h"
#include "compare/quantities/motions.h"
#include "compare/resolution/term_sizes.h"
#include "compare/states/draws.h"

namespace concord::compare {

namespace {

using UniqueRows = Eigen::Array<bool, Eigen::Dynamic, 1>;

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Adds up to `step` to every number, either way.
template <class Values>
void move(Values& values, double step, Draws& draws) {
  for (double& one : values) one += step * draws.next();
}

/// The largest over the components that belong together: three of a force, of a torque and of an acceleration, all
/// modes. Those that are not unique keep their own: these may be anything.
void take_largest_of_blocks(const QuantityLayout& layout, const UniqueRows& unique, VecX& values) {
  const auto& quantities = layout.quantities();
  const auto block_of = [&](std::size_t row) {
    const Quantity& one = quantities[row];
    return std::tuple(one.kind, one.owner, one.side, std::min(one.component / 3, is_scalar_force(one.kind) ? 0 : 2));
  };
  for (std::size_t first = 0; first < quantities.size();) {
    std::size_t end = first + 1;
    if (!is_scalar_force(quantities[first].kind)) {
      while (end < quantities.size() && block_of(end) == block_of(first)) ++end;
    }
    const auto start = static_cast<Eigen::Index>(first);
    const auto size = static_cast<Eigen::Index>(end - first);
    auto block = values.segment(start, size).array();
    const auto counts = unique.segment(start, size);
    block = counts.select(counts.select(block, 0.0).maxCoeff(), block).eval();
    first = end;
  }
}

}  // namespace

double distance(const State& one, const State& other, const MachineSize& sizes) {
  const double speed = sizes.speed_or();
  double largest = 0.0;
  const auto take = [&](const VecX& difference, double size) {
    if (size > 0.0) largest = std::max(largest, difference.lpNorm<Eigen::Infinity>() / size);
  };
  for (std::size_t i = 1; i < one.bodies.size(); ++i) {
    const BodyState& a = one.bodies[i];
    const BodyState& b = other.bodies[i];
    take(a.r - b.r, sizes.place);
    largest = std::max(largest, std::min((a.p - b.p).norm(), (a.p + b.p).norm()));
    take(a.v - b.v, speed);
    take(a.omega - b.omega, speed / sizes.length);
    take((a.a - b.a).cwiseProduct(sizes.shapes[i]), sizes.place);
    take((a.adot - b.adot).cwiseProduct(sizes.shapes[i]), speed);
  }
  return largest;
}

State draw_within_roundoff(const State& state, const MachineSize& sizes, std::uint64_t seed, double units) {
  const double step = units * kEps;
  State drawn = state;
  Draws draws(seed);
  for (std::size_t i = 1; i < drawn.bodies.size(); ++i) {
    BodyState& body = drawn.bodies[i];
    move(body.r, step * sizes.place, draws);
    move(body.p, step, draws);
    move(body.v, step * sizes.speed, draws);
    move(body.omega, step * sizes.turning, draws);
    move(body.a, step * sizes.modal[i].lpNorm<Eigen::Infinity>(), draws);
    move(body.adot, step * sizes.modal_rate[i].lpNorm<Eigen::Infinity>(), draws);
  }
  return drawn;
}

namespace {

/// Of one state: the largest change of each quantity, as drawn and as closed by a solver.
class StateResolution {
 public:
  StateResolution(const QuantityLayout& layout, const SharedState& shared, UniqueRows unique,
                  std::vector<Projection> parts, std::uint64_t seed, Resolution& result)
      : layout_(layout),
        shared_(shared),
        unique_(std::move(unique)),
        parts_(std::move(parts)),
        sizes_(layout.model(), shared.state),
        seed_(seed),
        result_(result) {
    for (int draw = 0; draw < kDraws; ++draw) {
      drawn_.push_back(draw_within_roundoff(shared.state, sizes_, seed + static_cast<std::uint64_t>(draw)));
    }
  }

  /// Why the state is singular within round-off; empty if it is not.
  [[nodiscard]] const std::string& singular() const { return singular_; }

  /// Over the draws; nothing if too few were valid.
  std::optional<VecX> of_draws(Solver& solver, const VecX& said) {
    VecX change = VecX::Zero(said.size());
    int valid = 0;
    for (const State& drawn : drawn_) {
      const auto moved = answer(solver, drawn);
      if (!moved) continue;
      change = change.cwiseMax(size_of(*moved - said));
      ++valid;
    }
    if (valid < kFewestDraws) return std::nullopt;
    return change;
  }

  /// How often the accelerations hold the round-off of the state, by the change over its draws: as often as the
  /// constraints are nearer to losing rank than to being orthogonal. Of a machine at rest those count that gravity
  /// would give it.
  [[nodiscard]] double amplification(const VecX& said, const VecX& change) const {
    const double length = layout_.model().length_scale();
    double size = layout_.model().gravity.norm();
    double moved = 0.0;
    for (std::size_t row = 0; row < layout_.quantities().size(); ++row) {
      const Quantity& one = layout_.quantities()[row];
      if (one.kind != Kind::acceleration || one.component >= 6) continue;
      const double unit = one.component < 3 ? 1.0 : length;
      size = std::max(size, unit * std::abs(said(static_cast<Eigen::Index>(row))));
      moved = std::max(moved, unit * change(static_cast<Eigen::Index>(row)));
    }
    return size > 0.0 ? moved / (kEps * size) : 0.0;
  }

  /// Over closings too.
  VecX with_closings(Solver& solver, const VecX& said, VecX change, double amplification) {
    // Places are known to round-off times the amplification, velocities to as much more.
    const double allowed =
        std::max(kSameClosing, std::min(kWithinResolution * kEps * amplification * amplification, kElsewhere));
    take_closing(solver, said, allowed, change);
    if (amplification > kIllConditioned) take_pairs_of_closings(solver, said, allowed, change);
    take_largest_of_blocks(layout_, unique_, change);
    return change;
  }

 private:
  static constexpr double kElsewhere = 1e-4;  // no round-off, however ill-conditioned the closing is

  /// Of what is not unique the size of the unique part.
  [[nodiscard]] VecX size_of(VecX difference) const {
    for (const Projection& part : parts_) {
      const Vec3 whole = difference.segment<3>(part.first);
      const Vec3 on_unique = part.on_unique * whole;
      for (int c = 0; c < 3; ++c) {
        if (!unique_(part.first + c)) difference(part.first + c) = on_unique(c);
      }
    }
    return difference.cwiseAbs();
  }

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

  std::optional<VecX> answer_closed(Solver& solver, const State& state, double allowed) {
    const auto closed = solver.close(state);
    if (!closed) return std::nullopt;
    if (distance(*closed, shared_.state, sizes_) <= allowed) return answer(solver, *closed);
    ++result_.closings_left_out;
    return std::nullopt;
  }

  void take_closing(Solver& solver, const VecX& said, double allowed, VecX& change) {
    if (const auto moved = answer_closed(solver, shared_.state, allowed)) {
      change = change.cwiseMax(size_of(*moved - said));
    }
  }

  /// A state that closes is left as it is, and where it stands then is one draw of what the round-off of residuals
  /// does. Others are the states in which a solver closes from opposite sides: the mean of the answers there holds
  /// nothing of the sides.
  void take_pairs_of_closings(Solver& solver, const VecX& said, double allowed, VecX& change) {
    constexpr int kPairs = 3;
    constexpr double kSide = 64.0;  // units of round-off
    for (int pair = 0; pair < kPairs; ++pair) {
      const std::uint64_t seed = seed_ + static_cast<std::uint64_t>(kDraws + pair);
      const auto one = answer_closed(solver, draw_within_roundoff(shared_.state, sizes_, seed, kSide), allowed);
      const auto other = answer_closed(solver, draw_within_roundoff(shared_.state, sizes_, seed, -kSide), allowed);
      if (one && other) change = change.cwiseMax(size_of(0.5 * (*one + *other) - said));
    }
  }

  const QuantityLayout& layout_;
  const SharedState& shared_;
  UniqueRows unique_;
  std::vector<Projection> parts_;
  MachineSize sizes_;
  std::uint64_t seed_;
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
                              const std::vector<SharedState>& states, const Mask& unique,
                              const std::vector<Measured>& measured, std::uint64_t seed, const Projections& parts) {
  const auto rows = static_cast<Eigen::Index>(layout.quantities().size());
  const auto columns = static_cast<Eigen::Index>(states.size());
  Resolution result;
  result.both = MatX::Constant(rows, columns, kUnknown);
  result.own = {result.both, result.both};
  VecX scales(rows);
  for (Eigen::Index row = 0; row < rows; ++row) scales(row) = measured[static_cast<std::size_t>(row)].scale;
  for (Eigen::Index column = 0; column < columns; ++column) {
    const SharedState& shared = states[static_cast<std::size_t>(column)];
    StateResolution one(layout, shared, unique.col(column),
                        parts.empty() ? std::vector<Projection>() : parts[static_cast<std::size_t>(column)],
                        seed_of(seed, column), result);
    std::array<VecX, 2> said;
    std::array<std::optional<VecX>, 2> change;
    double amplification = HUGE_VAL;  // that of the solver that knows better: what the machine has
    for (const Who who : {Who::cartesian, Who::relative}) {
      said[index(who)] = layout.observe(shared.state, shared.evaluations[index(who)]);
      change[index(who)] = one.of_draws(*solvers[index(who)], said[index(who)]);
      if (!change[index(who)]) continue;
      amplification = std::min(amplification, one.amplification(said[index(who)], *change[index(who)]));
    }
    for (const Who who : {Who::cartesian, Who::relative}) {
      if (!change[index(who)]) continue;
      result.own[index(who)].col(column) =
          one.with_closings(*solvers[index(who)], said[index(who)], *change[index(who)], amplification);
    }
    result.singular.push_back(one.singular());
    if (!change[0] || !change[1]) {
      ++result.unknown_states;
      continue;
    }
    const VecX floor = kEps * scales.cwiseMax(term_sizes(layout, shared));
    result.both.col(column) = result.own[0].col(column).cwiseMax(result.own[1].col(column)) + floor;
  }
  return result;
}

MatX measure_own_resolution(const QuantityLayout& layout, Solver& solver, Who who,
                            const std::vector<SharedState>& states, const Mask& unique, std::uint64_t seed) {
  Resolution counts;
  MatX own = MatX::Constant(static_cast<Eigen::Index>(layout.quantities().size()),
                            static_cast<Eigen::Index>(states.size()), kUnknown);
  for (Eigen::Index column = 0; column < own.cols(); ++column) {
    const SharedState& state = states[static_cast<std::size_t>(column)];
    StateResolution one(layout, state, unique.col(column), {}, seed_of(seed, column), counts);
    const VecX said = layout.observe(state.state, state.evaluations[index(who)]);
    if (const auto change = one.of_draws(solver, said)) {
      own.col(column) = one.with_closings(solver, said, *change, one.amplification(said, *change));
    }
  }
  return own;
}

Redraw answers_within_roundoff(const Model& model, Solver& solver, std::uint64_t seed) {
  return [&model, &solver, seed](const State& state, int k) -> std::optional<std::pair<State, Evaluation>> {
    try {
      State moved = draw_within_roundoff(state, {model, state}, seed + static_cast<std::uint64_t>(k));
      Evaluation answer = solver.evaluate(moved);
      return std::pair{std::move(moved), std::move(answer)};
    } catch (const SolverError&) {
      return std::nullopt;
    }
  };
}

MatX resolution_of_run(const Resolution& resolution, const std::vector<SharedState>& states, int samples) {
  MatX of_run = MatX::Constant(resolution.both.rows(), samples, kUnknown);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const int row = states[k].row;
    if (row < 0 || row >= samples) continue;
    auto column = of_run.col(row);
    const VecX found = kUnitsOfARun * resolution.both.col(static_cast<Eigen::Index>(k));
    column = column.array().isNaN().select(found, column.cwiseMax(found)).eval();
  }
  return of_run;
}

}  // namespace concord::compare
