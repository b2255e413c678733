#include "relative/states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "relative/exponential_map.h"

namespace concord::relative {

namespace {

double largest(const Vec6& values) { return values.cwiseAbs().maxCoeff(); }

void require_numbers(const BodyState& body, const std::string& name, double t) {
  if (body.r.allFinite() && body.p.allFinite() && body.v.allFinite() && body.omega.allFinite() && body.a.allFinite() &&
      body.adot.allFinite()) {
    return;
  }
  throw SolverError(
      fmt::format("relative: the state at t = {:.6g} s holds for body '{}' what is no finite number", t, name));
}

}  // namespace

States::States(const Equations& equations)
    : equations_(&equations), kinematics_(equations.model()), length_(equations.model().length_scale()) {
  for (std::size_t k = 0; k < equations.model().joints.size(); ++k) {
    measures_.emplace_back(kinematics_.motion(static_cast<int>(k)),
                           equations.driven().data() + equations.topology().joints[k].first_u);
    permitted_.emplace_back(*equations.model().joints[k].type, kinematics_.motion(static_cast<int>(k)));
  }
}

void States::require_shape(const State& state) const {
  const Model& model = equations_->model();
  if (state.bodies.size() != model.bodies.size()) {
    throw SolverError(fmt::format("relative: the state has {} bodies, the model {} (ground included)",
                                  state.bodies.size(), model.bodies.size()));
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const int m = model.bodies[i].n_modes();
    if (state.bodies[i].a.size() == m && state.bodies[i].adot.size() == m) continue;
    throw SolverError(
        fmt::format("relative: the state has {} modal coordinates and {} rates for body '{}', which has "
                    "{} modes",
                    state.bodies[i].a.size(), state.bodies[i].adot.size(), model.bodies[i].name, m));
  }
}

Coordinates States::read(const State& state, StateMisfit& misfit) {
  require_shape(state);
  const Model& model = equations_->model();
  const Topology& topology = equations_->topology();
  Coordinates found{state.t, equations_->home(), VecX::Zero(topology.n_u)};
  double size = 1.0;
  double speed = 1.0;
  misfit = {};
  const auto judge = [&misfit](double value, const char* kind, const std::string& name) {
    if (std::isnan(misfit.largest) || value <= misfit.largest) return;
    misfit = {value, fmt::format("{} '{}'", kind, name)};
  };
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyState& body = state.bodies[i];
    require_numbers(body, model.bodies[i].name, state.t);
    found.q.segment(topology.modes[i].first_q, topology.modes[i].n_q) = body.a;
    found.u.segment(topology.modes[i].first_u, topology.modes[i].n_u) = body.adot;
    size = std::max(size, body.r.cwiseAbs().maxCoeff());
    speed = std::max({speed, body.v.cwiseAbs().maxCoeff(), body.omega.cwiseAbs().maxCoeff()});
    judge(std::abs(body.p.norm() - 1.0), "body", model.bodies[i].name);
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Span& span = topology.joints[k];
    if (k < state.q.size() && state.q[k].size() == span.n_q) found.q.segment(span.first_q, span.n_q) = state.q[k];
  }
  equations_->prescribe(state.t, found.q, found.u);

  kinematics_.place(state.bodies);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Span& span = topology.joints[k];
    JointMeasure& measure = measures_[k];
    const JointPoint& parent = kinematics_.point(static_cast<int>(k), Side::parent);
    const JointPoint& child = kinematics_.point(static_cast<int>(k), Side::child);
    measure.find_q(parent, child, found.q.data() + span.first_q, true);
    measure.find_u(parent, child, found.q.data() + span.first_q, found.u.data() + span.first_u);
    kinematics_.require_rank(static_cast<int>(k), measure.motion_at());
    judge(largest(measure.error()) / size, "joint", model.joints[k].name);
    judge(largest(measure.slip()) / speed, "joint", model.joints[k].name);
    judge(slip_of(static_cast<int>(k), found.u) / speed, "joint", model.joints[k].name);
  }
  for (const Coupling& coupling : model.couplings) {
    const double factors = size_of(coupling, model, length_);
    const double gap = compute_gap(coupling, model, topology, found.q) / factors;
    const double slip = compute_slip(coupling, model, topology, found.u) / factors;
    judge(std::abs(gap) / std::max(1.0, found.q.cwiseAbs().maxCoeff()), "coupling", coupling.name);
    judge(std::abs(slip) / speed, "coupling", coupling.name);
  }
  return found;
}

/// How far the speeds of a joint are from those that its type permits [rad/s]; after its coordinates and speeds have
/// been measured.
double States::slip_of(int joint, const VecX& u) {
  PermittedSpeeds& permitted = permitted_[joint];
  if (permitted.n_rows() == 0) return 0.0;
  permitted.evaluate(measures_[joint].motion_at(), equations_->model().joints[joint].name);
  const Span& span = equations_->topology().joints[joint];
  const VecX slip = permitted.C().transpose() * u.segment(span.first_u, span.n_u);
  return slip.cwiseAbs().maxCoeff();
}

State States::write(double t, const State& before) const {
  const Model& model = equations_->model();
  const Topology& topology = equations_->topology();
  State state;
  state.t = t;
  state.bodies.resize(model.bodies.size());
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyMotion& motion = equations_->kinematics().body(static_cast<int>(i));
    const Vec4 near = before.bodies.empty() ? Vec4(Vec4::Unit(0)) : before.bodies[i].p;
    BodyState& body = state.bodies[i];
    body.r = motion.r;
    body.p = euler_parameters(motion.A, near);
    body.v = motion.v;
    body.omega = motion.omega;
    body.a = equations_->q().segment(topology.modes[i].first_q, topology.modes[i].n_q);
    body.adot = equations_->u().segment(topology.modes[i].first_u, topology.modes[i].n_u);
  }
  for (const Span& span : topology.joints) {
    state.q.emplace_back(equations_->q().segment(span.first_q, span.n_q));
    state.u.emplace_back(equations_->u().segment(span.first_u, span.n_u));
  }
  return state;
}

Evaluation States::write_evaluation() const {
  Evaluation evaluation;
  const auto n = static_cast<int>(equations_->model().bodies.size());
  for (int i = 0; i < n; ++i) evaluation.bodies.push_back(equations_->acceleration(i));
  evaluation.joints = equations_->reactions().joints();
  evaluation.elements = equations_->applied_forces().elements();
  evaluation.couplings = equations_->reactions().couplings();
  return evaluation;
}

}  // namespace concord::relative
