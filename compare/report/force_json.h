#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/model.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// What format_forces() prints, numbers in full: an object for each row with `kind` (joint, element, actor), `of`, and
/// of a wrench `on`, `side`, `F`, `T`, of an actor `along`, `unit`, `force`, `power`; `component`, `check`, `digits`,
/// `need` of the component that is tightest, and `verdict`. A peak is null where there is none, has `not_unique` where
/// it is one of many, and else `peak, t, components`, of an actor `peak, t, rms`.
nlohmann::ordered_json forces_json(const Model& model, const Verdict& verdict);

}  // namespace concord::compare
