#include "compare/joint_check/rig_properties.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/joint_check/opinions.h"
#include "compare/joint_check/rig.h"
#include "compare/joint_check/rig_states.h"
#include "compare/quantities/needs.h"

namespace concord::compare::joint_check {

namespace {

constexpr double kNeed = 12.0;       // digits of wrenches, accelerations and their audit, rigid and flexible
constexpr double kStateNeed = 12.0;  // of closed states and of coordinates read back

/// Whether so many coordinates of a type can be driven, and a start be said for the rest: no more than there are
/// speeds, and where only some of a ball's speeds are possible none, because a start keeps all three or no one.
bool can_be_driven(const JointType& type, std::size_t driven) {
  const bool has_ball = std::any_of(type.permits.begin(), type.permits.end(),
                                    [](const joints::Permit& word) { return is_orientation(word); });
  if (type.nonholonomic_rows() > 0 && has_ball) return false;
  return static_cast<int>(driven) <= type.n_u() - type.nonholonomic_rows();
}

/// Loads of all coordinates, for one column of the table; several where the driven coordinate is one of many.
std::vector<std::vector<Load>> loads_of(std::size_t column, const JointType& type) {
  const std::size_t coordinates = coordinates_of(type).size();
  if (column == 0) return {std::vector<Load>(coordinates, Load::none)};
  if (coordinates == 0) return {};
  if (column == 1) return {std::vector<Load>(coordinates, Load::spring)};
  if (column == 2) return {std::vector<Load>(coordinates, Load::motor)};
  if (!can_be_driven(type, column == 3 ? coordinates : 1)) return {};
  if (column == 3) return {std::vector<Load>(coordinates, Load::driver)};
  std::vector<std::vector<Load>> mixed;
  for (std::size_t driven = 0; driven < coordinates && coordinates > 1; ++driven) {
    mixed.emplace_back(coordinates, Load::spring)[driven] = Load::driver;
  }
  return mixed;
}

std::string plain_name(AuditRule rule) {
  switch (rule) {
    case AuditRule::free_body:
      return "audit: every body moves as the wrenches on it say";
    case AuditRule::workless:
      return "audit: the reaction is workless";
    case AuditRule::both_sides:
      return "audit: both sides are in balance";
    case AuditRule::two_frames:
      return "audit: joint frame and global axes say the same";
    case AuditRule::drivers:
      return "audit: what drivers, springs and motors add is their coordinate wrench";
    case AuditRule::force_law:
      return "audit: springs and motors obey their laws";
    case AuditRule::kinematics:
      return "audit: places, velocities and accelerations are such as the joint permits";
    case AuditRule::driver_law:
      return "audit: driven coordinates follow their laws";
    case AuditRule::derivatives:
      return "audit: derivatives of functions are those by differences";
    default:
      return fmt::format("audit: {}", name_of(rule));
  }
}

class RigCheck {
 public:
  RigCheck(const JointType& type, std::uint32_t seed, const std::vector<int>& poses)
      : type_(type), seed_(seed), poses_(poses) {
    for (int pair = 0; pair < WrenchTable::kPairs; ++pair) {
      for (int load = 0; load < WrenchTable::kLoads; ++load) {
        for (int rig = 0; rig < WrenchTable::kRigs; ++rig) {
          cells_.emplace_back(
              fmt::format("same wrenches and accelerations: {}, {}, {}", WrenchTable::pair_names()[pair],
                          WrenchTable::load_names()[load], WrenchTable::rig_names()[rig]),
              kNeed);
        }
      }
    }
    // The last rule, on modal data, is one of beams, of which no rig is made.
    for (int rule = 0; rule < static_cast<int>(AuditRule::modal_data); ++rule) {
      const auto which = static_cast<AuditRule>(rule);
      audits_.emplace_back(plain_name(which), need_of(which) < kAudit ? need_of(which) : kNeed);
    }
  }

  void run() {
    for (int pair = 0; pair < WrenchTable::kPairs; ++pair) {
      for (const bool against : {false, true}) {
        for (int column = 0; column < WrenchTable::kLoads; ++column) {
          for (const std::vector<Load>& loads : loads_of(column, type_)) {
            build_in({pair >= 2, pair % 2 == 1, against, loads}, pair, column);
          }
        }
      }
    }
    if (finished_.holds()) require_carried(type_, largest_, carried_);
  }

  [[nodiscard]] RigFindings findings() const {
    RigFindings found;
    found.properties = {finished_, exchanged_, turns_, rank_, carried_};
    found.properties.insert(found.properties.end(), audits_.begin(), audits_.end());
    found.wrenches.cells = cells_;
    return found;
  }

 private:
  /// One rig through everything; what a solver throws is a finding.
  void build_in(const Arrangement& arrangement, int pair, int column) {
    try {
      Rig rig(type_, arrangement, seed_);
      look_at(rig, arrangement, pair, column);
      finished_.require(true, -1, [] { return ""; });
    } catch (const std::exception& error) {
      finished_.require(false, -1, [&] { return fmt::format("{}: {}", describe(arrangement), error.what()); });
    }
  }

  void look_at(Rig& rig, const Arrangement& arrangement, int pair, int column) {
    const std::string context = describe(arrangement);
    if (column == 0) exchange_states(rig, seed_, poses_, context, exchanged_);
    if (column == 0 && pair == 3) follow_turns(rig, turns_);
    if (column == 0 || column == 3) require_rank(rig, arrangement, poses_.front(), rank_);
    const Opinions opinions = ask_all(rig, poses_);
    Property* cells = &cells_[(pair * WrenchTable::kLoads + column) * WrenchTable::kRigs];
    for (const Opinion other : {tree_open, cut_idle}) {
      compare_opinions(rig, opinions, cartesian_open, other, context, cells[0]);
    }
    for (const Opinion other : {tree_loop, cut_loop}) {
      compare_opinions(rig, opinions, cartesian_loop, other, context, cells[1]);
    }
    note_audits(opinions, context, audits_);
    note_largest(rig, opinions, largest_);
  }

  const JointType& type_;
  std::uint32_t seed_;
  const std::vector<int>& poses_;
  Property finished_{"both solvers build the rigs and finish", {}};
  Property exchanged_{"each solver accepts the other's states", kStateNeed};
  Property turns_{"turns are counted, in the tree and cut, by both solvers", kStateNeed};
  Property rank_{"constraints have full rank, every reaction is unique", {}};
  Property carried_{"the components that the type carries, and no others, appear", {}};
  Properties audits_;
  std::vector<Property> cells_;
  Largest largest_{Vec6::Zero(), Vec6::Zero()};
};

}  // namespace

const std::array<std::string, WrenchTable::kPairs>& WrenchTable::pair_names() {
  static const std::array<std::string, kPairs> names{"rigid - rigid", "rigid - flexible", "flexible - rigid",
                                                     "flexible - flexible"};
  return names;
}

const std::array<std::string, WrenchTable::kLoads>& WrenchTable::load_names() {
  static const std::array<std::string, kLoads> names{"free", "sprung", "motored", "driven", "one driven, rest sprung"};
  return names;
}

const std::array<std::string, WrenchTable::kRigs>& WrenchTable::rig_names() {
  static const std::array<std::string, kRigs> names{"open", "closed"};
  return names;
}

RigFindings check_in_rigs(const JointType& type, std::uint32_t seed, const std::vector<int>& poses) {
  RigCheck check(type, seed, poses);
  check.run();
  return check.findings();
}

}  // namespace concord::compare::joint_check
