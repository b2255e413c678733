#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/laws/time_function.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// Reads a law of time: `law = "constant_speed"` (or another word) and the numbers of that law. Nothing after a
/// complaint.
std::optional<TimeFunction> read_time_function(const toml::table& table, const std::string& title,
                                               FileReading& reading);

/// Reads the law of time of an actuator or a load under `key`: a table as above, or a number, which means constant.
/// Nothing if the key is missing or after a complaint.
std::optional<TimeFunction> read_law_or_number(const TableReader& table, std::string_view key);

/// Two lists of as many numbers: those of a cubic spline.
struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// Reads the lists of a spline: at least four points, x strictly rising. `unit` of x is for messages, such as " s".
/// Nothing after a complaint.
std::optional<Points> read_points(const TableReader& table, std::string_view x_key, std::string_view y_key,
                                  std::string_view unit);

}  // namespace concord
