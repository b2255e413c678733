#include "compare/audit/geometric_stiffness.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/flexible/beam.h"
#include "common/joints/revolute.h"
#include "common/rotation.h"
#include "compare/audit/places.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A beam askew in its body, on a hinge at its first end, with a load on its last one.
class GeometricStiffnessTest : public ::testing::Test {
 protected:
  GeometricStiffnessTest() {
    beam_.first_end_L = {0.11, -0.24, 0.05};
    beam_.axes = rotation_about(Vec3(1.0, -2.0, 2.0) / 3.0, 0.7);
    beam_.length = 1.3;
    beam_.area = 4.1e-4;
    beam_.second_moment_y = 3.7e-8;
    beam_.second_moment_z = 1.9e-8;
    beam_.torsion_constant = 4e-8;
    beam_.youngs_modulus = 7.1e10;
    beam_.shear_modulus = 2.7e10;
    beam_.density = 2710.0;
    beam_.modes = {{BeamFamily::torsion, 1, false},
                   {BeamFamily::bending_xz, 2, false},
                   {BeamFamily::bending_xz, 1, false},
                   {BeamFamily::axial, 1, false},
                   {BeamFamily::bending_xy, 1, false}};
  }

  void make(BeamSupport support) {
    beam_.support = support;
    Body rod;
    rod.name = "rod";
    rod.modal = make_beam(beam_);
    model_.bodies = {Body{}, rod};
    Joint hinge;
    hinge.name = "A";
    hinge.type = &joints::revolute;
    hinge.sides = {Attachment{}, at_node("first", Vec3::Zero())};
    model_.joints = {hinge};
    // The offset moves the place where the load is given, not the one where it enters the beam.
    Load push;
    push.at = at_node("last", Vec3(-0.2, 0.05, 0.0));
    model_.elements = {{"push", push, {}}};
  }

  [[nodiscard]] Attachment at_node(const std::string& name, const Vec3& offset_L) const {
    const std::vector<ModalNode> nodes = make_beam(beam_).nodes;
    const auto node = std::find_if(nodes.begin(), nodes.end(), [&](const ModalNode& one) { return one.name == name; });
    return {1, node->s0_L + offset_L, Mat3::Identity(), node->Psi_t_L - skew(offset_L) * node->Psi_r_L, node->Psi_r_L};
  }

  /// The beam at rest between a force at its last end, along its axis, and the hinge.
  [[nodiscard]] Sample pulled(double force) const {
    Sample sample = still();
    const Vec3 pull = rotation_of(sample.state.bodies[1].p) * beam_.axes.col(0) * force;
    sample.evaluation.elements[0].on[index(Side::child)].in_global.force = pull;
    sample.evaluation.joints[0].total[index(Side::child)].in_global.force = -pull;
    return sample;
  }

  [[nodiscard]] Sample still() const {
    Sample sample;
    sample.state.bodies.resize(2);
    BodyState& rod = sample.state.bodies[1];
    rod.p = Vec4(0.5, -0.1, 0.7, 0.2).normalized();
    rod.a = rod.adot = VecX::Zero(model_.bodies[1].n_modes());
    sample.evaluation.bodies.resize(2);
    sample.evaluation.bodies[1].addot = rod.a;
    sample.evaluation.joints.resize(1);
    sample.evaluation.elements.resize(1);
    return sample;
  }

  [[nodiscard]] std::vector<GeometricStiffness> ratios(const std::vector<Sample>& samples) const {
    Trajectory run;
    run.samples = samples;
    return geometric_stiffness(model_, run);
  }

  [[nodiscard]] double EI_y() const { return beam_.youngs_modulus * beam_.second_moment_y; }
  [[nodiscard]] double EI_z() const { return beam_.youngs_modulus * beam_.second_moment_z; }

  BeamSpecification beam_;
  Model model_;
};

