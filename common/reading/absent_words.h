#pragma once

#include <string_view>

/// Words of other programs for what this one does not have, or has elsewhere.
namespace concord {

/// What concord lacks that `word` of a model file asks for, singular or plural, and what to write instead: the end of a
/// message about an unknown key, type or law. Empty for any other word.
std::string_view what_is_absent(std::string_view word);

}  // namespace concord
