#include "compare/verdict/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/laws/force_elements.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/verdict/draws.h"

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

/// Loads on a body in one state.
struct BodyLoad {
  double mass = 0.0;
  double least_inertia = 0.0;    // about any axis through the centre of mass, kg m2
  double largest_inertia = 0.0;  // the same
  double force = 0.0;
  double torque = 0.0;  // about the body's origin
  VecX modal;           // generalized forces by mode
  VecX modal_mass;
};

class Loads {
 public:
  Loads(const Model& model, const SharedState& shared) : model_(model), shared_(shared), bodies_(model.bodies.size()) {
    for (std::size_t i = 1; i < bodies_.size(); ++i) add_inertia(static_cast<int>(i));
    for (const Evaluation& evaluation : shared.evaluations) add_wrenches(evaluation);
  }

  [[nodiscard]] const BodyLoad& of(int body) const { return bodies_[body]; }

 private:
  void add_inertia(int i) {
    const Body& body = model_.bodies[i];
    const BodyState& state = shared_.state.bodies[i];
    BodyLoad& load = bodies_[i];
    const bool flexible = body.modal.has_value();
    load.mass = flexible ? body.modal->G(0, 0) : body.mass;
    const auto n_modes = static_cast<Eigen::Index>(body.n_modes());
    load.modal = load.modal_mass = VecX::Zero(n_modes);
    double reach = body.center_of_mass_L.norm();
    if (flexible) {
      for (const MassPoint& point : body.modal->mass_points) reach = std::max(reach, point.s0_L.norm());
      for (Eigen::Index m = 0; m < n_modes; ++m) {
        load.modal_mass(m) = body.modal->G.diagonal().segment<3>(4 + 3 * m).sum();
      }
      load.modal = (body.modal->stiffness.cwiseAbs() * state.a.cwiseAbs()) +
                   (body.modal->damping.cwiseAbs() * state.adot.cwiseAbs());
      const Vec3 center = body.modal->G.block<3, 1>(1, 0) / load.mass;
      const Mat3 second = body.modal->G.block<3, 3>(1, 1) - load.mass * center * center.transpose();
      take_inertia(second.trace() * Mat3::Identity() - second, load);
    } else {
      take_inertia(body.inertia_L, load);
    }
    for (const Evaluation& evaluation : shared_.evaluations) {
      const BodyAcceleration& acceleration = evaluation.bodies[i];
      const double turning = acceleration.omegadot.norm() + state.omega.squaredNorm();
      const double size = model_.gravity.norm() + acceleration.vdot.norm() + reach * turning;
      take_force(load, load.mass * size, reach);
      load.torque = std::max(load.torque, load.largest_inertia * turning);  // I omegadot + omega x (I omega)
      load.modal += (load.mass * load.modal_mass).cwiseSqrt() * size;
    }
  }

  static void take_inertia(const Mat3& inertia, BodyLoad& load) {
    load.least_inertia = std::max(0.0, inertia.diagonal().minCoeff());
    load.largest_inertia = inertia.diagonal().maxCoeff();
  }

  static void take_force(BodyLoad& load, double force, double reach) {
    load.force = std::max(load.force, force);
    load.torque = std::max(load.torque, reach * force);
  }

  void take_wrench(const Attachment& side, const Wrench& wrench) {
    if (side.body == kGround) return;
    BodyLoad& load = bodies_[side.body];
    const double force = wrench.force.norm();
    take_force(load, force, side.point_L.norm());
    load.torque = std::max(load.torque, wrench.torque.norm());
    if (load.modal.size() > 0) {
      load.modal += force * side.Psi_t_L.colwise().norm().transpose() +
                    wrench.torque.norm() * side.Psi_r_L.colwise().norm().transpose();
    }
  }

  void add_wrenches(const Evaluation& evaluation) {
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      for (const Side side : kSides) {
        take_wrench(model_.joints[k].on(side), evaluation.joints[k].total_on(side).in_C);
        take_wrench(model_.joints[k].on(side), evaluation.joints[k].reaction_on(side).in_C);
      }
    }
    for (std::size_t e = 0; e < model_.elements.size(); ++e) {
      for (const Side side : kSides) {
        if (const Attachment* end = end_of(model_.elements[e], side)) {
          take_wrench(*end, evaluation.elements[e].on_side(side).in_C);
        }
      }
    }
  }

  const Model& model_;
  const SharedState& shared_;
  std::vector<BodyLoad> bodies_;
};

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

