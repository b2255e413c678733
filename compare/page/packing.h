#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Bytes and numbers as text that a page can hold.
namespace concord::compare::page {

/// Base64 with padding.
std::string base64(std::string_view bytes);

/// Numbers as IEEE single precision, little-endian, in base64: seven digits, enough for a picture. What single
/// precision cannot hold becomes infinite.
std::string packed(const std::vector<double>& numbers);

/// Makes JSON text safe inside a <script> element: no '<', '>' or '&' stands in it any more, nor the two line
/// separators of Unicode; they are written as \u escapes, which mean the same.
std::string safe_in_script(std::string_view json);

/// A text as HTML: & < > " ' become character references.
std::string escape_html(std::string_view text);

}  // namespace concord::compare::page
