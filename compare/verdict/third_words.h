#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/quantities/third_opinion.h"
#include "compare/verdict/verdict.h"

/// The third opinion in words.
namespace concord::compare {

/// Of each joint, coupling or body on which the programs differ its worst component: "cartesian and simbody agree to
/// 12.1 digits, relative is off: joint D on slider, T_z, ...". Where the solvers agree and the third opinion is off, it
/// is a finding; where one of the solvers is off, there is one already, and a note says which.
void judge_third(const Model& model, Verdict& verdict);

/// The worst row of each joint's side, coupling and body among those that `chosen` takes, in the order of the rows.
std::vector<const ThirdRow*> worst_third_rows(const std::vector<ThirdRow>& rows,
                                              const std::function<bool(const ThirdRow&)>& chosen);

/// Digits in words, "0" for less than a twentieth of one.
std::string third_digits_text(double digits);

/// "nobody", "cartesian", "relative", the third's own name, "unclear".
std::string name_of(Blame blame, const std::string& third);

/// "reaction", "reaction, global", "total", "force", "acceleration", "sum".
std::string word_of(Kind kind);

}  // namespace concord::compare
