#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Help for whoever misspelled a word of a model file.
namespace concord {

/// Number of letters to insert, delete, replace or swap with a neighbour until `a` reads `b`.
int edit_distance(std::string_view a, std::string_view b);

/// "did you mean 'mass'?" if a candidate is near enough to `word`; else "known <plural>: a, b, c", or "there are no
/// <plural>".
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates, std::string_view plural);

/// "a, b, c".
std::string join_names(const std::vector<std::string>& names);

}  // namespace concord
