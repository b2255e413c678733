#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "compare/report/origin.h"

/// Records as JSON: an object with a key for each field that is listed, of the field's own name; all must be there when
/// it is read.
#define CONCORD_RECORD(Type, ...)                                                               \
  inline void to_json(nlohmann::ordered_json& nlohmann_json_j, const Type& nlohmann_json_t) {   \
    NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_TO, __VA_ARGS__))                    \
  }                                                                                             \
  inline void from_json(const nlohmann::ordered_json& nlohmann_json_j, Type& nlohmann_json_t) { \
    NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_FROM, __VA_ARGS__))                  \
  }

/// Null where there is no number, or one that is not finite.
template <>
struct nlohmann::adl_serializer<std::optional<double>> {
  static void to_json(ordered_json& document, const std::optional<double>& value) {
    document = value && std::isfinite(*value) ? ordered_json(*value) : ordered_json(nullptr);
  }
  static void from_json(const ordered_json& document, std::optional<double>& value) {
    value = document.is_null() ? std::nullopt : std::optional(document.get<double>());
  }
};

namespace concord::compare {

CONCORD_RECORD(Origin, version, commit, compiler, machine)

namespace nightly {

using Json = nlohmann::ordered_json;

/// Text of a file from outside need not be UTF-8.
inline std::string dumped(const Json& document, int indent = -1) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace nightly
}  // namespace concord::compare
