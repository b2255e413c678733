#include "compare/page/fill.h"

#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/page/packing.h"

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

std::string made_words() { return "Made by concord " CONCORD_VERSION ". Units are SI and radians."; }

}  // namespace concord::compare::page
