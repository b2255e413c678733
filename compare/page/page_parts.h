#pragma once

#include <string>

/// The files of `web/`, as the build embeds them.
namespace concord::compare::page {

struct PageParts {
  std::string html;  // with places @TITLE@, @STYLE@, @DATA@ and @SCRIPT@; the content policy names the digests
  std::string style;
  std::string script;
};

/// The page of machines that were compared, and that of a night.
PageParts machine_parts();
PageParts night_parts();

}  // namespace concord::compare::page
