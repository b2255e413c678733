#pragma once

#include <string>
#include <vector>

#include "common/flexible/modal_data.h"
#include "common/types.h"

/// A straight uniform beam in modal coordinates, from its own 3-D Euler-Bernoulli finite elements.
namespace concord {

enum class BeamSupport {
  simply_supported,  // both ends: no displacement, no twist; axially fixed at the first end only
  cantilever,        // first end clamped
  free_free,         // elastic modes only, the six rigid ones left out
  craig_bampton      // first end clamped: fixed-interface normal modes, and the other end's six constraint modes
};

/// Which of the decoupled families a mode belongs to: bending in the beam's x-y plane or x-z plane, torsion, axial.
enum class BeamFamily { bending_xy, bending_xz, torsion, axial };

/// One chosen mode: of a family, `number` from 1 in order of frequency; or, with `is_static`, of the free end's unit
/// displacements of that family (bending: 1 = translation, 2 = rotation; torsion and axial: 1).
struct BeamMode {
  BeamFamily family = BeamFamily::bending_xy;
  int number = 1;
  bool is_static = false;
};

struct BeamSpecification {
  Vec3 first_end_L = Vec3::Zero();  // in the body frame, m
  Mat3 axes = Mat3::Identity();     // columns: the beam's x (along it), y, z in body axes
  double length = 1.0;              // m
  int elements = 20;
  double area = 0.0;              // m^2
  double second_moment_y = 0.0;   // integral of z^2 over the section, m^4: bending in x-z
  double second_moment_z = 0.0;   // integral of y^2 over the section, m^4: bending in x-y
  double torsion_constant = 0.0;  // m^4
  double youngs_modulus = 0.0;    // Pa
  double shear_modulus = 0.0;     // Pa
  double density = 0.0;           // kg/m^3
  BeamSupport support = BeamSupport::simply_supported;
  std::vector<BeamMode> modes;
  double damping_ratio = 0.0;  // of every mode after orthogonalization
};

/// Modal data of the beam: mass points from exact element quadrature at plus and minus the radii of gyration, moving
/// with their section's translation and twist (polar inertia, no rotary inertia in bending); modes orthogonalized
/// against the beam's mass and stiffness and scaled to unit modal mass; one node for each finite element node, named
/// "0" (first end) to "elements", also "first" and "last". Throws std::invalid_argument if a chosen mode does not
/// exist.
ModalData make_beam(const BeamSpecification& beam);

}  // namespace concord
