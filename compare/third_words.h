#pragma once

#include <string>
#include <vector>

#include "common/model.h"
#include "compare/third_opinion.h"
#include "compare/verdict.h"

/// The third opinion in words.
namespace concord::compare {

/// Of each joint, coupling or body on which the programs differ its worst component: "cartesian and simbody agree to
/// 12.1 digits, relative is off: joint D on slider, T_z, ...". Where the solvers agree and the third opinion is off, it
/// is a finding; where one of the solvers is off, there is one already, and a note says which.
void judge_third(const Model& model, Verdict& verdict);

/// A table of the worst component of each joint's side, coupling and body, or of all, and a line that sums them up;
/// what it does not know, where it was not asked. Empty without a third opinion.
std::string format_third(const Model& model, const Verdict& verdict, bool all_rows);

/// "nobody", "cartesian", "relative", the third's own name, "unclear".
std::string name_of(Blame blame, const std::string& third);

/// "reaction", "reaction, global", "total", "force", "acceleration", "sum".
std::string word_of(Kind kind);

}  // namespace concord::compare
