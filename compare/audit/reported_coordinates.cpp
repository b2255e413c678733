#include "compare/audit/reported_coordinates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "common/joints/named_coordinates.h"
#include "compare/audit/audit_ledger.h"
#include "compare/audit/digits.h"
#include "compare/audit/element_laws.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/machine_size.h"
#include "compare/audit/places.h"
#include "compare/audit/round_off.h"

namespace concord::compare {

namespace {

/// Runs close their joints to so many units of round-off.
constexpr double kOpen = 1000.0;

/// One number that a run reports of a joint or a turn spring.
struct Entry {
  const std::string* name = nullptr;
  bool turns = false;
  bool is_speed = false;
  double reported = 0.0;
  double by_bodies = 0.0;
};

/// The entries of a joint in one state: its coordinates, and then its speeds. Of an orientation, what is left of the
/// reported turn after that of the bodies, or what its Euler parameters lack of unit length; both should be none.
class Entries {
 public:
  explicit Entries(const Joint& joint) : joint_(joint), coordinates_(named_coordinates(*joint.type)) {
    for (const NamedCoordinate& one : coordinates_) speeds_.push_back("speed of " + one.name);
  }

  [[nodiscard]] std::vector<Entry> in(const State& state, const VecX& q, const VecX& u) const {
    const JointMotion motion = read_motion(*joint_.type, relative_motion_of(joint_, state), q);
    std::vector<Entry> entries;
    Eigen::Index at_q = 0;
    Eigen::Index at_u = 0;
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      const NamedCoordinate& one = coordinates_[k];
      if (one.kind == joints::CoordinateKind::orientation) {
        add_orientation(one.name, q.segment<4>(at_q), motion.q.segment<4>(at_q), entries);
      } else {
        entries.push_back({&one.name, turns(one), false, q(at_q), motion.q(at_q)});
      }
      for (int c = 0; c < joints::n_u(one.kind); ++c) {
        entries.push_back({&speeds_[k], turns(one), true, u(at_u + c), motion.u(at_u + c)});
      }
      at_q += joints::n_q(one.kind);
      at_u += joints::n_u(one.kind);
    }
    return entries;
  }

 private:
  static bool turns(const NamedCoordinate& one) { return one.kind != joints::CoordinateKind::length; }

  static void add_orientation(const std::string& name, const Vec4& reported, const Vec4& by_bodies,
                              std::vector<Entry>& entries) {
    const Vec3 left = rotation_vector_of(rotation_of(reported.normalized()) * rotation_of(by_bodies).transpose());
    entries.push_back({&name, true, false, std::max(left.norm(), std::abs(1.0 - reported.norm())), 0.0});
  }

  const Joint& joint_;
  std::vector<NamedCoordinate> coordinates_;
  std::vector<std::string> speeds_;
};

/// The angle of a turn spring, if it is reported.
std::vector<Entry> entries_of(const TurnSpring& spring, std::size_t element, const State& bodies,
                              const State& reported) {
  static const std::string kAngle = "angle";
  if (reported.spring_angles.empty()) return {};
  const double angle = reported.spring_angles[element];
  return {{&kAngle, true, false, angle, motion_of(spring, bodies, angle).angle}};
}

class CoordinateAudit {
 public:
  CoordinateAudit(const Model& model, const Trajectory& run)
      : length_(model.length_scale()), speed_(MachineSize(model, run).speed_or()) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      owners_.push_back({fmt::format("joint '{}'", model.joints[k].name),
                         [k, entries = Entries(model.joints[k])](const State& bodies, const State& reported) {
                           return entries.in(bodies, reported.q[k], reported.u[k]);
                         }});
    }
    for (std::size_t e = 0; e < model.elements.size(); ++e) {
      const auto* spring = std::get_if<TurnSpring>(&model.elements[e].what);
      if (spring == nullptr) continue;
      owners_.push_back({fmt::format("force element '{}'", model.elements[e].name),
                         [e, spring](const State& bodies, const State& reported) {
                           return entries_of(*spring, e, bodies, reported);
                         }});
    }
  }

  void add(const State& state) {
    std::optional<std::array<State, 2>> moved;
    for (const Owner& owner : owners_) {
      const std::vector<Entry> found = owner.entries(state, state);
      std::vector<double> open;
      for (std::size_t e = 0; e < found.size(); ++e) {
        const double misfit = std::abs(found[e].reported - found[e].by_bodies);
        const double scale = scale_of(found[e], state);
        if (matching_digits(misfit, scale) >= worst_.digits) continue;
        if (!moved) moved = within_roundoff(state, length_);
        if (open.empty()) open = what_round_off_leaves(owner, state, *moved, found);
        const double digits = matching_digits(std::isnan(misfit) ? misfit : std::max(0.0, misfit - open[e]), scale);
        if (digits >= worst_.digits) continue;
        worst_ = {digits, fmt::format("{}, {}", owner.name, *found[e].name), state.t, found[e].reported,
                  found[e].by_bodies};
      }
    }
  }

  [[nodiscard]] const ReportedCoordinate& worst() const { return worst_; }

 private:
  /// What a joint or a turn spring reports, held against bodies in a state of theirs.
  struct Owner {
    std::string name;
    std::function<std::vector<Entry>(const State& bodies, const State& reported)> entries;
  };

  [[nodiscard]] double scale_of(const Entry& entry, const State& state) const {
    if (entry.is_speed) return std::max(std::abs(entry.by_bodies), entry.turns ? speed_ / length_ : speed_);
    return std::max(std::abs(entry.by_bodies), entry.turns ? 1.0 : size_of_places(state, length_));
  }

  /// By entry: how far the reading of the bodies moves with the last digits of the state.
  [[nodiscard]] static std::vector<double> what_round_off_leaves(const Owner& owner, const State& state,
                                                                 const std::array<State, 2>& moved,
                                                                 const std::vector<Entry>& found) {
    std::vector<double> open(found.size(), 0.0);
    for (const State& one : moved) {
      const std::vector<Entry> there = owner.entries(one, state);
      for (std::size_t e = 0; e < found.size(); ++e) {
        const double of_reading = std::abs(there[e].by_bodies - found[e].by_bodies);
        const double of_turn = found[e].is_speed ? 0.0 : std::abs(there[e].reported - found[e].reported);
        open[e] = std::max(open[e], kOpen * std::max(of_reading, of_turn));
      }
    }
    return open;
  }

  double length_;
  double speed_;
  std::vector<Owner> owners_;
  ReportedCoordinate worst_;
};

}  // namespace

bool ReportedCoordinate::holds() const { return digits >= kAudit; }

std::string ReportedCoordinate::text() const {
  return fmt::format(
      "reports joint coordinates that its bodies do not have: {}, t = {:.6g} s: {:.6g} in place of {:.6g}, {} digits "
      "(need {:g})",
      what, t, reported, by_bodies, format_digits(digits), kAudit);
}

ReportedCoordinate audit_reported_coordinates(const Model& model, const Trajectory& run) {
  CoordinateAudit audit(model, run);
  for (const Sample& sample : run.samples) audit.add(sample.state);
  return audit.worst();
}

}  // namespace concord::compare
