#pragma once

#include <toml++/toml.h>

#include <map>
#include <string>
#include <vector>

namespace concord::second_reading {

/// The parameters that expressions of one file see: those that were given to the file, its own, and then those of the
/// file that includes it.
class Scope {
 public:
  Scope(const toml::table* own, std::map<std::string, double> given, const Scope* outer);

  [[nodiscard]] double evaluate(const std::string& expression) const;
  /// A number, or an expression in quotes.
  [[nodiscard]] double evaluate(const toml::node& node) const;
  /// The largest number in an expression that was evaluated, and in those of its parameters: what it may be known to.
  /// Throws std::runtime_error for a text that is no expression.
  [[nodiscard]] double size_of_terms(const std::string& text) const;

 private:
  /// A parameter and the file whose table states it.
  struct Wanted {
    const Scope* owner;
    std::string name;
  };
  /// Who has the value of a parameter, or states it.
  [[nodiscard]] Wanted find(const std::string& name) const;
  [[nodiscard]] std::vector<Wanted> unknown_in(const std::string& expression) const;
  /// The value of an expression whose parameters are all known.
  [[nodiscard]] double compute(const std::string& expression) const;

  const toml::table* own_;
  const Scope* outer_;
  mutable std::map<std::string, double> known_;
};

}  // namespace concord::second_reading
