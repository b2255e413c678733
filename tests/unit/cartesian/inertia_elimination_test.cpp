#include "cartesian/dynamics/inertia_elimination.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cartesian/dynamics/augmented_matrix.h"
#include "cartesian/dynamics/dynamics.h"
#include "cartesian/rank/constraint_rank.h"
#include "cartesian/start/start.h"
#include "common/joints/catalogue.h"
#include "linkage.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

/// A machine somewhere and in motion, its equations solved both ways.
class Solved {
 public:
  explicit Solved(const Model& model, unsigned seed = 7)
      : equations_(model),
        matrix_(equations_),
        elimination_(equations_, modal_masses(equations_)),
        active_(equations_.constraints().n_rows(), true) {
    Numbers numbers(seed);
    VecX q = numbers.matrix(equations_.layout().n_q(), 1, 0.4);
    equations_.layout().normalize(q);
    equations_.update(0.3, q, numbers.matrix(equations_.layout().n_Y(), 1, 1.5));
    right_side_ = numbers.matrix(equations_.layout().n_Y() + equations_.constraints().n_rows(), 1);
  }

  void use_rows(const std::vector<bool>& active) {
    active_ = active;
    matrix_.use_rows(active);
    elimination_.use_rows(active);
    for (const RowIndex row : equations_.constraints().rows()) {
      if (!active[row.value]) right_side_(matrix_.index_of(row)) = 0.0;
    }
  }

  [[nodiscard]] bool eliminates() { return elimination_.factor(equations_); }
  [[nodiscard]] VecX by_elimination() {
    VecX x = right_side_;
    elimination_.solve(x);
    return x;
  }
  /// Refined to round-off.
  [[nodiscard]] VecX by_saddle_lu() {
    matrix_.fill(equations_);
    VecX x = right_side_;
    EXPECT_TRUE(matrix_.lu().factor() && matrix_.lu().solve_refined(x, 0.0));
    return x;
  }
  /// Digits that the two have in common, of accelerations in their units and of multipliers.
  [[nodiscard]] double digits() {
    EXPECT_TRUE(eliminates());
    const VecX exact = by_saddle_lu();
    const VecX difference = by_elimination() - exact;
    const auto n_Y = equations_.layout().n_Y();
    const auto n_rows = equations_.constraints().n_rows();
    const auto in_units = [&](const VecX& x) { return x.head(n_Y).cwiseQuotient(equations_.units()).norm(); };
    const double of_Y = in_units(difference) / in_units(exact);
    const double of_rows = n_rows == 0 ? 0.0 : difference.tail(n_rows).norm() / exact.tail(n_rows).norm();
    return -std::log10(std::max({of_Y, of_rows, 1e-17}));
  }
  [[nodiscard]] double largest_residual(const VecX& x) {
    return elimination_.largest_residual(right_side_, x, VecX::Zero(x.size()));
  }

  Equations equations_;
  AugmentedMatrix matrix_;
  InertiaElimination elimination_;
  std::vector<bool> active_;
  VecX right_side_;
};

/// Bodies with 0, 3, 1, 2, 0, 0 modes and so on, each hung on one before it or on ground, loops closed between any two,
/// two coordinates coupled; among the joints are some that forbid speeds alone.
Model random_machine(unsigned seed, int n_bodies, int n_loops) {
  Numbers numbers(seed);
  Model model = testing::make_pair(seed, *joints::find("cylindrical"), 3, 0);
  model.couplings.push_back({"thread", {{0, 0, 0, 1.0}, {0, 1, 0, 0.1}}, 0.0, {}});
  const std::vector<std::string> types = {"spherical", "revolute", "knife_edge", "universal", "translational"};
  const std::vector<int> modes = {0, 3, 1, 2, 0, 0};
  const auto pick_one = [&](int n) { return static_cast<int>(0.4999 * (1.0 + numbers.one()) * n); };
  for (int i = 3; i <= n_bodies; ++i) {
    model.bodies.push_back(testing::make_body(numbers, "link", modes[i % modes.size()]));
    const joints::JointType& type = *joints::find(types[i % types.size()]);
    model.joints.push_back(testing::make_joint(numbers, model, type, pick_one(i), i));
  }
  for (int loop = 0; loop < n_loops; ++loop) {
    const int parent = pick_one(n_bodies - 1);
    const int child = parent + 1 + pick_one(n_bodies - parent);
    model.joints.push_back(testing::make_joint(numbers, model, *joints::find("spherical"), parent, child));
  }
  return model;
}

TEST(InertiaElimination, SolvesTreesAndLoopsOfRigidAndFlexibleBodiesAsTheWholeMatrixDoes) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Model model = random_machine(seed, 3 + static_cast<int>(seed), static_cast<int>(seed % 4));
    Solved machine(model, seed);
    EXPECT_GT(machine.digits(), 11.0) << "machine " << seed;
  }
}

TEST(InertiaElimination, LeavesOutRowsThatTakeNoPart) {
  const Model model = random_machine(31, 8, 2);
  Solved machine(model);
  std::vector<bool> active(machine.equations_.constraints().n_rows(), true);
  for (const std::size_t idle : {0U, 3U, 4U, 11U}) active[idle] = false;
  machine.use_rows(active);
  EXPECT_GT(machine.digits(), 11.0);
  EXPECT_EQ(machine.by_elimination()(machine.matrix_.index_of(RowIndex(3))), 0.0);
}

