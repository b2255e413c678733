#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "common/model.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// Digits with two decimals, rounded down; null where there are none.
nlohmann::ordered_json digits_json(const std::optional<double>& value);

/// "agree", "differ" or "not_judged".
nlohmann::ordered_json judgement_json(Judgement judgement);

/// Adds what explains a verdict, each key only where there is something to say: `reference` (rows of a table from
/// outside), `attribution` (who is to blame, and whether equations or motions differ), `third_opinion`. The verdict's
/// document and the result file hold the same.
void add_explanations(nlohmann::ordered_json& said, const Model& model, const Verdict& verdict);

}  // namespace concord::compare
