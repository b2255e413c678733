#include "compare/fuzz/shrink.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/joints/catalogue.h"
#include "compare/random_machines/generator.h"
#include "compare/random_machines/writer.h"

using namespace concord;
using namespace concord::compare::fuzz;

namespace {

bool has_joint(const Machine& machine, const std::string& type) {
  return std::any_of(machine.joints.begin(), machine.joints.end(),
                     [&](const JointPlan& joint) { return joint.type->name == type; });
}

bool has_element(const Machine& machine, const std::string& table) {
  return std::any_of(machine.elements.begin(), machine.elements.end(),
                     [&](const ElementPlan& element) { return element.table == table; });
}

/// Shrinks with an outcome that is a property of the machine, and counts the candidates that were looked at.
template <class Property>
Machine shrunk(const Machine& machine, const Property& keeps, int& tried) {
  return shrink(machine, 1, [&](const std::vector<Machine>& candidates) -> std::optional<std::size_t> {
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      ++tried;
      if (keeps(candidates[k])) return k;
    }
    return std::nullopt;
  });
}

}  // namespace

TEST(Shrink, LeavesWhatTheOutcomeNeedsAndLittleElse) {
  int found = 0;
  double before = 0.0;
  double after = 0.0;
  for (std::uint64_t number = 0; number < 400 && found < 5; ++number) {
    const Machine machine = draw_machine(77, number, Style::forces);
    if (machine.bodies.size() < 4 || !has_joint(machine, "universal") || !has_element(machine, "line_spring")) continue;
    ++found;
    const auto keeps = [](const Machine& one) {
      return has_joint(one, "universal") && has_element(one, "line_spring");
    };
    int tried = 0;
    const Machine small = shrunk(machine, keeps, tried);
    EXPECT_TRUE(keeps(small));
    EXPECT_EQ(small.elements.size(), 1U) << number;
    EXPECT_TRUE(small.couplings.empty());
    EXPECT_LE(small.bodies.size(), 4U);
    before += size_of(machine);
    after += size_of(small);
    EXPECT_LT(write_machine(small).model.size(), write_machine(machine).model.size());
    EXPECT_LT(tried, 3000);
  }
  EXPECT_EQ(found, 5);
  EXPECT_LT(after, 0.7 * before);
}

TEST(Shrink, LoopStaysClosedWhenNumbersAreRounded) {
  for (std::uint64_t number = 0; number < 20; ++number) {
    const Machine machine = draw_machine(78, number, Style::loops);
    if (machine.joints.size() < machine.bodies.size()) continue;
    const auto keeps = [](const Machine& one) { return one.joints.size() >= one.bodies.size(); };
    int tried = 0;
    const Machine small = shrunk(machine, keeps, tried);
    EXPECT_GE(small.joints.size(), small.bodies.size());
    EXPECT_LE(size_of(small), size_of(machine));
  }
}

TEST(Shrink, MachineWhoseOutcomeNothingKeepsStaysAsItIs) {
  const Machine machine = draw_machine(79, 3, Style::mixed);
  int tried = 0;
  const Machine same = shrunk(
      machine, [](const Machine&) { return false; }, tried);
  EXPECT_EQ(pack(write_machine(same)), pack(write_machine(machine)));
  EXPECT_GT(tried, 10);
}

TEST(Shrink, EveryCandidateIsSmaller) {
  for (std::uint64_t number = 0; number < 20; ++number) {
    const Machine machine = draw_machine(80, number, Style::mixed);
    for (const Machine& candidate : smaller_machines(machine, 1)) EXPECT_LT(size_of(candidate), size_of(machine));
  }
}
