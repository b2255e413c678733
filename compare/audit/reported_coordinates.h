#pragma once

#include <string>

#include "common/model.h"
#include "common/results.h"

/// Are the joint coordinates and speeds, and the angles of turn springs, that a run reports those of its bodies?
/// Results and files hold both, and who plots a joint coordinate looks at no body.
namespace concord::compare {

/// The reported number that is farthest from what the bodies say.
struct ReportedCoordinate {
  double digits = 16.0;  // -log10(misfit / scale), between 0 and 16
  std::string what;      // "joint 'hinge', speed of turn_z"; empty: there is no coordinate
  double t = 0.0;        // s
  double reported = 0.0;
  double by_bodies = 0.0;

  [[nodiscard]] bool holds() const;
  /// "reports joint coordinates that its bodies do not have: joint 'hinge', turn_z, t = 0.1 s: 0.2 in place of 0.1".
  [[nodiscard]] std::string text() const;
};

/// Reads every joint and turn spring of every sample from the two bodies. Whole turns are taken as they are reported.
/// Scales are 1 rad or the angle, and the largest distance of a body or the machine's length; for speeds the largest in
/// the run. What the last digits of the state leave open, as near a pose where a coordinate has no meaning, is no
/// misfit.
ReportedCoordinate audit_reported_coordinates(const Model& model, const Trajectory& run);

}  // namespace concord::compare
