#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

/// The files of `web/`, as the build embeds them, and the pages that are made of them.
namespace concord::compare::page {

struct PageParts {
  std::string html;  // with places @TITLE@, @STYLE@, @DATA@ and @SCRIPT@; the content policy names the digests
  std::string style;
  std::string script;
};

/// The page of machines that were compared, and that of a night.
PageParts machine_parts();
PageParts night_parts();

/// The page of these parts: its title, and the data that its script reads. Text that is not UTF-8 is replaced.
std::string fill_page(const PageParts& parts, const std::string& title, const nlohmann::ordered_json& data);

/// "Made by concord 0.1.0 (3f97bf0c1a2b, gcc 12.2.0) on 2026-03-31. Units are SI and radians.", which stands below
/// every page; the day, in UTC, is that of SOURCE_DATE_EPOCH where it is set.
std::string made_words();

}  // namespace concord::compare::page
