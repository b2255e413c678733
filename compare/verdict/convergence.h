#pragma once

#include <optional>
#include <string>

#include "compare/resolution/run_pairs.h"
#include "compare/verdict/verdict.h"

/// Runs at several tolerances: whether what two solvers differ by is no more than what the integration of each leaves.
/// Needed by data/models/double_pendulum_3d.toml over 12 s, and by cantilever_under_gravity.toml by ida and dirk: both
/// would differ.
namespace concord::compare {

/// A check by runs is repeated at tighter tolerances while its needs are missed, but not below this.
inline constexpr double kTightestRepeat = 1e-13;

/// Whether all that is judged on a check meets its need; `motion_need`: digits that the motions need.
bool reaches_needs(const Verdict& verdict, Check check, const RunPair& pair, double motion_need);

/// Whether all that is judged on the refined check reaches its need itself, without the rise that may stand for it.
bool reaches_refined_needs(const Verdict& verdict, const RunPair& pair);

/// Which solvers' own runs differ between two tolerances by less than a tenth of what the refined check allows any row
/// and the motions: tightened further they would tell nothing more. Told from each solver's runs alone.
std::array<bool, 2> have_converged(const QuantityLayout& layout, const RunPair& looser, const RunPair& tighter,
                                   const Verdict& verdict);

/// Looks at the rows that miss their need on a check where the same state agrees. If the largest difference among them,
/// relative to its scale, is of the size, within a factor of ten, of what the solvers' own runs moved by in these rows
/// from the looser tolerance to the tighter one, and the same holds for the motions, the integration has not converged,
/// and the solvers cannot be told apart there: marks the rows as not converged and returns a sentence that names the
/// worst. Returns nothing, and marks nothing, if the difference is larger, or if one solver alone moves: then its
/// integration is at fault. `standing`: the solver whose integrator holds its steps no tighter, and may move alone.
std::optional<std::string> find_unconverged(const QuantityLayout& layout, const RunPair& looser, const RunPair& tighter,
                                            Check check, double motion_need, std::optional<std::size_t> standing,
                                            Verdict& verdict);

}  // namespace concord::compare
