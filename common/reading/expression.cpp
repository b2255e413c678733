#include "common/reading/expression.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"

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

bool ends_with_word(const std::string& text, const std::string& word) {
  return text.ends_with(word) && !continues_name(text, text.size() - word.size());
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
      const bool follows_value = last != std::string::npos &&
                                 (is_word_character(result[last]) || result[last] == '.' || result[last] == ')') &&
                                 !ends_with_word(result.substr(0, last + 1), kUnit);
      if (follows_value) result += '*';
    }
    result += expression[k];
  }
  return result;
}

/// Expressions longer than this are refused: nobody writes them, and a parser takes ever longer with them.
constexpr std::size_t kLongestExpression = 10000;
constexpr std::size_t kLongestName = 100;  // muParser's own limit

double least(const double* values, int count) { return *std::min_element(values, values + count); }
double largest(const double* values, int count) { return *std::max_element(values, values + count); }

/// Knows what data/format/files.md lists, and nothing else: of muParser's own constants one has 13 digits, and its
/// `log` is read as the logarithm to either base.
mu::Parser make_parser() {
  mu::Parser parser;
  parser.ClearConst();
  parser.ClearFun();
  using Function = double (*)(double);
  const std::pair<const char*, Function> functions[] = {
      {"sin", std::sin},   {"cos", std::cos},   {"tan", std::tan}, {"asin", std::asin}, {"acos", std::acos},
      {"atan", std::atan}, {"sqrt", std::sqrt}, {"exp", std::exp}, {"ln", std::log},    {"abs", std::fabs}};
  for (const auto& [name, function] : functions) parser.DefineFun(name, function);
  parser.DefineFun("atan2", static_cast<double (*)(double, double)>(std::atan2));
  parser.DefineFun("min", least);
  parser.DefineFun("max", largest);
  parser.DefineConst("pi", std::numbers::pi);
  parser.DefineConst("deg", std::numbers::pi / 180.0);
  return parser;
}

bool already_means_something(const std::string& name) {
  static const mu::Parser kParser = make_parser();
  return kParser.GetConst().contains(name) || kParser.GetFunDef().contains(name);
}

/// Every word of an expression that may be a name, each once: those after the digits of a number too, as in "20deg".
std::set<std::string> names_in(const std::string& expression) {
  std::set<std::string> names;
  for (std::size_t end = 0, first = 0; first < expression.size(); first = end + 1) {
    end = first;
    while (end < expression.size() && is_word_character(expression[end])) ++end;
    const bool is_number = first < end && std::isdigit(static_cast<unsigned char>(expression[first])) != 0;
    std::size_t start = is_number && end - first > kLongestName ? end - kLongestName : first;
    for (; start < end; ++start) {
      if (std::isdigit(static_cast<unsigned char>(expression[start])) != 0) continue;
      names.insert(expression.substr(start, end - start));
      if (!is_number) break;
    }
  }
  return names;
}

/// An expression in messages.
std::string shown(const std::string& expression) {
  constexpr std::size_t kMost = 120;
  return expression.size() <= kMost ? expression : expression.substr(0, kMost) + "...";
}

/// What an author of these characters meant, and how it is written here; empty if there are none.
std::string hint_on_characters(const std::string& expression) {
  static constexpr std::pair<const char*, const char*> kMeant[] = {
      {"\u2212", "'\u2212' is no minus: write '-'"},
      {"\u2013", "'\u2013' is no minus: write '-'"},
      {"\u00d7", "a product is written '*'"},
      {"\u00b7", "a product is written '*'"},
      {"**", "a power is written '^'"},
      {"\u00b2", "a square is written '^2'"},
      {"\u00b3", "a cube is written '^3'"},
      {"\u00b0", "degrees are written 'deg', as in '20 deg'"},
      {"\u03c0", "write 'pi'"},
      {"\u00a0", "it holds a space that is none of the usual ones"},
      {"%", "percent are written as a fraction: 0.05 for 5 %"}};
  for (const auto& [written, hint] : kMeant) {
    if (expression.find(written) != std::string::npos) return hint;
  }
  return "";
}

