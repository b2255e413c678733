#include "compare/verdict/prediction.h"

#include "compare/audit/element_laws.h"
#include "compare/audit/places.h"

namespace concord::compare {

State predict(const Model& model, const Sample& now, double h) {
  State guess = now.state;
  guess.t += h;
  for (std::size_t i = 1; i < guess.bodies.size(); ++i) {
    BodyState& body = guess.bodies[i];
    const BodyAcceleration& rate = now.evaluation.bodies[i];
    body.r += h * body.v + 0.5 * h * h * rate.vdot;
    const Vec3 turn = h * body.omega + 0.5 * h * h * rate.omegadot;
    body.p = turned(body.p, turn);
    body.v += h * rate.vdot;
    body.omega += h * rate.omegadot;
    body.a += h * body.adot + 0.5 * h * h * rate.addot;
    body.adot += h * rate.addot;
  }
  // Turns stay counted because the hints move on with them.
  for (std::size_t e = 0; e < guess.spring_angles.size(); ++e) {
    const auto* spring = std::get_if<TurnSpring>(&model.elements[e].what);
    if (spring == nullptr) continue;
    const TurnMotion turn = motion_of(*spring, now.state, now.state.known_angle(e));
    guess.spring_angles[e] = turn.angle + h * turn.rate;
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const joints::JointType& type = *model.joints[k].type;
    for (int word = 0; word < static_cast<int>(type.permits.size()); ++word) {
      const joints::Permit& permit = type.permits[word];
      if (is_orientation(permit)) continue;
      guess.q[k].segment(first_q(type, word), n_q(permit)) += h * guess.u[k].segment(first_u(type, word), n_u(permit));
    }
  }
  return guess;
}

}  // namespace concord::compare
