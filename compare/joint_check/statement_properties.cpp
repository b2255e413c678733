#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "compare/audit/referee.h"
#include "compare/joint_check/type_properties.h"
#include "relative/bodies/mobilizer.h"

namespace concord::compare::joint_check {

namespace {

std::string rows_and_speeds(const JointType& type) {
  const auto permitted = static_cast<int>(type.permits_speeds.size());
  if (type.nonholonomic_rows() + permitted > 0 && type.rows() + type.nonholonomic_rows() + permitted != 6) {
    return fmt::format(
        "{} rows are forbidden, {} of velocities alone, and {} velocities permitted; together they must be 6",
        type.rows(), type.nonholonomic_rows(), permitted);
  }
  if (type.rows() + type.n_u() == 6) return {};
  return fmt::format("{} rows are forbidden and {} speeds permitted; together they must be 6", type.rows(), type.n_u());
}

std::string readings_beside_words(const JointType& type) {
  std::vector<int> of_motion;
  for (const joints::Permit& word : type.permits) {
    if (n_q(word) > 0) of_motion.push_back(n_u(word));
  }
  std::vector<int> of_reading;
  for (const joints::Read& word : type.reads) of_reading.push_back(n_u(word));
  if (of_motion == of_reading) return {};
  return fmt::format("the words of the motion have {} speeds, the readings beside them {}; they must be the same",
                     fmt::join(of_motion, ", "), fmt::join(of_reading, ", "));
}

std::string order_of_words(const JointType& type) {
  try {
    const relative::Mobilizer motion(type);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

/// What is missing of a reading beside a motion by functions, whose coordinates are `turns` or not.
struct ReadingBesideFunctions {
  const std::vector<bool>& turns;

  std::string operator()(const joints::TurnOfChildAxis&) const { return is_a_word(); }
  std::string operator()(const joints::TurnOfParentAxis&) const { return is_a_word(); }
  std::string operator()(const joints::SlideAlong&) const { return is_a_word(); }
  std::string operator()(const joints::OrientationOf&) const { return is_a_word(); }
  std::string operator()(const joints::BearingOfGap&) const { return is_a_word(); }
  std::string operator()(const joints::ElevationOfGap&) const { return is_a_word(); }
  std::string operator()(const joints::ByReading& reading) const {
    if (reading.turns != turns) return "motion and reading differ in which coordinates are turns";
    return reading.wrenches == nullptr ? "the reading states no coordinate wrenches" : "";
  }

  static std::string is_a_word() { return "a motion by functions needs one reading by functions"; }
};

/// What is missing of a word of a motion, and of what stands beside it in the type.
struct WordInFull {
  const JointType& type;

  std::string operator()(const joints::Turn&) const { return {}; }
  std::string operator()(const joints::Slide&) const { return {}; }
  std::string operator()(const joints::Arm&) const { return {}; }
  std::string operator()(const joints::Ball&) const { return {}; }
  std::string operator()(const joints::ByMotion& by) const {
    const auto n = static_cast<std::size_t>(by.motion->n());
    if (by.turns.size() != n || by.names.size() != n || (!by.ranges.empty() && by.ranges.size() != n)) {
      return fmt::format("the motion has {} coordinates, but {} turns, {} names and {} ranges", n, by.turns.size(),
                         by.names.size(), by.ranges.size());
    }
    if (type.reads.size() != 1) return ReadingBesideFunctions::is_a_word();
    const joints::Read& reading = type.reads.front();
    const std::string missing = std::visit(ReadingBesideFunctions{by.turns}, reading);
    if (!missing.empty()) return missing;
    const VecX q = PoseSource(type, 0).pose(0).q;
    const joints::Placement at = referee_permits(type, q, VecX::Zero(type.n_u())).placement;
    const joints::Wrenches said = joints::stated_wrenches(reading)(at);
    if (said.cols() != by.motion->n()) {
      return fmt::format("{} coordinate wrenches for {} coordinates", said.cols(), n);
    }
    return {};
  }
};

std::string words_in_full(const JointType& type) {
  for (const joints::Permit& word : type.permits) {
    if (std::string missing = std::visit(WordInFull{type}, word); !missing.empty()) return missing;
  }
  return {};
}

}  // namespace

Properties check_statement(const JointType& type) {
  Properties properties;
  const auto check = [&](const char* name, std::string (*complaint_about)(const JointType&)) {
    // A statement that is wrong in one way is not looked at in the next.
    if (!properties.empty() && !properties.back().holds()) return;
    const std::string complaint = complaint_about(type);
    properties.emplace_back(name, std::nullopt).require(complaint.empty(), -1, [&] { return complaint; });
  };
  check("rows and speeds are six together", rows_and_speeds);
  check("every coordinate has its reading", readings_beside_words);
  check("words stand in an order that has a meaning", order_of_words);
  check("functions say all that is asked of them", words_in_full);
  return properties;
}

}  // namespace concord::compare::joint_check
