#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compare/page/page_parts.h"

namespace concord::compare::page {

/// The page of these parts: its title, and the data that its script reads. Text that is not UTF-8 is replaced.
std::string fill_page(const PageParts& parts, const std::string& title, const nlohmann::ordered_json& data);

/// "Made by concord 0.1.0. Units are SI and radians.", which stands below every page.
std::string made_words();

}  // namespace concord::compare::page
