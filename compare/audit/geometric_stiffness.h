#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/types.h"

namespace concord {
struct ModalData;
struct Model;
struct Trajectory;
}  // namespace concord

/// What the models of flexible bodies leave out: axial forces stiffen a beam against bending, or soften it.
namespace concord::compare {

/// The ratio of geometric to elastic stiffness of the lowest bending mode of a beam in one plane, over a run: integral
/// of N w'^2 over integral of E I w''^2, w the deflection of the mode, N(x) the axial force in the beam (tension counts
/// positive). -1: the beam is about to buckle in this mode. No model has this stiffness; where the ratio is not small,
/// the deflections of both solvers are wrong by about so much, alike.
struct GeometricStiffness {
  std::string body;
  /// "bending_xy" or "bending_xz", in the axes of the beam; empty where the ratio is not known.
  std::string plane;
  int mode = 0;  // column of the modes, from 1
  /// Not known for a body from a modes file, which does not say where its stiffness is.
  bool is_known = true;
  double lowest = 0.0;
  double highest = 0.0;
  double t_lowest = 0.0;  // s
  double t_highest = 0.0;

  /// Above 5 %: the reader must know.
  [[nodiscard]] bool is_notable() const;
};

/// The ratios of each beam in each plane in which a mode of it bends, in the order of the model, with their extremes
/// over the samples; one entry that is not known for each other flexible body. N follows from mass points, motions,
/// gravity and the wrenches on the body alone, as in the free-body audit.
std::vector<GeometricStiffness> geometric_stiffness(const Model& model, const Trajectory& trajectory);

/// The modes along which a body made from a `beam` table stretches and does nothing else, columns from 0; none of any
/// other body.
std::vector<int> axial_modes(const ModalData& modal);

/// What of it the reader must know, a sentence each: ratios above 5 %, and bodies of which none is known.
std::vector<std::string> notes_on(const std::vector<GeometricStiffness>& ratios);

/// One bending mode of a beam: a shape along a line, with what of the body's mass and stiffness belongs to it.
class BendingMode {
 public:
  /// `column` of the modes of a body made from a `beam` table, bending towards `direction_L` (unit, body axes).
  BendingMode(const ModalData& modal, int column, const Vec3& axis_L, const Vec3& direction_L);

  /// Integral of w'^2 from the first end to x [1/m, times the square of the modal coordinate's unit].
  [[nodiscard]] double squared_slope_until(double x) const;
  /// Integral of E I w''^2: the mode's own stiffness.
  [[nodiscard]] double stiffness() const { return stiffness_; }

 private:
  double width_;               // of an element, m
  std::vector<Vec3> rates_;    // w' in each element: r0 + r1 xi + r2 xi^2
  std::vector<double> until_;  // integral of w'^2 from the first end to each element
  double stiffness_;
};

}  // namespace concord::compare
