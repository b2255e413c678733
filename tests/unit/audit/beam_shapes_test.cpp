#include "compare/audit/beam_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "common/flexible/beam.h"

namespace concord::compare {
namespace {

/// A beam along no axis of its body with two modes of each family, of unequal second moments.
BeamSpecification beam_of_two_modes(BeamSupport support) {
  BeamSpecification beam;
  beam.first_end_L = {0.1, -0.2, 0.05};
  beam.axes = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  beam.length = 0.8;
  beam.elements = 9;
  beam.area = 3e-4;
  beam.second_moment_y = 4e-9;
  beam.second_moment_z = 11e-9;
  beam.torsion_constant = 7e-9;
  beam.youngs_modulus = 7e10;
  beam.shear_modulus = 2.6e10;
  beam.density = 2700.0;
  beam.support = support;
  for (const BeamFamily family :
       {BeamFamily::bending_xy, BeamFamily::bending_xz, BeamFamily::torsion, BeamFamily::axial}) {
    for (const int number : {1, 3}) beam.modes.push_back({family, number, false});
  }
  if (support == BeamSupport::craig_bampton) {
    for (const BeamFamily family : {BeamFamily::bending_xy, BeamFamily::bending_xz}) {
      for (const int number : {1, 2}) beam.modes.push_back({family, number, true});
    }
    for (const BeamFamily family : {BeamFamily::torsion, BeamFamily::axial}) beam.modes.push_back({family, 1, true});
  }
  return beam;
}

/// The modes of one beam, said to be those of another.
ShapeMisfit misfit_of(const BeamSpecification& made, const BeamSpecification& stated) {
  ModalData modal = make_beam(made);
  modal.beam = std::make_shared<const BeamSpecification>(stated);
  return compute_misfit_of_shapes(modal);
}

constexpr std::array kFourSupports{BeamSupport::simply_supported, BeamSupport::cantilever, BeamSupport::free_free,
                                   BeamSupport::craig_bampton};

}  // namespace

TEST(BeamShapes, AreThoseOfTheStatedBeam) {
  for (const BeamSupport support : kFourSupports) {
    const BeamSpecification beam = beam_of_two_modes(support);
    const ShapeMisfit found = misfit_of(beam, beam);
    EXPECT_LT(found.shape, 1e-10);
    EXPECT_LT(found.mass, 1e-11);
  }
}

/// Finds a rule that asks more of the highest shapes than an eigensolver knows of them: of a free beam the last two
/// have nearly one frequency.
TEST(BeamShapes, OfTheHighestNumbersAreAsGoodAsTheyCanBe) {
  for (const BeamSupport support : kFourSupports) {
    for (const int elements : {1, 2, 3, 15, 20, 50, 100}) {
      for (int number = std::max(1, 2 * elements - 3); number <= std::min(200, 2 * elements + 1); ++number) {
        BeamSpecification beam = beam_of_two_modes(support);
        beam.elements = elements;
        beam.modes = {{BeamFamily::bending_xz, number, false}};
        try {
          const ShapeMisfit found = misfit_of(beam, beam);
          EXPECT_LT(found.shape, 1e-8) << static_cast<int>(support) << " " << elements << " " << number;
          EXPECT_LT(found.mass, 1e-10) << static_cast<int>(support) << " " << elements << " " << number;
        } catch (const std::invalid_argument&) {  // there is no such mode
        }
      }
    }
  }
}

TEST(BeamShapes, OfOtherSupportsAreSeen) {
  for (const BeamSupport made : kFourSupports) {
    for (const BeamSupport stated : kFourSupports) {
      if (made == stated) continue;
      BeamSpecification other = beam_of_two_modes(made);
      if (made == BeamSupport::craig_bampton) other.modes.resize(8);
      BeamSpecification beam = other;
      beam.support = stated;
      EXPECT_GT(misfit_of(other, beam).shape, 1e-2) << static_cast<int>(made) << static_cast<int>(stated);
    }
  }
}

TEST(BeamShapes, OfOtherNumbersAreSeen) {
  for (std::size_t k = 0; k < 8; ++k) {
    const BeamSpecification beam = beam_of_two_modes(BeamSupport::cantilever);
    BeamSpecification other = beam;
    ++other.modes[k].number;
    EXPECT_GT(misfit_of(other, beam).shape, 0.5) << k;
  }
}

TEST(BeamShapes, OfAnotherMassAreSeen) {
  const BeamSpecification beam = beam_of_two_modes(BeamSupport::craig_bampton);
  BeamSpecification other = beam;
  other.density *= 1.001;
  EXPECT_GT(misfit_of(other, beam).mass, 5e-4);
  other = beam;
  other.second_moment_y *= 1.001;  // of which torsion has its polar inertia
  EXPECT_GT(misfit_of(other, beam).mass, 1e-4);
}

}  // namespace concord::compare
