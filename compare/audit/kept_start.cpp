#include "compare/audit/kept_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/joints/named_coordinates.h"
#include "common/rotation.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/law_of_time.h"

namespace concord::compare {

namespace {

constexpr double kRest = 1e-6;  // of what may be reached: what nothing is compared with
constexpr double kKept = 1e-7;  // solvers keep to round-off, which a fine thread far away magnifies

class StartAudit {
 public:
  StartAudit(const Model& model, const State& start) : model_(model), start_(start), length_(model.length_scale()) {
    know_speeds_of(start);
    know_speed(std::sqrt(model.gravity.norm() * length_));
  }

  void know_speeds_of(const State& state) {
    for (const BodyState& body : state.bodies) {
      speed_ = std::max({speed_, body.v.norm(), body.omega.norm() * length_});
    }
  }
  /// A machine at rest is compared with a part of what it may reach.
  void know_speed(double reached) { speed_ = std::max(speed_, kRest * reached); }

  [[nodiscard]] double length() const { return length_; }

  KeptStart find() {
    for (std::size_t k = 0; k < model_.joints.size(); ++k) hold_joint(model_.joints[k], start_.q[k], start_.u[k]);
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) hold_body(model_.bodies[i], start_.bodies[i]);
    return worst_;
  }

 private:
  void hold_joint(const Joint& joint, const VecX& q, const VecX& u) {
    const joints::JointType& type = *joint.type;
    const std::vector<bool> turns = turning_speeds(type);
    owner_ = "joint " + joint.name;
    for (const NamedCoordinate& one : named_coordinates(type)) {
      const WordStart& word = joint.start[static_cast<std::size_t>(one.word)];
      const int at_q = first_q(type, one.word) + one.component;
      const int at_u = first_u(type, one.word) + one.component;
      const bool is_ball = one.kind == joints::CoordinateKind::orientation;
      const bool is_turn = turns[static_cast<std::size_t>(at_u)];
      if (word.role_q == StartRole::keep) {
        if (is_ball) {
          hold_orientation(one.name, q.segment<4>(at_q), word.q.segment<4>(one.component));
        } else {
          hold_place(one.name, q(at_q), word.q(one.component), is_turn);
        }
      }
      if (word.role_u != StartRole::keep) continue;
      for (int c = 0; c < joints::n_u(one.kind); ++c) {
        hold_speed(one.name, u(at_u + c), word.u(at_u - first_u(type, one.word) + c), is_turn);
      }
    }
    for (const Driver& driver : joint.drivers) hold_driver(joint, driver, q, u, turns);
  }

  void hold_driver(const Joint& joint, const Driver& driver, const VecX& q, const VecX& u,
                   const std::vector<bool>& turns) {
    const int at_u = first_u(*joint.type, driver.word) + driver.component;
    const Moving law = LawOfTime(driver.law).at(0.0);
    const bool is_turn = turns[static_cast<std::size_t>(at_u)];
    hold_place("driver", q(first_q(*joint.type, driver.word) + driver.component), law.value, is_turn);
    hold_speed("driver", u(at_u), law.rate, is_turn);
  }

  void hold_body(const Body& body, const BodyState& state) {
    owner_ = "body " + body.name;
    std::vector<MassPoint> of_rigid;
    VecX displaces = VecX::Zero(body.a_start.size());  // by a unit of each modal coordinate [m]
    for (const MassPoint& point : mass_points_of(body, of_rigid)) {
      if (body.modal) displaces = displaces.cwiseMax(point.Psi_t_L.colwise().norm().transpose());
    }
    hold_modes("a", state.a, body.a_start, kRest * length_, displaces);
    hold_modes("adot", state.adot, body.adot_start, kRest * speed_, displaces);
  }

  /// `rest`: the displacement, or its rate, that one which is nothing is compared with.
  void hold_modes(const char* name, const VecX& found, const VecX& stated, double rest, const VecX& displaces) {
    if (stated.size() == 0) return;
    const double largest = std::max(stated.cwiseAbs().maxCoeff(), found.cwiseAbs().maxCoeff());
    for (Eigen::Index m = 0; m < stated.size(); ++m) {
      const double least = displaces(m) > 0.0 ? rest / displaces(m) : 0.0;
      hold(fmt::format("{}_{}", name, m + 1), found(m), stated(m), std::max(largest, least));
    }
  }

  void hold_orientation(const std::string& name, const Vec4& found, const Vec4& stated) {
    const Mat3 turn = rotation_of(found.normalized()) * rotation_of(stated.normalized()).transpose();
    hold(name, rotation_vector_of(turn).norm(), 0.0, 1.0);
  }

  void hold_place(const std::string& name, double found, double stated, bool is_turn) {
    hold(name, found, stated, std::max(std::abs(stated), is_turn ? 1.0 : length_));
  }

  void hold_speed(const std::string& name, double found, double stated, bool is_turn) {
    hold("speed of " + name, found, stated, std::max(std::abs(stated), is_turn ? speed_ / length_ : speed_));
  }

  void hold(const std::string& what, double found, double stated, double size) {
    constexpr double kClearly = 1.0 + 1e-6;  // of equal ones the first counts
    const double off = size > 0.0 ? std::abs(found - stated) / size : 0.0;
    if (off <= kClearly * worst_.off) return;
    worst_ = {off, owner_, what, found, stated};
  }

  const Model& model_;
  const State& start_;
  double length_;
  double speed_ = 0.0;
  std::string owner_;
  KeptStart worst_;
};

}  // namespace

bool KeptStart::holds() const { return off <= kKept; }

std::string KeptStart::text() const {
  return fmt::format("does not start where the model says: {}, {}: {:.6g} in place of {:.6g}", owner, what, found,
                     stated);
}

KeptStart audit_kept_start(const Model& model, const State& start) { return StartAudit(model, start).find(); }

KeptStart audit_kept_start(const Model& model, const Trajectory& run) {
  if (run.samples.empty()) return {};
  StartAudit audit(model, run.samples.front().state);
  for (const Sample& sample : run.samples) audit.know_speeds_of(sample.state);
  const double until = run.samples.back().state.t;
  if (until > 0.0) audit.know_speed(audit.length() / until);
  return audit.find();
}

}  // namespace concord::compare