/// Planar loops hold each hinge's axis twice.
TEST(InertiaElimination, TellsRowsThatDependOnEachOther) {
  testing::Linkage linkage;
  linkage.loops = 2;
  const Model model = linkage.make();
  Equations equations(model);
  VecX q = VecX::Zero(equations.layout().n_q());
  VecX Y = VecX::Zero(equations.layout().n_Y());
  const State start = assemble_start(equations).state;
  equations.layout().unpack(start, q, Y);
  equations.update(0.0, q, Y);
  InertiaElimination elimination(equations, modal_masses(equations));
  EXPECT_FALSE(elimination.factor(equations));
  elimination.use_rows(choose_rows(equations).independent);
  EXPECT_TRUE(elimination.factor(equations));
}

TEST(InertiaElimination, JudgesEachEquationByItsTerms) {
  const Model model = random_machine(32, 6, 1);
  Solved machine(model);
  ASSERT_TRUE(machine.eliminates());
  const VecX x = machine.by_saddle_lu();
  EXPECT_LT(machine.largest_residual(x), 1e-15);
  for (Eigen::Index place = 0; place < x.size(); ++place) {
    VecX wrong = x;
    wrong(place) *= 1.0 + 1e-8;
    EXPECT_GT(machine.largest_residual(wrong), 1e-12) << place;
    wrong(place) = std::nan("");
    EXPECT_FALSE(machine.largest_residual(wrong) <= 1.0) << place;
  }
}

/// Of a body without inertia, between hinges that let it move only with its neighbours.
Model machine_with_a_link_of(double part) {
  Model model = random_machine(33, 2, 0);
  Numbers numbers(34);
  const joints::JointType& revolute = *joints::find("revolute");
  for (const int body : {3, 4}) {
    model.bodies.push_back(testing::make_body(numbers, "link", 0));
    model.joints.push_back(testing::make_joint(numbers, model, revolute, body - 1, body));
  }
  model.bodies[3].mass *= part;
  model.bodies[3].inertia_L *= part;
  return model;
}

TEST(InertiaElimination, TellsABodyWithoutInertia) {
  const Model model = machine_with_a_link_of(0.0);
  Solved machine(model);
  EXPECT_FALSE(machine.eliminates());
  Solved rod(machine_with_a_link_of(1.0));
  EXPECT_TRUE(rod.eliminates());
}

/// A thin rod: no inertia about one axis, which its joints hold.
TEST(InertiaElimination, TellsABodyWithoutInertiaAboutAnAxis) {
  Model model = machine_with_a_link_of(1.0);
  const Vec3 along = Vec3(0.3, 0.4, -0.5).normalized();
  model.bodies[3].inertia_L = 0.2 * (Mat3::Identity() - along * along.transpose());
  model.bodies[3].center_of_mass_L = 0.1 * along;
  Solved machine(model);
  EXPECT_FALSE(machine.eliminates());
}

/// Factors from a state nearby tell what has changed since; from one far away they are not used.
TEST(InertiaElimination, SolvesNextToAKnownStateToRoundOff) {
  const Model model = random_machine(36, 7, 2);
  Equations equations(model);
  Dynamics dynamics(equations);
  dynamics.keep_places(3);
  Numbers numbers(37);
  VecX q = numbers.matrix(equations.layout().n_q(), 1, 0.4);
  equations.layout().normalize(q);
  const VecX Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
  const VecX first = dynamics.solve_at(0.0, q, Y, Pivots::fresh).Ydot();
  ASSERT_TRUE(dynamics.eliminates_inertias());
  for (const double part : {1e-13, 1e-12, 1e-11, 1e-10, 1e-8, 1e-4, 1e-2}) {
    (void)dynamics.solve_at_place(2, false, 0.0, q, Y);
    VecX aside = q + part * numbers.matrix(q.size(), 1);
    equations.layout().normalize(aside);
    const VecX found = dynamics.solve_at_place(2, true, 0.0, aside, Y).Ydot();
    const VecX exact = dynamics.solve_at(0.0, aside, Y, Pivots::fresh).Ydot();
    EXPECT_LT((found - exact).norm(), 1e-13 * exact.norm()) << part;
    if (part >= 1e-11) EXPECT_GT((first - exact).norm(), 1e-12 * exact.norm()) << part;
  }
}

/// However light the link is, down to nothing, an evaluation between steps has the digits of one that is refined: its
/// body stays in the whole matrix where elimination cannot bear it.
TEST(InertiaElimination, LeavesALightOrMasslessBodyToTheWholeMatrix) {
  for (const double part : {1.0, 1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
    const Model model = machine_with_a_link_of(part);
    Equations equations(model);
    Dynamics dynamics(equations);
    Numbers numbers(35);
    VecX q = numbers.matrix(equations.layout().n_q(), 1, 0.4);
    equations.layout().normalize(q);
    const VecX Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
    const VecX exact = dynamics.solve_at(0.0, q, Y, Pivots::fresh).Ydot();
    if (part >= 1e-3 || part == 0.0) EXPECT_EQ(dynamics.eliminates_inertias(), part > 0.0) << part;
    VecX aside = q;
    aside(0) += 1e-3;
    (void)dynamics.solve_at(0.0, aside, Y, Pivots::kept);
    const VecX found = dynamics.solve_at(0.0, q, Y, Pivots::kept).Ydot();
    EXPECT_LT((found - exact).cwiseQuotient(equations.units()).norm(),
              1e-11 * exact.cwiseQuotient(equations.units()).norm())
        << part;
  }
}

}  // namespace
}  // namespace concord::cartesian
