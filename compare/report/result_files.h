#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/agreement.h"

/// A solver's trajectory as files that other programs read. Nothing in them depends on when or how fast they were made;
/// each is written under a temporary name and then renamed, so that no reader meets half of one. All throw InputError
/// if the path cannot be written, std::runtime_error if the disk is full.
namespace concord::compare {

/// NetCDF-4, for xarray: dimensions time, body (ground left out), joint, side, component (F_x ... T_z), axis, euler
/// (parameters e0 ... e3), and, where the model has them, element (force elements; zero on the parent that a load has
/// not), mode, coordinate and speed (padded with NaN where a body or
/// joint has fewer). Names are string coordinate variables; units stand in attributes, and in the variables
/// component_units, coordinate_units and speed_units where they differ along a dimension. `solver` names the source.
/// `unique` (rows: quantities of the layout, columns: samples; null: not known) adds a variable of that name. Where a
/// number of a wrench or a coordinate force is not unique its variable holds NaN, and another one, any_reaction beside
/// reaction, holds the solver's own values; there is none where all of a variable is unique.
/// `axes` of a body (see told_axes()) add the variables reaction_told and element_wrench_told, in these axes; those of
/// global axes are there always.
void write_netcdf(const std::filesystem::path& path, const Model& model, std::string_view solver,
                  const Trajectory& trajectory, const Mask* unique = nullptr, std::optional<int> axes = {});

/// One line for each time: time, then motion, modal coordinates and accelerations of each body, and coordinates of each
/// joint. The header names each column with its unit: `coupler.omega_x [rad/s]`.
void write_motion_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory);

/// One line for each time: reactions on the parent and on the child of each joint, each in that side's joint frame, and
/// forces on the joint speeds: `A.child.F_x [N]`, `A.tau_1 [N m]`.
/// Where a component is not unique by `unique` its column holds nan, and a column of the same name with `any_` before
/// it, behind all others, the solver's own value. Comment lines (#) before the header name these components with the
/// number of samples. Reactions in the `axes` of a body stand in columns `A.child.in_crank.F_x [N]`, in global ones in
/// `A.child.global.F_x [N]`.
void write_reaction_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory,
                        const Mask* unique = nullptr, std::optional<int> axes = {});

/// One line for each time: the wrench of each force element on its ends, each in that end's frame: `strut.child.F_x
/// [N]`; a load has no parent. `axes` as those of write_reaction_csv().
void write_element_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory,
                       std::optional<int> axes = {});

}  // namespace concord::compare
