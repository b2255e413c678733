#pragma once

#include <string>

/// The files of `web/`, as the build embeds them.
namespace concord::compare::page {

/// With places @TITLE@, @STYLE@, @DATA@ and @SCRIPT@; the content policy names the digests of style and script.
std::string html_template();
std::string style_text();
std::string script_text();

}  // namespace concord::compare::page
