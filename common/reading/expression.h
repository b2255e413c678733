#pragma once

#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "common/error.h"

/// Parameters of a model file, and the expressions in which they stand wherever a number may stand.
namespace concord {

/// An expression that cannot be evaluated. The text is empty if it only uses a parameter that is itself at fault, so
/// that one fault is reported once.
class ExpressionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One line of `[parameters]`.
struct ParameterDefinition {
  std::string name;
  /// A number, an expression, or nothing: at fault already, and reported.
  std::variant<std::monostate, double, std::string> value;
  SourceLocation where;
};

/// "inf", "-inf" or "nan" (of either sign), for messages about numbers that are not finite.
std::string not_finite_text(double value);

/// Named numbers. Expressions know + - * / ^ ( ), the functions sin, cos, tan, asin, acos, atan, atan2, sqrt, exp, ln,
/// abs, min and max, `pi`, `deg` (pi / 180, also written after a number: "20 deg") and the parameters.
class Parameters {
 public:
  Parameters() = default;

  /// Resolves definitions that refer to each other in any order. Names that are no identifiers or already mean
  /// something, expressions at fault and circles of references are added to `complaints`. What they do not define is
  /// that of `outer`.
  Parameters(const std::vector<ParameterDefinition>& definitions, std::vector<Diagnostic>& complaints,
             const Parameters& outer = {});

  /// Value of an expression; throws ExpressionError. Need not be finite.
  [[nodiscard]] double evaluate(const std::string& expression) const;

 private:
  /// The parameters of one file; those of the file that includes it are looked up behind them.
  struct Scope {
    /// Nothing: the parameter is at fault.
    std::map<std::string, std::optional<double>> values;
    std::shared_ptr<const Scope> outer;
  };
  friend class ParameterResolver;

  /// The value of a parameter, nullptr if there is none of that name.
  [[nodiscard]] const std::optional<double>* find(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> names() const;

  std::shared_ptr<Scope> scope_;
};

}  // namespace concord
