#pragma once

#include <string>

#include "common/model.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// The verdict on one model as text: head, tables of forces, what else was compared, differences and failures, and a
/// last line with the checks that were passed and those that were not. `all_rows`: every component of joints and force
/// elements, too, with its scale. Says nothing that changes from run to run.
std::string format_verdict(const Model& model, const Verdict& verdict, bool all_rows);

/// What became of a row, in words: "agree", "agree, judged by resolution (same run)", "not unique, not judged", ...
std::string judgement_text(const QuantityRow& row);

/// Whether some column of a reference is judged, and all that are agree.
bool agrees_with_reference(const Verdict& verdict);

/// A line for each pair of bodies that share several joints: what these carry together.
std::string pair_sums_text(const Verdict& verdict);

/// Lines that name the components which are not unique, in all states or in some, one for the joints of planar loops
/// unless `all_rows`, what of them is unique all the same, and what would cure it; empty if all are unique.
std::string not_unique_text(const Model& model, const Verdict& verdict, bool all_rows);

}  // namespace concord::compare
