#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Help for whoever misspelled a word of a model file.
namespace concord {

/// Number of letters to insert, delete, replace or swap with a neighbour until `a` reads `b`.
int edit_distance(std::string_view a, std::string_view b);

/// Whether the words are the same, or the plural and the singular of one noun: "bodies" and "body", "axes" and "axis".
bool is_same_but_for_number(std::string_view a, std::string_view b);

/// "did you mean 'mass'?" if a candidate is `word` in another number or by another name, or near enough to it: at most
/// a third of the letters are wrong; else "known <plural>: a, b, c", or "there are no <plural>".
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates, std::string_view plural);

/// The same for a word of the format, where what concord does not have may be asked for: what_is_absent(word), unless a
/// candidate is the word in another number or by another name.
std::string help_with_word(std::string_view word, const std::vector<std::string>& candidates, std::string_view plural);

/// "a, b, c".
std::string join_names(const std::vector<std::string>& names);

}  // namespace concord
