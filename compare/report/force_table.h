#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/agreement.h"
#include "compare/report/peaks.h"
#include "compare/report/text_table.h"
#include "compare/verdict/verdict.h"

/// The forces of a run as tables: a row for each joint and side, each force element and side, and each driver, motor,
/// spring, damper and coupling.
namespace concord::compare {

/// Of one solver's run, as force_peaks() finds them. "not unique" stands in place of a number that is one of many, and
/// "1058 (xy)" is the size of the components that are unique, in the frame of the side or in the `axes` of a body, see
/// told_axes(). Positive forces of actors push the coordinate, or the sum of a coupling, to grow; power is what they
/// deliver to the motion. With axes of a body a table of all components in them follows.
std::string format_peaks(const Model& model, const Trajectory& run, const Mask* unique = nullptr,
                         std::optional<int> axes = {});

/// The same of the run of the first solver that finished it, with the component that comes nearest to its need of
/// digits, or fails it most, and what became of it. Without a run, or where uniqueness is not known, there are no
/// peaks. Needs that the model lowers follow.
std::string format_forces(const Model& model, const Verdict& verdict);

/// The tables of format_forces(), and what stands above them of axes that are not those of the sides.
struct ForceTables {
  std::string axes;
  std::vector<TextTable> tables;
};
ForceTables force_tables(const Model& model, const Verdict& verdict);

/// The peaks that format_forces() shows.
std::vector<ForcePeaks> peaks_of(const Model& model, const Verdict& verdict);

/// The component that stands for a row of forces: the judged one with the least margin, or the first where none is
/// judged; nullptr where there is none.
const QuantityRow* worst_row(const Verdict& verdict, const Quantity& of);

/// The check on which a row comes nearest to its need, or fails it most.
Check tightest_check(const QuantityRow& row);

/// Names of the joint or force element of a wrench, and of the body on which it acts.
std::pair<std::string, std::string> owner_names(const Model& model, const Quantity& quantity);

/// "turn_z" of the joint's speed along which a force acts; "-" of a coupling.
std::string coordinate_of(const Model& model, const Quantity& of);

}  // namespace concord::compare
