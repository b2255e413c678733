#pragma once

#include "common/model.h"
#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

/// The first `[run]` and the first `gravity` of the files, and what holds without them.
void hold_run(const RunSettings& run, const std::vector<const StatedFile*>& files);
void hold_gravity(const Vec3& gravity, const std::vector<const StatedFile*>& files);

/// What `[[need]]` states.
void hold_need(const NeedOverride& need, const StatedTable& table);

}  // namespace concord::second_reading
