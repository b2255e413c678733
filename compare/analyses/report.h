#pragma once

#include <string>

#include "compare/analyses/judge.h"

namespace concord::compare::analyses {

/// What an analysis found and how far the solvers agree, as text. Compact: of each joint or element and side the
/// component that comes nearest to its need; `all_rows`: every component.
std::string format_analysis(const Model& model, const AnalysisVerdict& result, bool all_rows);

/// The same as JSON, see compare/report/README.
std::string format_analysis_json(const Model& model, const AnalysisVerdict& result);

/// The modes, a line each: eigenvalue, frequency, damping ratio, 1 for a free one, and the shape (complex velocities).
std::string format_modes_csv(const Model& model, const Linearization& found);

}  // namespace concord::compare::analyses
