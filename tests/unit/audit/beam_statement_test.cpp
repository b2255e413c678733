#include "compare/audit/beam_statement.h"

#include <gmock/gmock.h>

#include "common/flexible/beam.h"
#include "common/joints/spherical.h"
#include "common/rotation.h"
#include "compare/audit/balance.h"

namespace concord::compare {
namespace {

using ::testing::Each;

/// A beam in a tilted frame away from the body's origin, its section another in every direction.
BeamSpecification tilted_beam(BeamSupport support, int elements) {
  BeamSpecification beam;
  beam.first_end_L = {0.13, -0.07, 0.21};
  beam.axes = rotation_about(Vec3(2, -1, 2) / 3.0, 0.9);
  beam.length = 0.83;
  beam.elements = elements;
  beam.area = 3.1e-4;
  beam.second_moment_y = 1.7e-8;
  beam.second_moment_z = 4.9e-9;
  beam.torsion_constant = 1.2e-8;
  beam.youngs_modulus = 6.9e10;
  beam.shear_modulus = 2.6e10;
  beam.density = 2730.0;
  beam.damping_ratio = 0.017;
  beam.support = support;
  beam.modes = {{BeamFamily::bending_xz, 1, false},
                {BeamFamily::torsion, 1, false},
                {BeamFamily::bending_xy, 2, false},
                {BeamFamily::axial, 1, false},
                {BeamFamily::bending_xy, 1, false}};
  if (support == BeamSupport::craig_bampton) {
    beam.modes.push_back({BeamFamily::bending_xz, 1, true});
    beam.modes.push_back({BeamFamily::bending_xz, 2, true});
    beam.modes.push_back({BeamFamily::torsion, 1, true});
    beam.modes.push_back({BeamFamily::axial, 1, true});
  }
  return beam;
}

constexpr std::array kSupports{BeamSupport::simply_supported, BeamSupport::cantilever, BeamSupport::free_free,
                               BeamSupport::craig_bampton};

TEST(BeamStatement, SoundModesOfEverySupportAreExplained) {
  for (const BeamSupport support : kSupports) {
    for (const int elements : {3, 20, 400}) {
      const BeamMisfit misfit = compute_misfit_of_beam(make_beam(tilted_beam(support, elements)));
      EXPECT_THAT(misfit.all(), Each(0.0)) << static_cast<int>(support) << " " << elements;
    }
  }
}

class BeamSlip : public ::testing::Test {
 protected:
  [[nodiscard]] BeamMisfit misfit() const { return compute_misfit_of_beam(modal_); }
  /// Modes of a slope other than stated.
  void turn_slopes(const Vec3& about, double factor) {
    const Vec3 axis = modal_.beam->axes * about;
    for (ModalNode& node : modal_.nodes) node.Psi_r_L += (factor - 1.0) * axis * (axis.transpose() * node.Psi_r_L);
  }

  ModalData modal_ = make_beam(tilted_beam(BeamSupport::craig_bampton, 17));
};

/// A slope of z turns a section about -y, not +y.
TEST_F(BeamSlip, ASlopeOfTheWrongSignIsSeenInStiffnessAndMass) {
  turn_slopes(Vec3::UnitY(), -1.0);
  EXPECT_GT(misfit().stiffness, 1e-3);
  EXPECT_GT(misfit().mass, 1e-6);
}

TEST_F(BeamSlip, SlopesATouchTooLargeAreSeen) {
  turn_slopes(Vec3::UnitZ(), 1.0 + 1e-7);
  EXPECT_GT(misfit().stiffness, 1e-9);
}

TEST_F(BeamSlip, HalfOfTheDampingIsSeen) {
  modal_.damping *= 0.5;
  EXPECT_NEAR(misfit().damping, 0.5, 1e-9);
  EXPECT_EQ(misfit().stiffness, 0.0);
}

TEST_F(BeamSlip, DampingWhereNoneIsStatedIsSeen) {
  ModalData undamped = modal_;
  BeamSpecification beam = *modal_.beam;
  beam.damping_ratio = 0.0;
  undamped.beam = std::make_shared<const BeamSpecification>(beam);
  EXPECT_GT(compute_misfit_of_beam(undamped).damping, 1e-3);
}

/// Radii of gyration, or planes of bending, that are swapped.
TEST_F(BeamSlip, ASectionThatLiesOnItsSideIsSeen) {
  BeamSpecification beam = *modal_.beam;
  std::swap(beam.second_moment_y, beam.second_moment_z);
  modal_ = make_beam(beam);
  modal_.beam = std::make_shared<const BeamSpecification>(tilted_beam(BeamSupport::craig_bampton, 17));
  EXPECT_GT(misfit().stiffness, 0.1);
  EXPECT_GT(misfit().mass, 1e-6);
}

TEST_F(BeamSlip, ANodeAtAnotherPlaceIsSeen) {
  modal_.nodes[5].s0_L += 1e-8 * Vec3(0.3, 0.5, -0.8);
  EXPECT_GT(misfit().nodes, 1e-9);
}

TEST_F(BeamSlip, WhatIsNotANumberIsSeen) {
  modal_.stiffness(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(misfit().stiffness == 0.0);
}

/// The audit names the body, whatever the state is, and has no rows for modes of another source.
TEST_F(BeamSlip, TheAuditNamesTheBody) {
  Model model;
  Body beam;
  beam.name = "blade";
  beam.modal = modal_;
  model.bodies = {Body{}, beam};
  const auto rule = static_cast<std::size_t>(AuditRule::modal_data);
  EXPECT_TRUE(Auditor(model).report().rules[rule].holds());
  EXPECT_EQ(Auditor(model).report().rows[rule], 6);
  model.bodies[1].modal->damping(2, 2) *= 1.01;
  const AuditFinding found = Auditor(model).report().rules[rule];
  EXPECT_FALSE(found.holds());
  EXPECT_EQ(found.where, "blade");
  EXPECT_EQ(found.row, "modal damping");
  model.bodies[1].modal->beam.reset();
  EXPECT_EQ(Auditor(model).report().rows[rule], 0);
}

}  // namespace
}  // namespace concord::compare
