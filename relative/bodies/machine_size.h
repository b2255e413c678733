#pragma once

#include "relative/bodies/topology.h"

/// How large a machine is: by this metres, radians, modal coordinates and speeds are weighed against each other.
namespace concord::relative {

/// Length of a machine [m], by which displacements count against rotations: Model::length_scale, the largest distance
/// between two points of joints or force elements on one body. A machine in which all these points coincide gets the
/// largest distance between them and a centre of mass or the largest radius of gyration, so that no length is a matter
/// of units (R62).
double machine_length(const Model& model);

/// Length, mass and rate of a machine, and one unit of each of its coordinates and speeds.
class MachineSize {
 public:
  MachineSize(const Model& model, const Topology& topology);

  /// machine_length [m]
  [[nodiscard]] double length() const { return length_; }
  /// [kg]
  [[nodiscard]] double mass() const { return mass_; }
  /// The rate of the machine [1/s], by which its speeds are small or not: that of gravity, of the speeds it starts with
  /// and of its drivers, which may bring it to rest; of a machine that none of these moves, one over the time of its
  /// run (R64).
  [[nodiscard]] double rate() const { return rate_; }
  /// One unit of each entry of u: the length for a slide, 1 rad for a turn, for a mode the amplitude at which its
  /// largest displacement is the length.
  [[nodiscard]] const VecX& speeds() const { return speeds_; }
  /// The same of each entry of q; 1 for an Euler parameter.
  [[nodiscard]] const VecX& coordinates() const { return coordinates_; }

  /// Largest coordinate in units, and largest speed in units [1/s]; 0 of none.
  [[nodiscard]] double largest_coordinate(const VecX& q) const;
  [[nodiscard]] double largest_speed(const VecX& u) const;
  /// The largest speed, at least the machine's rate [1/s].
  [[nodiscard]] double rate_at(const VecX& u) const;

 private:
  void set_units(const Model& model, const Topology& topology);
  void set_rate(const Model& model, const Topology& topology);

  double length_;
  double mass_ = 0.0;
  double rate_ = 0.0;
  VecX speeds_;
  VecX coordinates_;
};

/// Largest absolute value; 0 of none.
double largest_entry(const VecX& values);

}  // namespace concord::relative
