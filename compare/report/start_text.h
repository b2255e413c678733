#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/report/text_table.h"
#include "compare/states/start_report.h"

namespace concord::compare {

/// A table of the joint coordinates at the start: what the model says of each, how far it moved from a guess where that
/// is noticeable, and its value in up to three other poses that were found, where it is another; then the bodies that
/// moved from theirs. Without `all_rows` the eight coordinates that moved or differ most, and a count of the rest.
std::string format_start(const Model& model, const StartReport& start, bool all_rows);

/// Where other poses were found, one line: the coordinate that differs most, at the start and in the others. Else
/// empty.
std::string poses_line(const Model& model, const StartReport& start);

/// The table of all coordinates, and the lines below it.
struct StartTable {
  TextTable table;
  std::vector<std::string> lines;
};
StartTable start_table(const Model& model, const StartReport& start);

/// All of it: members `coordinates`, `bodies` and `other_poses`.
nlohmann::ordered_json start_json(const Model& model, const StartReport& start);

}  // namespace concord::compare