/// What the author of a name that is not known meant, if the field writes it so; else the nearest name.
std::string hint_on_name(const std::string& name, const std::vector<std::string>& parameters) {
  static constexpr std::pair<std::string_view, const char*> kMeant[] = {
      {"log", "the natural logarithm is 'ln'"},
      {"log10", "write 'ln(x)/ln(10)'"},
      {"pow", "a power is written '^'"},
      {"rad", "angles are in radians, without a word"},
      {"degrees", "degrees are written 'deg', as in '20 deg'"},
      {"PI", "write 'pi'"},
      {"Pi", "write 'pi'"}};
  static constexpr std::string_view kUnits[] = {"kg", "g",  "t",  "m", "mm", "cm",  "km", "s",
                                                "ms", "Hz", "kN", "N", "Nm", "rpm", "Pa"};
  for (const auto& [written, hint] : kMeant) {
    if (name == written) return hint;
  }
  if (already_means_something(name)) return "it is a function, whose argument stands in parentheses right behind it";
  if (std::find(std::begin(kUnits), std::end(kUnits), name) != std::end(kUnits)) {
    return "numbers are in SI units, without a word for the unit";
  }
  return suggestion(name, parameters, "parameters");
}

std::string without_final_stop(std::string text) {
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

/// Refuses what the parser takes beyond what data/format/files.md lists: comparisons, conditions, assignments.
void refuse_other_operators(const std::string& expression) {
  const std::size_t place = expression.find_first_of("<>=!&|?:");
  if (place == std::string::npos) return;
  throw ExpressionError(fmt::format("cannot read '{}': there is no operator '{}' here, only + - * / ^ and parentheses",
                                    shown(expression), expression[place]));
}

/// "a -> b -> c -> a"; the middle of a long circle is left out.
std::string circle_text(const std::vector<std::string>& circle) {
  constexpr std::size_t kShown = 10;
  std::string text;
  for (std::size_t k = 0; k < circle.size(); ++k) {
    const bool is_left_out = circle.size() > kShown && k >= kShown / 2 && k + kShown / 2 < circle.size();
    if (!is_left_out) text += circle[k] + " -> ";
    if (is_left_out && k == kShown / 2) text += "... -> ";
  }
  return text + circle.front();
}

}  // namespace

/// Depth-first evaluation of definitions that refer to each other, with a stack of its own: they may be many.
class ParameterResolver {
 public:
  ParameterResolver(const std::vector<ParameterDefinition>& definitions, Parameters& parameters,
                    std::vector<Diagnostic>& complaints)
      : parameters_(parameters), complaints_(complaints) {
    for (const ParameterDefinition& definition : definitions) definitions_[definition.name] = &definition;
  }

  void resolve(const ParameterDefinition& definition) {
    if (is_known(definition.name)) return;
    open(definition);
    while (!path_.empty()) {
      Step& step = path_.back();
      if (step.next == step.needs.size()) {
        close();
        continue;
      }
      const auto found = definitions_.find(step.needs[step.next++]);
      if (found == definitions_.end()) continue;
      if (open_.contains(found->first)) {
        complain(*step.definition, "goes round in a circle: " + circle(found->first));
        step.is_at_fault = true;
        step.next = step.needs.size();
      } else if (!is_known(found->first)) {
        open(*found->second);
      }
    }
  }

 private:
  struct Step {
    const ParameterDefinition* definition;
    std::vector<std::string> needs;
    std::size_t next = 0;
    bool is_at_fault = false;
  };

  std::map<std::string, std::optional<double>>& values() { return parameters_.scope_->values; }
  bool is_known(const std::string& name) { return values().contains(name); }

  void open(const ParameterDefinition& definition) {
    values().emplace(definition.name, std::nullopt);
    open_.insert(definition.name);
    Step& step = path_.emplace_back(Step{&definition, {}});
    const auto* expression = std::get_if<std::string>(&definition.value);
    if (expression == nullptr || expression->size() > kLongestExpression) return;
    const std::set<std::string> names = names_in(*expression);
    step.needs.assign(names.begin(), names.end());
  }

  void close() {
    const Step& step = path_.back();
    if (!step.is_at_fault) values()[step.definition->name] = value_of(*step.definition);
    open_.erase(step.definition->name);
    path_.pop_back();
  }

  std::optional<double> value_of(const ParameterDefinition& definition) {
    std::optional<double> value;
    if (const auto* number = std::get_if<double>(&definition.value)) {
      value = *number;
    } else if (const auto* expression = std::get_if<std::string>(&definition.value)) {
      try {
        value = parameters_.evaluate(*expression);
      } catch (const ExpressionError& error) {
        if (*error.what() != '\0') complain(definition, error.what());
      }
    }
    if (value && !std::isfinite(*value)) {
      complain(definition, fmt::format("must be a finite number, found {}", not_finite_text(*value)));
      value.reset();
    } else if (value && !has_usable_size(*value)) {
      complain(definition, complaint_about_size(*value));
      value.reset();
    }
    return value;
  }

