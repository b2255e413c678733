#include "compare/page/fill.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/page/packing.h"
#include "compare/report/origin.h"

namespace concord::compare::page {

namespace {

/// The template with its places filled, each once: what is put in is not searched again.
std::string filled(const std::string& html, const std::vector<std::pair<std::string_view, std::string>>& places) {
  std::string page;
  std::string_view rest = html;
  while (!rest.empty()) {
    std::size_t first = rest.size();
    const std::pair<std::string_view, std::string>* found = nullptr;
    for (const auto& place : places) {
      const std::size_t at = rest.find(place.first);
      if (at < first) {
        first = at;
        found = &place;
      }
    }
    page += rest.substr(0, first);
    if (found == nullptr) break;
    page += found->second;
    rest.remove_prefix(first + found->first.size());
  }
  return page;
}

}  // namespace

std::string fill_page(const PageParts& parts, const std::string& title, const nlohmann::ordered_json& data) {
  using DataJson = nlohmann::ordered_json;
  const std::string json = safe_in_script(data.dump(-1, ' ', false, DataJson::error_handler_t::replace));
  return filled(
      parts.html,
      {{"@TITLE@", escape_html(title)}, {"@STYLE@", parts.style}, {"@DATA@", json}, {"@SCRIPT@", parts.script}});
}

std::string made_words() {
  const char* said = std::getenv("SOURCE_DATE_EPOCH");
  char* end = nullptr;
  const long long seconds = said != nullptr ? std::strtoll(said, &end, 10) : 0;
  const bool is_said = said != nullptr && end != said && *end == '\0';
  const std::time_t when = is_said ? static_cast<std::time_t>(seconds) : std::time(nullptr);
  return fmt::format("Made by {} on {:%Y-%m-%d}. Units are SI and radians.", version_words(), fmt::gmtime(when));
}

}  // namespace concord::compare::page
