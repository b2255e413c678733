#include "common/flexible/beam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/decompositions.h"
#include "common/rotation.h"

namespace concord {
namespace {

constexpr double kPi = std::numbers::pi;

/// A steel bar of rectangular section: its two bending families differ.
BeamSpecification bar(BeamSupport support, std::vector<BeamMode> modes, int elements = 40) {
  BeamSpecification beam;
  const double height = 0.012;
  const double width = 0.02;
  beam.length = 0.7;
  beam.elements = elements;
  beam.area = height * width;
  beam.second_moment_z = width * std::pow(height, 3) / 12.0;
  beam.second_moment_y = height * std::pow(width, 3) / 12.0;
  beam.torsion_constant = 7.2e-9;
  beam.youngs_modulus = 2.0e11;
  beam.shear_modulus = 7.7e10;
  beam.density = 7870.0;
  beam.support = support;
  beam.modes = std::move(modes);
  return beam;
}

BeamSpecification generic_bar(BeamSupport support, std::vector<BeamMode> modes, int elements = 24) {
  BeamSpecification beam = bar(support, std::move(modes), elements);
  beam.first_end_L = Vec3(0.11, -0.23, 0.37);
  beam.axes = rotation_about(Vec3(1.0, -2.0, 0.5).normalized(), 1.1);
  return beam;
}

const std::vector<BeamMode> kOneOfEach{{BeamFamily::bending_xy, 2, false},
                                       {BeamFamily::torsion, 1, false},
                                       {BeamFamily::bending_xz, 1, false},
                                       {BeamFamily::axial, 1, false}};

const std::vector<BeamMode> kCraigBampton{{BeamFamily::bending_xy, 1, true},  {BeamFamily::bending_xy, 2, true},
                                          {BeamFamily::bending_xz, 1, true},  {BeamFamily::bending_xz, 2, true},
                                          {BeamFamily::torsion, 1, true},     {BeamFamily::axial, 1, true},
                                          {BeamFamily::bending_xy, 1, false}, {BeamFamily::bending_xz, 1, false}};

/// Bending frequency with wave number beta, eq. omega = beta^2 sqrt(E I / rho A).
double bending_frequency(const BeamSpecification& beam, double second_moment, double beta) {
  return beta * beta * std::sqrt(beam.youngs_modulus * second_moment / (beam.density * beam.area));
}

/// Exact frequency of linear elements with consistent mass where the nodal values are sin(beta x + phase).
double linear_element_frequency(double wave_speed, double width, double beta) {
  const double c = std::cos(beta * width);
  return wave_speed / width * std::sqrt(6.0 * (1.0 - c) / (2.0 + c));
}

/// Zero of f between a and b by bisection.
template <class Function>
double root(Function f, double a, double b) {
  for (int k = 0; k < 200; ++k) {
    const double middle = 0.5 * (a + b);
    (f(a) * f(middle) <= 0.0 ? b : a) = middle;
  }
  return 0.5 * (a + b);
}

MatX modal_mass(const ModalData& data) {
  MatX mass(data.n_modes(), data.n_modes());
  for (int a = 0; a < data.n_modes(); ++a) {
    for (int b = 0; b < data.n_modes(); ++b) mass(a, b) = data.G.block<3, 3>(4 + 3 * a, 4 + 3 * b).trace();
  }
  return mass;
}

const ModalNode& node(const ModalData& data, const std::string& name) {
  return *std::find_if(data.nodes.begin(), data.nodes.end(), [&](const ModalNode& n) { return n.name == name; });
}

TEST(Beam, SimplySupportedBendingFrequencies) {
  const auto beam = bar(BeamSupport::simply_supported, {{BeamFamily::bending_xy, 1, false},
                                                        {BeamFamily::bending_xy, 2, false},
                                                        {BeamFamily::bending_xz, 1, false},
                                                        {BeamFamily::bending_xz, 2, false}});
  const ModalData data = make_beam(beam);
  for (int n = 1; n <= 2; ++n) {
    const double beta = n * kPi / beam.length;
    EXPECT_NEAR(data.frequencies(n - 1) / bending_frequency(beam, beam.second_moment_z, beta), 1.0, 1e-6);
    EXPECT_NEAR(data.frequencies(n + 1) / bending_frequency(beam, beam.second_moment_y, beta), 1.0, 1e-6);
  }
}

TEST(Beam, BendingFrequenciesConvergeWithTheFourthPowerOfTheElementWidth) {
  const auto error = [](int elements) {
    const auto beam = bar(BeamSupport::simply_supported, {{BeamFamily::bending_xy, 2, false}}, elements);
    const double exact = bending_frequency(beam, beam.second_moment_z, 2.0 * kPi / beam.length);
    return make_beam(beam).frequencies(0) / exact - 1.0;
  };
  EXPECT_NEAR(std::log2(error(10) / error(20)), 4.0, 0.02);
}

TEST(Beam, CantileverBendingFrequencies) {
  const auto beam =
      bar(BeamSupport::cantilever, {{BeamFamily::bending_xz, 1, false}, {BeamFamily::bending_xz, 2, false}});
  const ModalData data = make_beam(beam);
  const auto equation = [](double x) { return std::cosh(x) * std::cos(x) + 1.0; };
  const double first = root(equation, 1.0, 3.0) / beam.length;
  const double second = root(equation, 4.0, 5.5) / beam.length;
  EXPECT_NEAR(data.frequencies(0) / bending_frequency(beam, beam.second_moment_y, first), 1.0, 1e-7);
  EXPECT_NEAR(data.frequencies(1) / bending_frequency(beam, beam.second_moment_y, second), 1.0, 1e-6);
}

TEST(Beam, FreeBendingFrequenciesLeaveRigidMotionOut) {
  const auto beam = bar(BeamSupport::free_free, {{BeamFamily::bending_xy, 1, false},
                                                 {BeamFamily::bending_xy, 2, false},
                                                 {BeamFamily::torsion, 1, false},
                                                 {BeamFamily::axial, 1, false}});
  const ModalData data = make_beam(beam);
  const auto equation = [](double x) { return std::cosh(x) * std::cos(x) - 1.0; };
  const double first = root(equation, 4.0, 5.5) / beam.length;
  const double second = root(equation, 7.0, 8.5) / beam.length;
  EXPECT_NEAR(data.frequencies(0) / bending_frequency(beam, beam.second_moment_z, first), 1.0, 1e-6);
  EXPECT_NEAR(data.frequencies(1) / bending_frequency(beam, beam.second_moment_z, second), 1.0, 4e-6);
  // Neither momentum nor angular momentum: the modes stand against all rigid motions.
  for (int mode = 0; mode < data.n_modes(); ++mode) {
    EXPECT_LT((data.G.block<3, 1>(4 + 3 * mode, 0)).norm(), 1e-10);
    const Mat3 moment = data.G.block<3, 3>(1, 4 + 3 * mode);
    const Vec3 angular(moment(1, 2) - moment(2, 1), moment(2, 0) - moment(0, 2), moment(0, 1) - moment(1, 0));
    EXPECT_LT(angular.norm(), 1e-10);
  }
}

TEST(Beam, AxialAndTorsionFrequencies) {
  const auto beam = bar(BeamSupport::cantilever, {{BeamFamily::axial, 1, false},
                                                  {BeamFamily::axial, 3, false},
                                                  {BeamFamily::torsion, 1, false},
                                                  {BeamFamily::torsion, 2, false}});
  const ModalData data = make_beam(beam);
  const double width = beam.length / beam.elements;
  const double axial_speed = std::sqrt(beam.youngs_modulus / beam.density);
  const double torsion_speed = std::sqrt(beam.shear_modulus * beam.torsion_constant /
                                         (beam.density * (beam.second_moment_y + beam.second_moment_z)));
  const auto beta = [&](int n) { return (n - 0.5) * kPi / beam.length; };
  EXPECT_NEAR(data.frequencies(0) / linear_element_frequency(axial_speed, width, beta(1)), 1.0, 1e-11);
  EXPECT_NEAR(data.frequencies(1) / linear_element_frequency(axial_speed, width, beta(3)), 1.0, 1e-11);
  EXPECT_NEAR(data.frequencies(2) / linear_element_frequency(torsion_speed, width, beta(1)), 1.0, 1e-11);
  EXPECT_NEAR(data.frequencies(3) / linear_element_frequency(torsion_speed, width, beta(2)), 1.0, 1e-11);
  EXPECT_NEAR(data.frequencies(0) / (axial_speed * beta(1)), 1.0, 1e-4);
  EXPECT_NEAR(data.frequencies(2) / (torsion_speed * beta(1)), 1.0, 1e-4);
}

TEST(Beam, AllModesOfAFamilyCanBeChosen) {
  std::vector<BeamMode> modes;
  for (int n = 1; n <= 50; ++n) modes.push_back({BeamFamily::axial, n, false});
  const auto beam = bar(BeamSupport::cantilever, modes, 50);
  const ModalData data = make_beam(beam);
  const double speed = std::sqrt(beam.youngs_modulus / beam.density);
  for (int n = 1; n <= 50; ++n) {
    const double exact = linear_element_frequency(speed, beam.length / 50, (n - 0.5) * kPi / beam.length);
    EXPECT_NEAR(data.frequencies(n - 1) / exact, 1.0, 1e-11) << n;
  }
  EXPECT_LT((modal_mass(data) - MatX::Identity(50, 50)).norm(), 1e-11);
}

TEST(Beam, ModesOfAFewAndOfAllAreTheSame) {
  const auto few = make_beam(bar(BeamSupport::cantilever, {{BeamFamily::bending_xy, 3, false}}, 30));
  std::vector<BeamMode> modes;
  for (int n = 1; n <= 60; ++n) modes.push_back({BeamFamily::bending_xy, n, false});
  const auto all = make_beam(bar(BeamSupport::cantilever, modes, 30));
  for (std::size_t k = 0; k < few.nodes.size(); ++k) {
    EXPECT_LT((few.nodes[k].Psi_t_L.col(0) - all.nodes[k].Psi_t_L.col(2)).norm(), 1e-8);
  }
}

/// Finds an eigensolver whose thresholds have units: of a beam of half a millimetre it was wrong by 3 %.
TEST(Beam, FrequenciesScaleWithTheLengthFromMicronsToKilometres) {
  const std::vector<BeamMode> modes{
      {BeamFamily::bending_xy, 1, false}, {BeamFamily::bending_xy, 2, false}, {BeamFamily::torsion, 2, false}};
  for (const BeamSupport support : {BeamSupport::cantilever, BeamSupport::free_free}) {
    const BeamSpecification beam = bar(support, modes, 20);
    const VecX own = make_beam(beam).stiffness.diagonal();
    for (const double size : {1e-6, 4e-4, 1e4}) {
      BeamSpecification scaled = beam;
      scaled.length *= size;
      scaled.area *= std::pow(size, 2);
      for (double* moment : {&scaled.second_moment_y, &scaled.second_moment_z, &scaled.torsion_constant}) {
        *moment *= std::pow(size, 4);
      }
      const VecX found = std::pow(size, 2) * make_beam(scaled).stiffness.diagonal();
      EXPECT_LT((found - own).cwiseQuotient(own).cwiseAbs().maxCoeff(), 1e-11) << size;
    }
  }
}

TEST(Beam, IntegralsHoldTheRigidInertiaOfARod) {
  const auto beam = generic_bar(BeamSupport::simply_supported, kOneOfEach);
  const ModalData data = make_beam(beam);
  const double mass = beam.density * beam.area * beam.length;
  const Vec3 center = beam.first_end_L + beam.axes * Vec3(0.5 * beam.length, 0.0, 0.0);
  const Vec3 second_moments =
      mass * Vec3(beam.length * beam.length / 12.0, beam.second_moment_z / beam.area, beam.second_moment_y / beam.area);
  const Mat3 about_center = beam.axes * second_moments.asDiagonal() * beam.axes.transpose();
  EXPECT_NEAR(data.G(0, 0) / mass, 1.0, 1e-14);
  EXPECT_LT((data.G.block<3, 1>(1, 0) / mass - center).norm(), 1e-14);
  EXPECT_LT((data.G.block<3, 3>(1, 1) - mass * center * center.transpose() - about_center).norm(), 1e-14 * mass);
}

TEST(Beam, ModesAreOrthogonalAndOfUnitModalMass) {
  auto beam = generic_bar(BeamSupport::craig_bampton, kCraigBampton);
  beam.damping_ratio = 0.01;
  const ModalData data = make_beam(beam);
  const int n = data.n_modes();
  EXPECT_LT((modal_mass(data) - MatX::Identity(n, n)).norm(), 1e-12);
  EXPECT_EQ(data.stiffness, MatX(data.frequencies.cwiseAbs2().asDiagonal()));
  EXPECT_EQ(data.damping, MatX((0.02 * data.frequencies).asDiagonal()));
  EXPECT_GT(data.frequencies.minCoeff(), 0.0);
}

TEST(Beam, TwistHasPolarInertiaAndBendingHasNoRotaryOne) {
  // A rigid twist of all sections at unit modal mass: phi^2 * rho (I_y + I_z) L = 1 for the static torsion mode, linear
  // along the beam, has a third of it.
  const auto beam = bar(BeamSupport::craig_bampton, {{BeamFamily::torsion, 1, true}}, 7);
  const ModalData data = make_beam(beam);
  const double polar = beam.density * (beam.second_moment_y + beam.second_moment_z) * beam.length;
  EXPECT_NEAR(node(data, "last").Psi_r_L(0, 0), 1.0 / std::sqrt(polar / 3.0), 1e-9 / std::sqrt(polar));

  const auto bent = bar(BeamSupport::craig_bampton, {{BeamFamily::bending_xz, 1, true}}, 7);
  const double mass = bent.density * bent.area * bent.length;
  // integral of (3 xi^2 - 2 xi^3)^2 = 13/35
  EXPECT_NEAR(node(make_beam(bent), "last").Psi_t_L(2, 0), 1.0 / std::sqrt(13.0 / 35.0 * mass), 1e-12);
}

TEST(Beam, StaticModesHaveTheStiffnessOfABeam) {
  const auto stiffness = [](BeamMode mode, int row_of_last_t, int row_of_last_r) {
    const auto beam = bar(BeamSupport::craig_bampton, {mode}, 9);
    const ModalData data = make_beam(beam);
    const ModalNode& last = node(data, "last");
    const double displacement = row_of_last_t >= 0 ? last.Psi_t_L(row_of_last_t, 0) : last.Psi_r_L(row_of_last_r, 0);
    return data.stiffness(0, 0) / (displacement * displacement);
  };
  const auto beam = bar(BeamSupport::craig_bampton, {});
  const double EI_z = beam.youngs_modulus * beam.second_moment_z;
  const double EI_y = beam.youngs_modulus * beam.second_moment_y;
  const double L = beam.length;
  const auto near = [](double found, double expected) { EXPECT_NEAR(found / expected, 1.0, 1e-11); };
  near(stiffness({BeamFamily::bending_xy, 1, true}, 1, -1), 12.0 * EI_z / (L * L * L));
  near(stiffness({BeamFamily::bending_xy, 2, true}, -1, 2), 4.0 * EI_z / L);
  near(stiffness({BeamFamily::bending_xz, 1, true}, 2, -1), 12.0 * EI_y / (L * L * L));
  near(stiffness({BeamFamily::bending_xz, 2, true}, -1, 1), 4.0 * EI_y / L);
  near(stiffness({BeamFamily::torsion, 1, true}, -1, 0), beam.shear_modulus * beam.torsion_constant / L);
  near(stiffness({BeamFamily::axial, 1, true}, 0, -1), beam.youngs_modulus * beam.area / L);
}

TEST(Beam, CraigBamptonSpansEveryDisplacementOfTheFreeEnd) {
  const auto beam = generic_bar(BeamSupport::craig_bampton, kCraigBampton);
  const ModalData data = make_beam(beam);
  const ModalNode& last = node(data, "last");
  const ModalNode& first = node(data, "first");
  MatX end(6, data.n_modes());
  end << last.Psi_t_L, last.Psi_r_L;
  EXPECT_EQ(first.Psi_t_L.norm() + first.Psi_r_L.norm(), 0.0);
  // Of all modal coordinates with that displacement of the end, static equilibrium takes the least strain energy.
  const MatX flexibility = solve_square(data.stiffness, MatX::Identity(data.stiffness.rows(), data.stiffness.rows()));
  const MatX a = flexibility * end.transpose() * solve_square(end * flexibility * end.transpose(), Mat6::Identity());
  EXPECT_LT((end * a - MatX::Identity(6, 6)).norm(), 1e-9);
  const MatX stiffness = a.transpose() * data.stiffness * a;
  const Mat3 force_per_displacement = beam.axes.transpose() * stiffness.topLeftCorner<3, 3>() * beam.axes;
  const double EI_z = beam.youngs_modulus * beam.second_moment_z;
  const double EI_y = beam.youngs_modulus * beam.second_moment_y;
  const double L3 = std::pow(beam.length, 3);
  const Vec3 expected(beam.youngs_modulus * beam.area / beam.length, 12.0 * EI_z / L3, 12.0 * EI_y / L3);
  EXPECT_LT((force_per_displacement - Mat3(expected.asDiagonal())).norm(), 1e-9 * expected.norm());
}

TEST(Beam, RotationRowsAreTheSlopesOfTheTranslationRows) {
  const auto beam = generic_bar(BeamSupport::cantilever, kOneOfEach, 200);
  const ModalData data = make_beam(beam);
  const double width = beam.length / beam.elements;
  const double largest = node(data, "last").Psi_r_L.norm();
  for (int k = 5; k + 5 < beam.elements; k += 17) {
    const Mat3X slope = (data.nodes[k + 1].Psi_t_L - data.nodes[k - 1].Psi_t_L) / (2.0 * width);
    // A rotation of the section moves the axis e_x by psi x e_x; across the axis that is the slope of the line.
    const Vec3 x = beam.axes.col(0);
    const Mat3X turned = data.nodes[k].Psi_r_L.colwise().cross(x);
    const Mat3X across = slope - x * (x.transpose() * slope);
    EXPECT_LT((turned - across).norm(), 1e-4 * largest) << k;
    // Twist is the torsion mode's alone.
    EXPECT_GT(std::abs(x.dot(data.nodes[k].Psi_r_L.col(1))), 1.0);
    EXPECT_LT(std::abs(x.dot(data.nodes[k].Psi_r_L.col(0))), 1e-12);
  }
}

TEST(Beam, GenericPlaceIsTheRotatedResult) {
  const auto plain_beam = bar(BeamSupport::cantilever, kOneOfEach, 24);
  const auto placed_beam = generic_bar(BeamSupport::cantilever, kOneOfEach, 24);
  const ModalData plain = make_beam(plain_beam);
  const ModalData placed = make_beam(placed_beam);
  const Mat3& axes = placed_beam.axes;
  EXPECT_EQ(plain.frequencies, placed.frequencies);
  for (std::size_t k = 0; k < plain.nodes.size(); ++k) {
    EXPECT_EQ(plain.nodes[k].name, placed.nodes[k].name);
    EXPECT_LT((placed_beam.first_end_L + axes * plain.nodes[k].s0_L - placed.nodes[k].s0_L).norm(), 1e-14);
    EXPECT_LT((axes * plain.nodes[k].Psi_t_L - placed.nodes[k].Psi_t_L).norm(), 1e-13);
    EXPECT_LT((axes * plain.nodes[k].Psi_r_L - placed.nodes[k].Psi_r_L).norm(), 1e-12);
  }
  for (std::size_t k = 0; k < plain.mass_points.size(); ++k) {
    const MassPoint& there = placed.mass_points[k];
    EXPECT_LT((placed_beam.first_end_L + axes * plain.mass_points[k].s0_L - there.s0_L).norm(), 1e-14);
    EXPECT_LT((axes * plain.mass_points[k].Psi_t_L - there.Psi_t_L).norm(), 1e-13);
  }
}

TEST(Beam, MassPointsTwistWithTheirSection) {
  const auto beam = bar(BeamSupport::cantilever, {{BeamFamily::torsion, 1, false}}, 4);
  for (const MassPoint& point : make_beam(beam).mass_points) {
    const Vec3 radius(0.0, point.s0_L.y(), point.s0_L.z());
    EXPECT_NEAR(std::abs(radius.y()), std::sqrt(beam.second_moment_z / beam.area), 1e-15);
    EXPECT_NEAR(std::abs(radius.z()), std::sqrt(beam.second_moment_y / beam.area), 1e-15);
    const Vec3 moved = point.Psi_t_L.col(0);
    EXPECT_LT(std::abs(moved.dot(radius)), 1e-14);
    EXPECT_GT(Vec3::UnitX().cross(radius).dot(moved), 0.0);
  }
}

TEST(Beam, LargestDisplacementOfAModeIsPositive) {
  const ModalData data = make_beam(bar(BeamSupport::simply_supported, {{BeamFamily::bending_xy, 2, false}}));
  // Two equal half waves: the first one counts.
  EXPECT_GT(node(data, "10").Psi_t_L(1, 0), 0.0);
  EXPECT_LT(node(data, "30").Psi_t_L(1, 0), 0.0);
}

TEST(Beam, NodesHaveNumbersAndTheEndsHaveNames) {
  const ModalData data = make_beam(bar(BeamSupport::cantilever, kOneOfEach, 6));
  ASSERT_EQ(data.nodes.size(), 9U);
  EXPECT_EQ(data.nodes[6].name, "6");
  EXPECT_EQ(node(data, "first").s0_L, data.nodes[0].s0_L);
  EXPECT_EQ(node(data, "last").Psi_r_L, data.nodes[6].Psi_r_L);
  EXPECT_EQ(data.mass_points.size(), 6U * 4U * 4U);
}

std::string beam_complaint(const BeamSpecification& beam) {
  try {
    make_beam(beam);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(Beam, SaysWhichModeDoesNotExist) {
  EXPECT_EQ(beam_complaint(bar(BeamSupport::cantilever, {{BeamFamily::axial, 6, false}}, 5)),
            "beam: axial mode 6 does not exist: with these supports and 5 elements there are 5");
  EXPECT_EQ(beam_complaint(bar(BeamSupport::free_free, {{BeamFamily::bending_xy, 0, false}}, 5)),
            "beam: bending_xy mode 0 does not exist: with these supports and 5 elements there are 10");
  EXPECT_EQ(beam_complaint(bar(BeamSupport::cantilever, {{BeamFamily::torsion, 1, true}}, 5)),
            "beam: static torsion mode 1 does not exist: with these supports and 5 elements there are 0");
  EXPECT_EQ(beam_complaint(bar(BeamSupport::cantilever, {{BeamFamily::axial, 1}, {BeamFamily::axial, 1}}, 5)),
            "beam: axial mode 1 is chosen twice");
}

TEST(Beam, SaysWhatIsMissingForAFamily) {
  auto beam = bar(BeamSupport::cantilever, {{BeamFamily::torsion, 1, false}});
  beam.torsion_constant = 0.0;
  EXPECT_THAT(beam_complaint(beam), ::testing::StartsWith("beam: family torsion has stiffness 0"));
}

}  // namespace
}  // namespace concord
