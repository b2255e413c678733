#pragma once

#include <string>

#include "common/model.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// Version of the document below; another one is refused by whoever reads it.
inline constexpr int kResultFormat = 2;

/// All that was found about one model but the curves, and what a picture of the machine needs, as JSON text on lines of
/// their own, ending with a line feed: `--out` writes it beside the NetCDF files, and `concord report` reads it.
/// Lengths in m, inertia boxes and frames in body axes, angles in rad; matrices row by row. All of it
/// is the same from run to run.
std::string format_result(const Model& model, const Verdict& verdict);

}  // namespace concord::compare
