#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"

/// One solver's run as plain tables of numbers: what the page draws, wherever it comes from.
namespace concord::compare::page {

/// Numbers in rows, one row for each sample, each row `width` long.
struct Samples {
  std::size_t width = 0;
  std::vector<double> values;

  [[nodiscard]] double at(std::size_t sample, std::size_t place) const { return values[sample * width + place]; }
};

struct Curves {
  std::string solver;
  std::vector<double> t;   // s
  std::size_t bodies = 0;  // without ground
  std::size_t joints = 0;
  std::size_t elements = 0;
  std::size_t modes = 0;  // of the body that has most; shorter rows are padded with NaN
  Samples position;       // body, axis [m]
  Samples euler;          // body, Euler parameter
  Samples modal;          // body, mode
  Samples reaction;       // joint, side (parent, child), component, in the side's joint frame [N, N m]
  Samples reaction_global;
  Samples element;  // element, side, component, in the end's frame
  Samples element_global;
};

/// Of a run in memory.
Curves curves_of(const Model& model, const std::string& solver, const Trajectory& trajectory);

/// Of a NetCDF file that write_netcdf() wrote. Throws InputError, naming the file, if it is no such file, lacks a
/// variable or holds one of another shape.
Curves read_curves(const std::filesystem::path& file, const std::string& solver);

}  // namespace concord::compare::page