  [[nodiscard]] std::string circle(const std::string& name) const {
    std::vector<std::string> names;
    const auto first =
        std::find_if(path_.begin(), path_.end(), [&](const Step& step) { return step.definition->name == name; });
    for (auto step = first; step != path_.end(); ++step) names.push_back(step->definition->name);
    return circle_text(names);
  }

  void complain(const ParameterDefinition& definition, const std::string& message) {
    complaints_.push_back({definition.where, fmt::format("parameter '{}': {}", definition.name, message)});
  }

  std::map<std::string, const ParameterDefinition*> definitions_;
  Parameters& parameters_;
  std::vector<Diagnostic>& complaints_;
  std::vector<Step> path_;
  std::set<std::string> open_;
};

std::string not_finite_text(double value) { return std::isnan(value) ? "nan" : fmt::format("{}", value); }

Parameters::Parameters(const std::vector<ParameterDefinition>& definitions, std::vector<Diagnostic>& complaints,
                       const Parameters& outer)
    : scope_(std::make_shared<Scope>(Scope{{}, outer.scope_})) {
  std::vector<ParameterDefinition> usable;
  for (const ParameterDefinition& definition : definitions) {
    const auto refuse = [&](std::string_view reason) {
      complaints.push_back({definition.where, fmt::format("parameter '{}': {}", definition.name, reason)});
    };
    if (!is_identifier(definition.name)) {
      refuse("the name must consist of letters, digits and underscores, not a digit first");
    } else if (definition.name.size() > kLongestName) {
      refuse(fmt::format("the name has {} characters, at most {} are allowed", definition.name.size(), kLongestName));
    } else if (already_means_something(definition.name)) {
      refuse("the name already means something in expressions: choose another");
    } else {
      usable.push_back(definition);
    }
  }
  ParameterResolver resolver(usable, *this, complaints);
  for (const ParameterDefinition& definition : usable) resolver.resolve(definition);
}

const std::optional<double>* Parameters::find(const std::string& name) const {
  for (const Scope* scope = scope_.get(); scope != nullptr; scope = scope->outer.get()) {
    const auto found = scope->values.find(name);
    if (found != scope->values.end()) return &found->second;
  }
  return nullptr;
}

std::vector<std::string> Parameters::names() const {
  std::set<std::string> all;
  for (const Scope* scope = scope_.get(); scope != nullptr; scope = scope->outer.get()) {
    for (const auto& [name, value] : scope->values) all.insert(name);
  }
  return {all.begin(), all.end()};
}

double Parameters::evaluate(const std::string& expression) const {
  if (expression.size() > kLongestExpression) {
    throw ExpressionError(fmt::format("an expression of {} characters is too long: at most {} are allowed",
                                      expression.size(), kLongestExpression));
  }
  refuse_other_operators(expression);
  mu::Parser parser = make_parser();
  try {
    for (const std::string& name : names_in(expression)) {
      const auto* value = find(name);
      if (value != nullptr && *value) parser.DefineConst(name, **value);
    }
    parser.SetExpr(with_products_before_deg(expression));
    const double value = parser.Eval();
    if (parser.GetNumResults() != 1) throw ExpressionError(fmt::format("'{}' must be one number", shown(expression)));
    return value;
  } catch (const mu::Parser::exception_type& error) {
    const bool is_name = error.GetCode() == mu::ecUNASSIGNABLE_TOKEN;
    const std::string hint = hint_on_characters(is_name ? error.GetToken() : expression);
    if (!is_name || !hint.empty()) {
      throw ExpressionError(fmt::format("cannot read '{}': {}", shown(expression),
                                        hint.empty() ? without_final_stop(error.GetMsg()) : hint));
    }
    const auto* value = find(error.GetToken());
    if (value != nullptr && !*value) throw ExpressionError("");
    throw ExpressionError(fmt::format("unknown name '{}' in '{}': {}", shown(error.GetToken()), shown(expression),
                                      hint_on_name(error.GetToken(), names())));
  }
}

}  // namespace concord
