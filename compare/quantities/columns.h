#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/observe.h"

/// Every number of a run that result files hold, one column each: its name, its unit, and where to find it.
namespace concord::compare {

/// What a column belongs to: motion of a body, coordinates of a joint, a wrench on a joint or a force element.
enum class Field {
  position,
  euler_parameter,
  velocity,
  angular_velocity,
  acceleration,
  angular_acceleration,
  modal_coordinate,
  modal_velocity,
  modal_acceleration,
  joint_coordinate,
  reaction,         // in the side's joint frame
  reaction_global,  // global axes
  total,
  total_global,
  tau,
  share,  // of one actor
  coupling,
  element,  // in the end's frame
  element_global
};

struct Column {
  std::string name;  // "coupler.omega_x", "A.child.F_x", "A.tau_1"
  std::string unit;  // "rad/s"
  Field field = Field::reaction;
  int owner = 0;                // body, joint, coupling or force element
  Side side = Side::child;      // of wrenches
  int component = 0;            // from 0
  Actor actor = Actor::driver;  // of a share
  bool is_alone = false;        // of a share: nothing else acts there
  bool is_own = false;          // a solver's own value, also where it is one of many
};

/// The number of a column in one sample.
double value_of(const Column& column, const Sample& sample);

/// The columns of .motion.csv, .reactions.csv and .elements.csv, without the time.
std::vector<Column> motion_columns(const Model& model);
std::vector<Column> reaction_columns(const Model& model);
std::vector<Column> element_columns(const Model& model);

/// Wrenches that only NetCDF files hold: "A.child.total.F_x", "A.child.global.F_x", "A.child.total_global.F_x",
/// "strut.child.global.F_x", and forces of couplings, "gear.force".
std::vector<Column> further_columns(const Model& model);

/// Whether a column's number can be one of many: a reaction, a total wrench, a force on a joint speed or of a coupling.
bool may_be_open(const Column& column);

/// The column "any_A.child.F_x" beside "A.child.F_x": the solver's own value also where the component is not unique,
/// and where "A.child.F_x" holds nan.
Column own_column(const Column& column);

/// The quantity that is compared between the solvers and whose row gives a column's scale and whether it is unique;
/// nothing for places and speeds.
std::optional<Quantity> quantity_of(const Column& column);

/// "joint D on slider (total wrench, global axes)", "body coupler".
std::string describe_owner(const Model& model, const Column& column);
/// "F_x", "tau_1", "omega_x", "any_F_x".
std::string describe_component(const Column& column);

/// Units number by number of the coordinates, the speeds, and the forces on the speeds of a joint type.
std::vector<std::string> coordinate_units(const joints::JointType& type);
std::vector<std::string> speed_units(const joints::JointType& type);
std::vector<std::string> speed_force_units(const joints::JointType& type);

}  // namespace concord::compare