/// How far apart two ends stand [m], over which a force on one is a torque about the other.
double distance_of(const Attachment& one, const Attachment& other, const State& state) {
  return (place(one, state.bodies[one.body]).r_P - place(other, state.bodies[other.body]).r_P).norm();
}

double distance_of_ends(const ForceElement& element, const State& state) {
  const Attachment* parent = end_of(element, Side::parent);
  const Attachment* child = end_of(element, Side::child);
  return parent != nullptr && child != nullptr ? distance_of(*parent, *child, state) : 0.0;
}

}  // namespace

VecX term_sizes(const QuantityLayout& layout, const SharedState& shared) {
  const Model& model = layout.model();
  const Loads loads(model, shared);
  const double length = model.length_scale();
  const auto turns = [&](const CouplingTerm& term) -> bool {
    return turning_speeds(*model.joints[term.joint].type)[static_cast<std::size_t>(speed_of(model, term))];
  };
  // What a joint passes is the rest of the loads on its bodies, and of what couplings bring from other joints.
  const auto of_bodies = [&](int k, bool is_torque) {
    double force = 0.0;
    double torque = 0.0;
    for (const Attachment& side : model.joints[k].sides) {
      if (side.body == kGround) continue;
      force = std::max(force, loads.of(side.body).force);
      torque = std::max(torque, loads.of(side.body).torque);
    }
    const Joint& joint = model.joints[k];
    const double reach = std::max(length, distance_of(joint.sides[0], joint.sides[1], shared.state));
    return is_torque ? std::max(torque, force * reach) : force;
  };
  const auto of_coupling = [&](const Coupling& coupling) {
    double size = 0.0;
    for (const CouplingTerm& term : coupling.terms) {
      size = std::max(size, of_bodies(term.joint, turns(term)) / std::abs(term.factor));
    }
    return size;
  };
  const auto of_joint = [&](int k, bool is_torque) {
    double size = of_bodies(k, is_torque);
    for (const Coupling& coupling : model.couplings) {
      for (const CouplingTerm& term : coupling.terms) {
        if (term.joint != k || turns(term) != is_torque) continue;
        size = std::max(size, of_coupling(coupling) * std::abs(term.factor));
      }
    }
    return size;
  };
  VecX sizes(static_cast<Eigen::Index>(layout.quantities().size()));
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    const bool is_torque = unit_of(model, quantity) == "N m";
    double& size = sizes(static_cast<Eigen::Index>(row));
    size = 0.0;
    switch (quantity.kind) {
      case Kind::coupling:
        size = of_coupling(model.couplings[quantity.owner]);
        break;
      case Kind::element: {
        const ElementWrenches& wrenches = shared.evaluations[0].elements[quantity.owner];
        const double reach = std::max(length, distance_of_ends(model.elements[quantity.owner], shared.state));
        for (const SideWrench& side : wrenches.on) {
          const double force = side.in_C.force.norm();
          size = std::max(size, is_torque ? std::max(side.in_C.torque.norm(), force * reach) : force);
        }
        break;
      }
      case Kind::body_sum: {
        const BodyLoad& load = loads.of(quantity.owner);
        size = is_torque ? load.torque : load.force;
        break;
      }
      case Kind::acceleration: {
        const BodyLoad& load = loads.of(quantity.owner);
        if (quantity.component < 3) {
          size = load.mass > 0.0 ? load.force / load.mass : 0.0;
        } else if (quantity.component < 6) {
          size = load.least_inertia > 0.0 ? load.torque / load.least_inertia : 0.0;
        } else {
          const double mass = load.modal_mass(quantity.component - 6);
          size = mass > 0.0 ? load.modal(quantity.component - 6) / mass : 0.0;
        }
        break;
      }
      default:
        size = of_joint(quantity.owner, is_torque);
    }
  }
  return sizes;
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
