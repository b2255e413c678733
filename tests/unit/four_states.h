#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "compare/states/singular_pose.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {

/// Four samples of a pendulum's run, 0.1 s apart, in which both solvers report the same rank and find all unique.
class FourStatesTest : public ::testing::Test {
 protected:
  FourStatesTest() {
    report_.constraints = report_.rank = 5;
    report_.degrees_of_freedom = 1;
    report_.smallest_kept = 0.1;
    report_.joints.resize(1);
    for (int k = 0; k < 4; ++k) {
      states_.emplace_back();
      states_.back().state.t = 0.1 * k;
      states_.back().row = k;
    }
    reports_.assign(4, {report_, report_});
  }

  Model model_ = pendulum_model();
  RankReport report_;
  std::vector<SharedState> states_;
  RankReports reports_;
};

}  // namespace concord::compare
