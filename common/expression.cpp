#include "common/expression.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <set>

#include "common/spelling.h"

namespace concord {

namespace {

bool is_word_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool is_identifier(const std::string& name) {
  return !name.empty() && std::isdigit(static_cast<unsigned char>(name.front())) == 0 &&
         std::all_of(name.begin(), name.end(), is_word_character);
}

/// Whether the word characters before place k belong to a name, and not to a number as in "20deg".
bool continues_name(const std::string& expression, std::size_t k) {
  std::size_t first = k;
  while (first > 0 && is_word_character(expression[first - 1])) --first;
  return first < k && std::isdigit(static_cast<unsigned char>(expression[first])) == 0;
}

/// Writes the product that "20 deg" means: a `*` before every word `deg` that follows a value.
std::string with_products_before_deg(const std::string& expression) {
  static const std::string kUnit = "deg";
  std::string result;
  for (std::size_t k = 0; k < expression.size(); ++k) {
    const bool starts = expression.compare(k, kUnit.size(), kUnit) == 0;
    const bool ends = k + kUnit.size() >= expression.size() || !is_word_character(expression[k + kUnit.size()]);
    if (starts && ends && !continues_name(expression, k)) {
      const auto last = result.find_last_not_of(' ');
      const bool follows_value =
          last != std::string::npos && (is_word_character(result[last]) || result[last] == '.' || result[last] == ')');
      if (follows_value) result += '*';
    }
    result += expression[k];
  }
  return result;
}

mu::Parser make_parser() {
  mu::Parser parser;
  parser.DefineConst("pi", std::numbers::pi);
  parser.DefineConst("deg", std::numbers::pi / 180.0);
  return parser;
}

bool already_means_something(const std::string& name) {
  const mu::Parser parser = make_parser();
  return parser.GetConst().contains(name) || parser.GetFunDef().contains(name);
}

std::set<std::string> names_in(const std::string& expression) {
  mu::Parser parser = make_parser();
  parser.SetExpr(with_products_before_deg(expression));
  std::set<std::string> names;
  for (const auto& [name, unused] : parser.GetUsedVar()) names.insert(name);
  return names;
}

std::string without_final_stop(std::string text) {
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

/// Depth-first evaluation of definitions that refer to each other.
class Resolver {
 public:
  using Values = std::map<std::string, std::optional<double>>;

  Resolver(const std::vector<ParameterDefinition>& definitions, Values& values, std::vector<Diagnostic>& complaints)
      : values_(values), complaints_(complaints) {
    for (const ParameterDefinition& definition : definitions) definitions_[definition.name] = &definition;
  }

  void resolve(const ParameterDefinition& definition, const Parameters& parameters) {
    if (values_.contains(definition.name)) return;
    path_.push_back(definition.name);
    std::optional<double>& value = values_.emplace(definition.name, std::nullopt).first->second;
    if (const auto* number = std::get_if<double>(&definition.value)) {
      value = *number;
    } else if (const auto* expression = std::get_if<std::string>(&definition.value)) {
      value = evaluate(definition, *expression, parameters);
    }
    if (value && !std::isfinite(*value)) {
      complain(definition, fmt::format("must be a finite number, found {}", not_finite_text(*value)));
      value.reset();
    }
    path_.pop_back();
  }

 private:
  std::optional<double> evaluate(const ParameterDefinition& definition, const std::string& expression,
                                 const Parameters& parameters) {
    try {
      for (const std::string& name : names_in(expression)) {
        const auto found = definitions_.find(name);
        if (found == definitions_.end()) continue;
        if (closes_circle(name)) {
          complain(definition, "goes round in a circle: " + circle(name));
          return std::nullopt;
        }
        resolve(*found->second, parameters);
      }
      return parameters.evaluate(expression);
    } catch (const mu::Parser::exception_type& error) {
      complain(definition, fmt::format("cannot read '{}': {}", expression, without_final_stop(error.GetMsg())));
    } catch (const ExpressionError& error) {
      if (*error.what() != '\0') complain(definition, error.what());
    }
    return std::nullopt;
  }

  [[nodiscard]] bool closes_circle(const std::string& name) const {
    return std::find(path_.begin(), path_.end(), name) != path_.end();
  }

  [[nodiscard]] std::string circle(const std::string& name) const {
    std::string text;
    for (auto step = std::find(path_.begin(), path_.end(), name); step != path_.end(); ++step) text += *step + " -> ";
    return text + name;
  }

  void complain(const ParameterDefinition& definition, const std::string& message) {
    complaints_.push_back({definition.where, fmt::format("parameter '{}': {}", definition.name, message)});
  }

  std::map<std::string, const ParameterDefinition*> definitions_;
  Values& values_;
  std::vector<Diagnostic>& complaints_;
  std::vector<std::string> path_;
};

}  // namespace

std::string not_finite_text(double value) { return std::isnan(value) ? "nan" : fmt::format("{}", value); }

Parameters::Parameters(const std::vector<ParameterDefinition>& definitions, std::vector<Diagnostic>& complaints,
                       const Parameters& outer)
    : values_(outer.values_) {
  std::vector<ParameterDefinition> usable;
  for (const ParameterDefinition& definition : definitions) {
    const auto refuse = [&](std::string_view reason) {
      complaints.push_back({definition.where, fmt::format("parameter '{}': {}", definition.name, reason)});
    };
    if (!is_identifier(definition.name)) {
      refuse("the name must consist of letters, digits and underscores, not a digit first");
    } else if (already_means_something(definition.name)) {
      refuse("the name already means something in expressions: choose another");
    } else {
      usable.push_back(definition);
      values_.erase(definition.name);
    }
  }
  Resolver resolver(usable, values_, complaints);
  for (const ParameterDefinition& definition : usable) resolver.resolve(definition, *this);
}

double Parameters::evaluate(const std::string& expression) const {
  mu::Parser parser = make_parser();
  std::vector<std::string> names;
  for (const auto& [name, value] : values_) {
    if (value) parser.DefineConst(name, *value);
    names.push_back(name);
  }
  try {
    parser.SetExpr(with_products_before_deg(expression));
    const double value = parser.Eval();
    if (parser.GetNumResults() != 1) throw ExpressionError(fmt::format("'{}' must be one number", expression));
    return value;
  } catch (const mu::Parser::exception_type& error) {
    if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) {
      throw ExpressionError(fmt::format("cannot read '{}': {}", expression, without_final_stop(error.GetMsg())));
    }
    if (values_.contains(error.GetToken())) throw ExpressionError("");
    throw ExpressionError(fmt::format("unknown name '{}' in '{}': {}", error.GetToken(), expression,
                                      suggestion(error.GetToken(), names, "parameters")));
  }
}

}  // namespace concord
