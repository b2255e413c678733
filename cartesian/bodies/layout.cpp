#include "cartesian/bodies/layout.h"

#include "cartesian/bodies/euler_parameters.h"

namespace concord::cartesian {

Layout::Layout(const Model& model) {
  for (const BodyIndex i : indices_of(model.bodies)) {
    const int m = pick(model.bodies, i).n_modes();
    first_q_.add(n_q_);
    first_Y_.add(n_Y_);
    n_modes_.add(m);
    if (is_ground(i)) continue;
    n_q_ += 7 + m;
    n_Y_ += 6 + m;
  }
}

void Layout::unpack(const State& state, VecX& q, VecX& Y) const {
  for (const BodyIndex i : moving_bodies()) {
    const BodyState& body = state.bodies[i.value];
    r(q, i) = body.r;
    p(q, i) = body.p;
    a(q, i) = body.a;
    v(Y, i) = body.v;
    omega(Y, i) = body.omega;
    adot(Y, i) = body.adot;
  }
}

State Layout::pack(double t, const VecX& q, const VecX& Y) const {
  State state;
  state.t = t;
  state.bodies.resize(n_bodies());
  for (const BodyIndex i : moving_bodies()) {
    state.bodies[i.value] = {r(q, i), p(q, i), v(Y, i), omega(Y, i), a(q, i), adot(Y, i)};
  }
  return state;
}

void Layout::write_qdot(const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y, Eigen::Ref<VecX> qdot) const {
  for (const BodyIndex i : moving_bodies()) {
    r(qdot, i) = v(Y, i);
    p(qdot, i) = compute_pdot(p(q, i), omega(Y, i));
    a(qdot, i) = adot(Y, i);
  }
}

void Layout::displace(const Eigen::Ref<const VecX>& step, Eigen::Ref<VecX> q) const {
  for (const BodyIndex i : moving_bodies()) {
    r(q, i) += v(step, i);
    p(q, i) = (p(q, i) + compute_pdot(p(q, i), omega(step, i))).normalized();
    a(q, i) += adot(step, i);
  }
}

void Layout::displace_along(BodyIndex body, int c, double size, Eigen::Ref<VecX> q) const {
  if (c < 3) {
    r(q, body)(c) += size;
  } else if (c < 6) {
    p(q, body) = (p(q, body) + compute_pdot(p(q, body), size * Vec3::Unit(c - 3))).normalized();
  } else {
    a(q, body)(c - 6) += size;
  }
}

void Layout::copy_body(BodyIndex body, const Eigen::Ref<const VecX>& from, Eigen::Ref<VecX> to) const {
  to.segment(first_q_[body], 7 + n_modes_[body]) = from.segment(first_q_[body], 7 + n_modes_[body]);
}

void Layout::normalize(Eigen::Ref<VecX> q) const {
  for (const BodyIndex i : moving_bodies()) p(q, i).normalize();
}

}  // namespace concord::cartesian
