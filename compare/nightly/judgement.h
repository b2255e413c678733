#pragma once

#include <string>
#include <vector>

#include "compare/nightly/baseline.h"
#include "compare/nightly/history.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"

namespace concord::compare::nightly {

/// A case in a night that the history must have. Throws DatabaseError if it has lost it.
Result result_of_case(History& history, long night, const std::string& id);

/// These cases of a night, each compared with its baseline and the nights before. `today`: "2026-11-22", the day on
/// which a case may be known red. The report has no code yet.
NightReport judge_night(History& history, const Night& night, const std::vector<const Case*>& cases,
                        const Baselines& baselines, const Judging& judging, const std::string& today);

/// Tells baselines of cases that are not in the suite any more, if baselines count.
void add_gone(const Suite& suite, const Baselines& baselines, NightReport& report);

}  // namespace concord::compare::nightly
