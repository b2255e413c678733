#include "common/reading/modes_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/flexible/beam.h"
#include "common/reading/model_file.h"
#include "common/rotation.h"

namespace concord {
namespace {

/// A tilted beam off the body's origin, with modes of all families.
ModalData generic_beam() {
  BeamSpecification beam;
  beam.first_end_L = {0.1, -0.2, 0.05};
  beam.axes = rotation_about(Vec3(1.0, 2.0, -0.5).normalized(), 0.8);
  beam.length = 0.4;
  beam.elements = 5;
  beam.area = 3e-5;
  beam.second_moment_y = 7e-11;
  beam.second_moment_z = 9e-11;
  beam.torsion_constant = 1.4e-10;
  beam.youngs_modulus = 2e11;
  beam.shear_modulus = 8e10;
  beam.density = 7800.0;
  beam.support = BeamSupport::craig_bampton;
  beam.modes = {{BeamFamily::bending_xy, 1, true},
                {BeamFamily::bending_xz, 2, true},
                {BeamFamily::bending_xz, 1, false},
                {BeamFamily::torsion, 1, true},
                {BeamFamily::axial, 1, true}};
  beam.damping_ratio = 0.02;
  return make_beam(beam);
}

/// Two modes, three mass points, one node.
const std::string kSound = R"(format = 1
modes = 2
stiffness = [[3, 1], [1, 2]]

[[mass_point]]
mass = 2
point = [0, 0, 0]
Psi_t = [[1, 0.2], [0, 1], [0.5, 0]]

[[mass_point]]
mass = 1
point = [1, 0, 0]
Psi_t = [[0, 0.3], [1, 0], [0, 1]]

[[node]]
name = "tip"
point = [1, 2, 3]
Psi_t = [[1, 2], [3, 4], [5, 6]]
Psi_r = [[7, 8], [9, 10], [11, 12]]

[[mass_point]]
mass = 3
point = [0.2, 0.7, -0.4]
Psi_t = [[0, 0], [0, 0], [0, 0]]
)";

std::string with(const std::string& find, const std::string& replace) {
  std::string text = kSound;
  const auto place = text.find(find);
  EXPECT_NE(place, std::string::npos) << find;
  return text.replace(place, find.size(), replace);
}

/// The message about a text, without the file's name.
std::string modes_complaint(const std::string& text) {
  try {
    (void)parse_modes(text, "m.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(ModesFile, ReadsBackWhatWasWritten) {
  const ModalData beam = generic_beam();
  const ModalData back = parse_modes(format_modes(beam, InertiaForm::mass_points), "m.toml");
  EXPECT_EQ(back.stiffness, beam.stiffness);
  EXPECT_EQ(back.damping, beam.damping);
  EXPECT_EQ(back.G, beam.G);
  ASSERT_EQ(back.nodes.size(), beam.nodes.size());
  for (std::size_t k = 0; k < beam.nodes.size(); ++k) {
    EXPECT_EQ(back.nodes[k].name, beam.nodes[k].name);
    EXPECT_EQ(back.nodes[k].s0_L, beam.nodes[k].s0_L);
    EXPECT_EQ(back.nodes[k].Psi_t_L, beam.nodes[k].Psi_t_L);
    EXPECT_EQ(back.nodes[k].Psi_r_L, beam.nodes[k].Psi_r_L);
  }
  ASSERT_EQ(back.mass_points.size(), beam.mass_points.size());
  EXPECT_EQ(back.mass_points.back().Psi_t_L, beam.mass_points.back().Psi_t_L);
}

TEST(ModesFile, FindsTheFrequenciesOfTheModes) {
  const ModalData beam = generic_beam();
  const ModalData back = parse_modes(format_modes(beam, InertiaForm::mass_points), "m.toml");
  VecX expected = beam.frequencies;
  std::sort(expected.begin(), expected.end());
  EXPECT_LT((back.frequencies - expected).cwiseQuotient(expected).cwiseAbs().maxCoeff(), 1e-12);
}

/// A program may scale its modes to their largest displacement, or leave them as they come.
TEST(ModesFile, TakesModesOfAnyLength) {
  const ModalData beam = generic_beam();
  ModalData scaled = beam;
  const int m = beam.n_modes();
  const VecX lengths = VecX::NullaryExpr(m, [](Eigen::Index k) { return k % 2 == 0 ? 2e6 : 3e-4; });
  scaled.stiffness = lengths.asDiagonal() * beam.stiffness * lengths.asDiagonal();
  scaled.damping = lengths.asDiagonal() * beam.damping * lengths.asDiagonal();
  for (MassPoint& point : scaled.mass_points) point.Psi_t_L = (point.Psi_t_L * lengths.asDiagonal()).eval();
  for (ModalNode& node : scaled.nodes) {
    node.Psi_t_L = (node.Psi_t_L * lengths.asDiagonal()).eval();
    node.Psi_r_L = (node.Psi_r_L * lengths.asDiagonal()).eval();
  }
  const ModalData read = parse_modes(format_modes(scaled, InertiaForm::mass_points), "m.toml");
  const ModalData plain = parse_modes(format_modes(beam, InertiaForm::mass_points), "m.toml");
  ASSERT_EQ(read.frequencies.size(), plain.frequencies.size());
  EXPECT_LT((read.frequencies - plain.frequencies).cwiseQuotient(plain.frequencies).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ModesFile, TakesIntegralsInsteadOfMassPoints) {
  const ModalData beam = generic_beam();
  const ModalData back = parse_modes(format_modes(beam, InertiaForm::integrals), "m.toml");
  EXPECT_EQ(back.G, beam.G);
  EXPECT_LE(back.mass_points.size(), static_cast<std::size_t>(beam.G.rows()));
  const VecX scale = beam.G.diagonal().cwiseSqrt();
  const MatX difference = mass_integrals(back.mass_points, beam.n_modes()) - beam.G;
  EXPECT_LT(difference.cwiseQuotient((scale * scale.transpose()).cwiseMax(1e-300)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ModesFile, ShippedFilesAreTheCouplerOfTheSliderCrank) {
  const Model machine = read_model(CONCORD_DATA "/models/slider_crank_flexible.toml");
  const ModalData& beam = *machine.bodies[2].modal;
  const ModalData integrals = read_modes_file(CONCORD_DATA "/modes/coupler_integrals.toml");
  EXPECT_LT((integrals.G - beam.G).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((integrals.stiffness - beam.stiffness).norm(), 1e-9 * beam.stiffness.norm());
  const ModalData points = read_modes_file(CONCORD_DATA "/modes/coupler_points.toml");
  EXPECT_NEAR(points.G(0, 0), beam.G(0, 0), 1e-15);
  EXPECT_NEAR(points.frequencies(0), beam.frequencies(0), 1e-3 * beam.frequencies(0));
}

TEST(ModesFile, RotaryInertiaBecomesSixMassPoints) {
  const ModalData data =
      parse_modes(with("Psi_t = [[1, 0.2], [0, 1], [0.5, 0]]", R"(Psi_t = [[1, 0.2], [0, 1], [0.5, 0]]
inertia = [0.5, 0.6, 0.7, 0.1, -0.05, 0.08]
Psi_r = [[0.3, -0.4], [0.1, 0.7], [-0.2, 0.5]])"),
                  "m.toml");
  ASSERT_EQ(data.mass_points.size(), 8U);
  Mat3 inertia;
  inertia << 0.5, 0.1, -0.05, 0.1, 0.6, 0.08, -0.05, 0.08, 0.7;
  MatX Psi_r(3, 2);
  Psi_r << 0.3, -0.4, 0.1, 0.7, -0.2, 0.5;
  MatX Psi_t(3, 2);
  Psi_t << 1.0, 0.2, 0.0, 1.0, 0.5, 0.0;
  Mat3 found = Mat3::Zero();
  Vec3 moment = Vec3::Zero();
  MatX modal_mass = MatX::Zero(2, 2);
  MatX spin = MatX::Zero(3, 2);  // angular momentum about the node per modal speed
  double mass = 0.0;
  for (std::size_t k = 0; k < 6; ++k) {
    const MassPoint& point = data.mass_points[k];
    mass += point.mass;
    moment += point.mass * point.s0_L;
    found -= point.mass * skew(point.s0_L) * skew(point.s0_L);
    modal_mass += point.mass * point.Psi_t_L.transpose() * point.Psi_t_L;
    spin += point.mass * skew(point.s0_L) * point.Psi_t_L;
  }
  EXPECT_NEAR(mass, 2.0, 1e-15);
  EXPECT_LT(moment.norm(), 1e-15);
  EXPECT_LT((found - inertia).norm(), 1e-14);
  const MatX expected = 2.0 * Psi_t.transpose() * Psi_t + Psi_r.transpose() * inertia * Psi_r;
  EXPECT_LT((modal_mass - expected).norm(), 1e-14);
  EXPECT_LT((spin - inertia * Psi_r).norm(), 1e-14);
}

TEST(ModesFile, DampingRatiosBelongToTheUndampedModes) {
  const ModalData data = parse_modes(with("modes = 2", "modes = 2\ndamping_ratios = [0.03, 0.05]"), "m.toml");
  MatX mass(2, 2);
  mass << 3.5, 0.4, 0.4, 3.17;  // sum of m psi_a . psi_b by hand
  const SymmetricEigenpairs modes = symmetric_eigenpairs(data.stiffness, mass).value();
  for (int k = 0; k < 2; ++k) {
    const VecX shape = modes.vectors.col(k);
    const double omega = std::sqrt(modes.values(k));
    const double ratio = k == 0 ? 0.03 : 0.05;
    const double damping = shape.dot(data.damping * shape) / shape.dot(mass * shape);
    EXPECT_NEAR(damping, 2.0 * ratio * omega, 1e-14);
  }
  EXPECT_LT((data.damping - data.damping.transpose()).norm(), 1e-15);
}

TEST(ModesFile, TakesADiagonalAsAList) {
  const ModalData data = parse_modes(with("[[3, 1], [1, 2]]", "[3, 2]"), "m.toml");
  EXPECT_EQ(data.stiffness, MatX(Eigen::Vector2d(3.0, 2.0).asDiagonal()));
  EXPECT_EQ(data.damping, MatX(MatX::Zero(2, 2)));
}

struct BrokenModes {
  std::string find;
  std::string replace;
  std::string expected;
};

class BrokenModesFile : public testing::TestWithParam<BrokenModes> {};

TEST_P(BrokenModesFile, IsRefusedWordByWord) {
  EXPECT_EQ(modes_complaint(with(GetParam().find, GetParam().replace)), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(
    All, BrokenModesFile,
    testing::Values(
        BrokenModes{"format = 1", "format = 3", "m.toml:1:10: error: 'format' must be 1, found 3"},
        BrokenModes{"modes = 2\n", "", "m.toml:1:1: error: missing key 'modes'"},
        BrokenModes{"modes = 2", "modes = 0",
                    "m.toml:2:9: error: 'modes' must be a whole number of at least 1, found 0"},
        BrokenModes{"modes = 2", "modes = 900000",
                    "m.toml:2:9: error: 'modes' must be a whole number of at least 1 and at most 1000, found 900000"},
        BrokenModes{
            "[[3, 1], [1, 2]]", "[[3, 1], [0.5, 2]]",
            "m.toml:3:13: error: 'stiffness' must be symmetric, but entries (1, 2) and (2, 1) differ: 1 and 0.5"},
        BrokenModes{"[[3, 1], [1, 2]]", "[[1, 3], [3, 1]]",
                    "m.toml:3:13: error: 'stiffness' must be positive semidefinite, but its smallest eigenvalue is -2, "
                    "its largest 4"},
        BrokenModes{"[[3, 1], [1, 2]]", "[[3, 1]]",
                    "m.toml:3:13: error: 'stiffness' must be a list of 2 rows of 2 numbers, found 1"},
        BrokenModes{"[[3, 1], [1, 2]]", "[1, 2, 3]",
                    "m.toml:3:13: error: 'stiffness' must be a list of 2 numbers, found 3"},
        BrokenModes{"[[1, 0.2], [0, 1], [0.5, 0]]", "[[1, 0.2], [0, 1, 2], [0.5, 0]]",
                    "m.toml:8:20: error: mass point 1: row 2 of 'Psi_t' must be a list of 2 numbers, found 3"},
        BrokenModes{"[[1, 2], [3, 4], [5, 6]]", "[[1, 2], [3, 4]]",
                    "m.toml:18:9: error: node: 'Psi_t' must be a list of 3 rows of 2 numbers, found 2"},
        BrokenModes{"mass = 2", "mass = -2", "m.toml:6:8: error: mass point 1: 'mass' must be positive, found -2"},
        BrokenModes{"point = [0, 0, 0]", "point = [0, 0, 0]\ninertia = [1, 1, 1, 0, 0, 0]",
                    "m.toml:5:1: error: mass point 1: missing key 'Psi_r'"},
        BrokenModes{"modes = 2", "modes = 2\ndamping_ratios = [0.01, -0.01]",
                    "m.toml:3:18: error: a damping ratio must not be negative, found -0.01"},
        BrokenModes{"modes = 2", "modes = 2\ndamping_ratios = [0, 0]\ndamping = [0, 0]",
                    "m.toml:3:18: error: 'damping' and 'damping_ratios' exclude each other: give one of them"},
        BrokenModes{"modes = 2", "modes = 2\ninertia_integrals = [[1]]",
                    "m.toml:3:21: error: 'mass_point' and 'inertia_integrals' exclude each other: give one of them"},
        BrokenModes{"Psi_t = [[0, 0.3], [1, 0], [0, 1]]",
                    "Psi_t = [[0, 0], [1, 0], [0, 0]]\n[[node]]\nname = \"tip\"\n"
                    "point = [0, 0, 0]\nPsi_t = [[0, 0], [0, 0], [0, 0]]\nPsi_r = [[0, 0], [0, 0], [0, 0]]",
                    "m.toml:21:8: error: node: two nodes have the name 'tip'"},
        BrokenModes{"Psi_t = [[1, 0.2], [0, 1], [0.5, 0]]\n\n[[mass_point]]\nmass = 1\npoint = [1, 0, 0]\nPsi_t = [[0, "
                    "0.3], [1, 0], [0, 1]]",
                    "Psi_t = [[1, 1], [0, 0], [0, 0]]",
                    "m.toml:1:1: error: the modes are not independent: their modal mass is singular"}));

/// Mass points with a shape of their own and with the turn about an oblique axis, to the digits that are printed.
TEST(ModesFile, RefusesRigidModes) {
  const Vec3 axis = Vec3(2.0, -3.0, 6.0) / 7.0;
  ModalData data = parse_modes(kSound, "m.toml");
  data.mass_points.push_back({0.7, Vec3(-0.3, 0.4, 0.9), Mat3X::Zero(3, 2)});
  for (MassPoint& point : data.mass_points) {
    point.Psi_t_L.col(0) = Vec3(1.0, 0.5, -0.2) * point.s0_L.x() * point.s0_L.y();
    point.Psi_t_L.col(1) = (1e7 * axis.cross(point.s0_L + Vec3(0.1, 0.7, 0.2))).array().round() * 1e-7;
  }
  EXPECT_EQ(modes_complaint(format_modes(data, InertiaForm::mass_points)),
            "m.toml:1:1: error: the modes move the body as a whole, which its frame does already: leave rigid-body "
            "modes out");
  data.mass_points[0].Psi_t_L.col(1) += Vec3(0.0, 1e-4, 0.0);
  EXPECT_EQ(modes_complaint(format_modes(data, InertiaForm::mass_points)), "none");
}

/// The integrals of the sound file's mass points, one entry changed or the size cut.
std::string integrals_text(const MatX& G) {
  ModalData data = parse_modes(kSound, "m.toml");
  data.G = G;
  return format_modes(data, InertiaForm::integrals);
}

TEST(ModesFile, RefusesIntegralsThatAreIncompleteOrOfNoMass) {
  const MatX G = parse_modes(kSound, "m.toml").G;
  EXPECT_EQ(modes_complaint(integrals_text(G)), "none");
  EXPECT_EQ(modes_complaint(integrals_text(G.topLeftCorner(7, 7))),
            "m.toml:5:21: error: 'inertia_integrals' must be all of G, 10 x 10 for 2 modes, found 7 rows: from an "
            "incomplete set the inertia does not follow");
  MatX impossible = G;
  impossible(1, 1) = 0.1;
  EXPECT_EQ(modes_complaint(integrals_text(impossible)).substr(0, 72),
            "m.toml:5:21: error: 'inertia_integrals' must be positive semidefinite, b");
  MatX hidden = G;  // a large entry elsewhere does not hide what is wrong with a small one
  hidden(9, 9) *= 1e14;
  hidden(1, 1) = 0.1;
  EXPECT_EQ(modes_complaint(integrals_text(hidden)).substr(0, 72),
            "m.toml:5:21: error: 'inertia_integrals' must be positive semidefinite, b");
  MatX massless = G;
  massless.row(0).setZero();
  massless.col(0).setZero();
  EXPECT_EQ(modes_complaint(integrals_text(massless)),
            "m.toml:5:21: error: the mass, entry (1, 1), must be positive, found 0");
}

}  // namespace
}  // namespace concord