TEST_F(GeometricStiffnessTest, APinnedBeamBucklesAtEulersLoad) {
  make(BeamSupport::simply_supported);
  const double L = beam_.length;
  const double critical = std::pow(std::numbers::pi / L, 2) * EI_z();
  std::vector<Sample> samples{pulled(0.3 * critical), pulled(-critical), pulled(-0.2 * critical)};
  for (std::size_t k = 0; k < 3; ++k) samples[k].state.t = 0.1 * static_cast<double>(k);
  const auto found = ratios(samples);
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].body, "rod");
  EXPECT_EQ(found[0].plane, "bending_xy");
  EXPECT_EQ(found[0].mode, 5);
  EXPECT_NEAR(found[0].lowest, -1.0, 1e-5);
  EXPECT_NEAR(found[0].highest, 0.3, 1e-5);
  EXPECT_EQ(found[0].t_lowest, 0.1);
  EXPECT_EQ(found[0].t_highest, 0.0);
  EXPECT_EQ(found[1].plane, "bending_xz");
  EXPECT_EQ(found[1].mode, 2) << "the lower one of two, which has the family's first column";
  EXPECT_NEAR(found[1].lowest, -beam_.second_moment_z / beam_.second_moment_y, 1e-5);
}

TEST_F(GeometricStiffnessTest, AForceWithinTheSpanCountsUpToItsNode) {
  make(BeamSupport::simply_supported);
  const double critical = std::pow(std::numbers::pi / beam_.length, 2) * EI_z();
  Sample sample = pulled(-critical);
  std::get<Load>(model_.elements[0].what).at = at_node("10", Vec3::Zero());  // of 20: half the span is pressed
  EXPECT_NEAR(ratios({sample})[0].lowest, -0.5, 1e-5);
}

TEST_F(GeometricStiffnessTest, AClampedBeamIsSoftenedByItsFirstModesSlopes) {
  make(BeamSupport::cantilever);
  const double L = beam_.length;
  const double P = 0.4 * EI_y() / (L * L);
  // w = cosh - cos - s (sinh - sin) of b x / L: integral of w'^2 is b s (2 + b s) / L, of w''^2 b^4 / L^3.
  const double b = 1.8751040687119611;
  const double s = 0.7340955137589128;
  const double slopes = b * s * (2.0 + b * s);
  const auto found = ratios({pulled(-P)});
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_NEAR(found[1].lowest, -P * L * L * slopes / (EI_y() * std::pow(b, 4)), 1e-5);
  EXPECT_NEAR(found[0].lowest, found[1].lowest * beam_.second_moment_y / beam_.second_moment_z, 1e-5);
}

TEST_F(GeometricStiffnessTest, ARotatingBeamIsStiffenedByItsCentrifugalForce) {
  make(BeamSupport::cantilever);
  const double L = beam_.length;
  const double speed = 80.0;
  Sample sample = still();
  // About the beam's z axis, through its first end.
  const Mat3 A = rotation_of(sample.state.bodies[1].p);
  const Vec3 omega = A * beam_.axes.col(2) * speed;
  const Vec3 first = A * beam_.first_end_L;
  sample.state.bodies[1].omega = omega;
  sample.state.bodies[1].v = -omega.cross(first);
  sample.evaluation.bodies[1].vdot = -omega.cross(omega.cross(first));
  // Integral of (1 - x^2) / 2 w'^2 with the mode above, by Simpson's rule.
  const double b = 1.8751040687119611;
  const double s = 0.7340955137589128;
  const auto part = [&](double x) {
    const double slope = b * (std::sinh(b * x) + std::sin(b * x) - s * (std::cosh(b * x) - std::cos(b * x)));
    return 0.5 * (1.0 - x * x) * slope * slope;
  };
  double integral = 0.0;
  constexpr int kSteps = 400;
  for (int k = 0; k < kSteps; ++k) {
    const double h = 1.0 / kSteps;
    integral += h / 6.0 * (part(h * k) + 4.0 * part(h * (k + 0.5)) + part(h * (k + 1.0)));
  }
  EXPECT_NEAR(integral, 1.1933, 1e-4) << "Southwell's coefficient of a rotating cantilever";
  const double mass_per_length = beam_.density * beam_.area;
  const double exact = mass_per_length * speed * speed * std::pow(L, 4) * integral / (EI_y() * std::pow(b, 4));
  const auto found = ratios({sample});
  EXPECT_NEAR(found[1].highest / exact, 1.0, 1e-5);
  EXPECT_EQ(found[1].lowest, found[1].highest);
}

