#include "tests/second_reading/scope.h"

#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace concord::second_reading {

namespace {

double least(const double* first, int count) { return *std::min_element(first, first + count); }
double greatest(const double* first, int count) { return *std::max_element(first, first + count); }

/// A parser that knows the functions of data/format/files.md and no other.
mu::Parser make_parser() {
  mu::Parser parser;
  parser.ClearFun();
  parser.ClearConst();
  using Function = double (*)(double);
  const std::pair<const char*, Function> functions[] = {
      {"sin", std::sin},   {"cos", std::cos},   {"tan", std::tan}, {"asin", std::asin}, {"acos", std::acos},
      {"atan", std::atan}, {"sqrt", std::sqrt}, {"exp", std::exp}, {"ln", std::log},    {"abs", std::abs}};
  for (const auto& [name, function] : functions) parser.DefineFun(name, function);
  using FunctionOfTwo = double (*)(double, double);
  parser.DefineFun("atan2", static_cast<FunctionOfTwo>(std::atan2));
  parser.DefineFun("min", least);
  parser.DefineFun("max", greatest);
  parser.DefineConst("pi", std::numbers::pi);
  parser.DefineConst("deg", std::numbers::pi / 180.0);
  return parser;
}

bool is_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; }

/// What stands before `deg` is multiplied by it: "20 deg" is "20*deg".
std::string with_products(const std::string& expression) {
  std::string written;
  char before = '(';  // the last character that is no space
  bool in_name = false;
  for (std::size_t k = 0; k < expression.size(); ++k) {
    const char c = expression[k];
    const bool touches = k > 0 && is_of_word(expression[k - 1]);
    const bool is_deg = expression.compare(k, 3, "deg") == 0 && !in_name &&
                        (k + 3 == expression.size() || !is_of_word(expression[k + 3]));
    if (is_deg && (is_of_word(before) || before == ')')) written += '*';
    if (!is_of_word(c)) in_name = false;
    if (is_of_word(c) && !touches) in_name = std::isdigit(static_cast<unsigned char>(c)) == 0 && c != '.';
    if (std::isspace(static_cast<unsigned char>(c)) == 0) before = c;
    written += c;
  }
  return written;
}

/// The names in an expression that are no functions.
std::vector<std::string> names_in(const std::string& expression) {
  static thread_local mu::Parser parser = make_parser();
  try {
    parser.SetExpr(with_products(expression));
    std::vector<std::string> names;
    for (const auto& [name, unused] : parser.GetUsedVar()) names.push_back(name);
    return names;
  } catch (const mu::Parser::exception_type& error) {
    throw std::runtime_error("'" + expression + "': " + error.GetMsg());
  }
}

/// Of the numbers that are written out in an expression.
double largest_literal(const std::string& text) {
  double largest = 0.0;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const bool starts = std::isdigit(static_cast<unsigned char>(text[k])) != 0 && (k == 0 || !is_of_word(text[k - 1]));
    if (starts) largest = std::max(largest, std::strtod(text.c_str() + k, nullptr));
  }
  return largest;
}

}  // namespace

Scope::Scope(const toml::table* own, std::map<std::string, double> given, const Scope* outer)
    : own_(own), outer_(outer), known_(std::move(given)) {}

Scope::Wanted Scope::find(const std::string& name) const {
  for (const Scope* scope = this; scope != nullptr; scope = scope->outer_) {
    if (scope->known_.contains(name) || (scope->own_ != nullptr && scope->own_->contains(name))) return {scope, name};
  }
  throw std::runtime_error("no parameter " + name);
}

std::vector<Scope::Wanted> Scope::unknown_in(const std::string& expression) const {
  std::vector<Wanted> unknown;
  for (const std::string& name : names_in(expression)) {
    const Wanted wanted = find(name);
    if (!wanted.owner->known_.contains(name)) unknown.push_back(wanted);
  }
  return unknown;
}

double Scope::compute(const std::string& expression) const {
  std::map<std::string, double> values;
  for (const std::string& name : names_in(expression)) values[name] = find(name).owner->known_.at(name);
  static thread_local mu::Parser parser = make_parser();
  parser.ClearVar();
  for (auto& [name, value] : values) parser.DefineVar(name, &value);
  parser.SetExpr(with_products(expression));
  return parser.Eval();
}

double Scope::evaluate(const std::string& expression) const {
  constexpr std::size_t kCircle = 1'000'000;  // parameters that wait for each other
  std::vector<Wanted> wanted = unknown_in(expression);
  while (!wanted.empty() && wanted.size() < kCircle) {
    const Wanted last = wanted.back();
    if (last.owner->known_.contains(last.name)) {
      wanted.pop_back();
      continue;
    }
    const toml::node& node = *last.owner->own_->get(last.name);
    const auto text = node.value_exact<std::string>();
    const std::vector<Wanted> before = text ? last.owner->unknown_in(*text) : std::vector<Wanted>();
    if (before.empty()) {
      last.owner->known_[last.name] = text ? last.owner->compute(*text) : last.owner->evaluate(node);
      wanted.pop_back();
    }
    wanted.insert(wanted.end(), before.begin(), before.end());
  }
  return compute(expression);
}

double Scope::evaluate(const toml::node& node) const {
  if (const auto text = node.value_exact<std::string>()) return evaluate(*text);
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* number = node.as_floating_point()) return number->get();
  throw std::runtime_error("no number");
}

double Scope::size_of_terms(const std::string& text) const {
  constexpr std::size_t kMost = 1000;  // texts that are looked at
  double size = 0.0;
  std::vector<std::pair<const Scope*, std::string>> texts{{this, text}};
  std::set<std::pair<const Scope*, std::string>> seen;
  for (std::size_t k = 0; k < texts.size() && k < kMost; ++k) {
    const auto [scope, expression] = texts[k];
    size = std::max(size, largest_literal(expression));
    for (const std::string& name : names_in(expression)) {
      const Wanted wanted = scope->find(name);
      if (!seen.emplace(wanted.owner, name).second) continue;
      if (const auto known = wanted.owner->known_.find(name); known != wanted.owner->known_.end()) {
        size = std::max(size, std::abs(known->second));
      }
      const toml::node* stated = wanted.owner->own_ != nullptr ? wanted.owner->own_->get(name) : nullptr;
      const auto inner = stated != nullptr ? stated->value_exact<std::string>() : std::nullopt;
      if (inner) texts.emplace_back(wanted.owner, *inner);
    }
  }
  return size;
}

}  // namespace concord::second_reading
