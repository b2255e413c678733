#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// How long sources and functions are.
namespace concord::layout {

/// A function with its body, member functions and functions in headers too.
struct FunctionSize {
  std::string name;  // as its definition says it: "Judge::describe"
  int first_line = 0;
  int lines = 0;  // from the first of its declaration to its closing brace
};

/// `source` with comments, texts in quotes and preprocessor lines blanked out; every line stays where it is.
std::string without_texts(std::string_view source);

/// Every function that a C++ source defines, in its order. A function inside another one, or a lambda, is part of that.
std::vector<FunctionSize> function_sizes(std::string_view source);

int count_lines(std::string_view source);

std::string text_of(const std::filesystem::path& file);

/// Every C++ source of the project outside the tests, by its path in the project.
std::map<std::string, std::string> sources(const std::filesystem::path& root);

}  // namespace concord::layout
