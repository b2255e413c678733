#include "compare/audit/kept_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/joints/facts.h"
#include "common/joints/named_coordinates.h"
#include "common/start_words.h"
#include "compare/audit/free_body.h"
#include "compare/audit/law_of_time.h"
#include "compare/audit/machine_rank.h"
#include "compare/audit/machine_size.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

constexpr double kRest = 1e-6;  // of what may be reached: what nothing is compared with
constexpr double kKept = 1e-7;  // solvers keep to round-off, which a fine thread far away magnifies

class StartAudit {
 public:
  /// `speed`: what speeds are held against [m/s].
  StartAudit(const Model& model, const State& start, double speed)
      : model_(model), start_(start), length_(model.length_scale()), speed_(speed) {}

  /// Coordinates of joints alone.
  KeptStart find_in_coordinates() {
    for (std::size_t k = 0; k < model_.joints.size(); ++k) hold_coordinates(model_.joints[k], start_.q[k]);
    require_few_written();
    return worst_;
  }

  KeptStart find() {
    find_in_coordinates();
    for (std::size_t k = 0; k < model_.joints.size(); ++k) hold_speeds(model_.joints[k], start_.u[k]);
    require_few_written();
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) hold_body(model_.bodies[i], start_.bodies[i]);
    return worst_;
  }

 private:
  void hold_coordinates(const Joint& joint, const VecX& q) {
    const joints::JointType& type = *joint.type;
    owner_ = "joint " + joint.name;
    for (const NamedCoordinate& one : named_coordinates(type)) {
      const WordStart& word = joint.start[static_cast<std::size_t>(one.word)];
      if (word.role_q != StartRole::keep) continue;
      const int at = first_q(type, one.word) + one.component;
      if (one.kind == joints::CoordinateKind::orientation) {
        hold_orientation(one.name, q.segment<4>(at), word.q.segment<4>(one.component));
      } else {
        slack_ = slack_of(word.slack_q, word.q, one.component);
        hold_place(one.name, q(at), word.q(one.component), one.kind != joints::CoordinateKind::length);
        slack_ = 0.0;
      }
      kept_ += joints::n_u(one.kind);
    }
    for (const Driver& driver : joint.drivers) {
      hold_place("driver", q(first_q(type, driver.word) + driver.component), LawOfTime(driver.law).at(0.0).value,
                 !joints::is_length(type.permits[driver.word], driver.component));
    }
  }

  void hold_speeds(const Joint& joint, const VecX& u) {
    const joints::JointType& type = *joint.type;
    owner_ = "joint " + joint.name;
    for (const NamedCoordinate& one : named_coordinates(type)) {
      const WordStart& word = joint.start[static_cast<std::size_t>(one.word)];
      if (word.role_u != StartRole::keep) continue;
      const int first = first_u(type, one.word);
      for (int c = one.component; c < one.component + joints::n_u(one.kind); ++c) {
        slack_ = slack_of(word.slack_u, word.u, c);
        hold_speed(one.name, u(first + c), word.u(c), one.kind != joints::CoordinateKind::length);
        slack_ = 0.0;
        ++kept_;
      }
    }
    for (const Driver& driver : joint.drivers) {
      hold_speed("driver", u(first_u(type, driver.word) + driver.component), LawOfTime(driver.law).at(0.0).rate,
                 !joints::is_length(type.permits[driver.word], driver.component));
    }
  }

  void hold_body(const Body& body, const BodyState& state) {
    owner_ = "body " + body.name;
    const VecX displaces = largest_displacements(body);
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
    if (off > kKept && std::abs(found - stated) <= slack_ * kClearly) {
      written_.push_back({off, owner_, what, found, stated});
      return;
    }
    if (std::isnan(worst_.off) || off <= kClearly * worst_.off) return;
    worst_ = {off, owner_, what, found, stated};
  }

  /// Only so many numbers are met no further than they are written as are kept beyond what is free.
  void require_few_written() {
    if (!written_.empty()) {
      int freedom = MachineConstraints(model_, start_).report().degrees_of_freedom;
      for (const Body& body : model_.bodies) freedom -= body.n_modes();
      const auto worst = std::max_element(written_.begin(), written_.end(),
                                          [](const KeptStart& a, const KeptStart& b) { return a.off < b.off; });
      if (std::ssize(written_) > kept_ - freedom && worst->off > worst_.off) worst_ = *worst;
    }
    written_.clear();
    kept_ = 0;
  }

  const Model& model_;
  const State& start_;
  double length_;
  double speed_;
  double slack_ = 0.0;
  std::vector<KeptStart> written_;  // off by more than round-off, within their last digit
  int kept_ = 0;                    // numbers
  std::string owner_;
  KeptStart worst_;
};

}  // namespace

bool KeptStart::holds() const { return off <= kKept; }

std::string KeptStart::text() const {
  return fmt::format("does not start where the model says: {}, {}: {:.6g} in place of {:.6g}", owner, what, found,
                     stated);
}

KeptStart audit_kept_start(const Model& model, const Trajectory& run) {
  if (run.samples.empty()) return {};
  return StartAudit(model, run.samples.front().state, MachineSize(model, run).speed_or()).find();
}

KeptStart audit_kept_start(const Model& model, const State& start) {
  Trajectory run;
  run.samples.push_back({start, {}, 0.0});
  return audit_kept_start(model, run);
}

KeptStart audit_kept_coordinates(const Model& model, const State& start) {
  return StartAudit(model, start, 0.0).find_in_coordinates();
}

}  // namespace concord::compare