TEST_F(GeometricStiffnessTest, AHangingBeamIsStiffenedByItsWeight) {
  make(BeamSupport::simply_supported);
  Sample sample = still();
  const double g = 9.7;
  model_.gravity = rotation_of(sample.state.bodies[1].p) * beam_.axes.col(0) * g;  // the first end is above
  // N = m g (1 - x / L), and the slopes of a half sine are even about the middle: half the weight acts all along.
  const double weight = beam_.density * beam_.area * beam_.length * g;
  const double critical = std::pow(std::numbers::pi / beam_.length, 2) * EI_z();
  EXPECT_NEAR(ratios({sample})[0].highest / (0.5 * weight / critical), 1.0, 1e-5);
}

TEST_F(GeometricStiffnessTest, WhatIsNotKnownOrLargeIsSaid) {
  make(BeamSupport::simply_supported);
  const double critical = std::pow(std::numbers::pi / beam_.length, 2) * EI_z();
  EXPECT_THAT(notes_on(ratios({pulled(0.04 * critical)})), SizeIs(0));
  const auto notes = notes_on(ratios({pulled(-0.061 * critical)}));
  ASSERT_THAT(notes, SizeIs(1));
  EXPECT_THAT(notes[0], HasSubstr("on body rod axial forces reach -6.1 % (t = 0 s) of the elastic stiffness of its "
                                  "lowest mode of bending_xy, a_5"));
  ModalData& modal = *model_.bodies[1].modal;
  modal.mass_points = equivalent_mass_points(modal.G);
  const auto unknown = ratios({pulled(critical)});
  ASSERT_THAT(unknown, SizeIs(1));
  EXPECT_FALSE(unknown[0].is_known);
  EXPECT_FALSE(unknown[0].is_notable());
  EXPECT_THAT(notes_on(unknown)[0], HasSubstr("geometric stiffness of body rod: not known"));
}

TEST_F(GeometricStiffnessTest, WhatExceedsTheStiffnessManyTimesIsToldWithoutANumber) {
  make(BeamSupport::simply_supported);
  const auto notes = notes_on(ratios({pulled(-1e50), pulled(1e50)}));
  ASSERT_THAT(notes, SizeIs(2));
  EXPECT_THAT(notes[0], HasSubstr("axial forces reach less than -1000 % (t = 0 s) to more than +1000 % (t = 0 s) of"));
}

TEST_F(GeometricStiffnessTest, KnowsTheModesThatStretchTheBeam) {
  make(BeamSupport::cantilever);
  EXPECT_EQ(axial_modes(*model_.bodies[1].modal), (std::vector<int>{3}));
  ModalData& modal = *model_.bodies[1].modal;
  modal.mass_points = equivalent_mass_points(modal.G);
  EXPECT_THAT(axial_modes(modal), SizeIs(0)) << "not known to be a beam";
}

TEST_F(GeometricStiffnessTest, AModeThatDoesNotBendHasNone) {
  beam_.modes = {{BeamFamily::torsion, 1, false}, {BeamFamily::axial, 1, false}};
  make(BeamSupport::cantilever);
  EXPECT_THAT(ratios({pulled(1e9)}), SizeIs(0));
}

}  // namespace
}  // namespace concord::compare
