#include "compare/verdict/reference_hints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compare/quantities/columns.h"

namespace concord::compare {

namespace {

constexpr double kNoZero = 10.0;  // so many errors are no zero

/// Whether the Euler parameters of a body are, within the allowed error, those of the inverse rotation.
bool is_inverse(const RunsAtTimes& runs, const Reference& reference, const Column& column, double allowed) {
  if (column.field != Field::euler_parameter) return false;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    std::array<double, 2> off{};  // with either sign
    for (const ReferenceColumn& other : reference.columns) {
      if (other.column.field != column.field || other.column.owner != column.owner) continue;
      const double inverse = (other.column.component == 0 ? 1.0 : -1.0) * value_of(other.column, runs.sample(0, k));
      off[0] = std::max(off[0], std::abs(inverse - other.values[k]));
      off[1] = std::max(off[1], std::abs(inverse + other.values[k]));
    }
    if (!(std::min(off[0], off[1]) <= allowed)) return false;
  }
  return true;
}

/// Whether the numbers of a reference fit another column, or its opposite, within the allowed error at every time.
bool fits(const RunsAtTimes& runs, const std::vector<double>& values, const Column& other, double sign,
          double allowed) {
  for (std::size_t who = 0; who < 2; ++who) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!(std::abs(value_of(other, runs.sample(who, k)) - sign * values[k]) <= allowed)) return false;
    }
  }
  return true;
}

/// Whether two columns are of one owner and one unit.
bool is_kin(const Column& one, const Column& other) {
  const auto is_of_body = [](const Column& column) { return column.field <= Field::modal_acceleration; };
  const auto is_of_element = [](const Column& column) { return column.field >= Field::element; };
  return one.owner == other.owner && one.unit == other.unit && is_of_body(one) == is_of_body(other) &&
         is_of_element(one) == is_of_element(other) &&
         (one.field == Field::coupling) == (other.field == Field::coupling);
}

/// "it is 1000 times as large: in other units?" if the numbers of a reference are a multiple of the column's, which
/// must be more than its error, else empty. An error in percent is as much less in the run as its numbers are.
std::string hint_at_factor(const RunsAtTimes& runs, const ReferenceColumn& column, double allowed) {
  double product = 0.0;
  double square = 0.0;
  double largest = 0.0;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    const double value = value_of(column.column, runs.sample(0, k));
    product += value * column.values[k];
    square += value * value;
    largest = std::max(largest, std::abs(value));
  }
  const double factor = product / square;
  if (!std::isfinite(factor) || factor == 0.0) return "";
  const double allowed_in_run = column.is_relative ? allowed / std::max(1.0, std::abs(factor)) : allowed;
  if (largest <= kNoZero * allowed_in_run) return "";
  double difference = 0.0;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    difference = std::max(difference, std::abs(factor * value_of(column.column, runs.sample(0, k)) - column.values[k]));
  }
  if (!(difference <= allowed_in_run * std::abs(factor))) return "";  // the error, too, is in those units
  constexpr double kTheSame = 1e-6;
  if (std::abs(factor - 1.0) < kTheSame) return "";
  constexpr double kOpposite = 0.01;
  if (std::abs(factor + 1.0) < kOpposite) return "it has the other sign";
  return fmt::format("it is {:.6g} times as large{}", factor,
                     std::abs(std::log10(std::abs(factor))) > 1.0 ? ": in other units?" : "");
}

}  // namespace

std::string what_would_fit(const Model& model, const RunsAtTimes& runs, const Reference& reference,
                           const ReferenceColumn& column, double allowed) {
  const double peak = std::abs(*std::max_element(column.values.begin(), column.values.end(),
                                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  std::string factor = column.values.size() > 2 ? hint_at_factor(runs, column, allowed) : "";
  if (peak <= kNoZero * allowed) return factor;
  if (is_inverse(runs, reference, column.column, allowed)) return "it is the inverse rotation";
  if (fits(runs, column.values, column.column, -1.0, allowed)) return "it has the other sign";
  for (const double sign : {1.0, -1.0}) {
    for (const auto& columns :
         {reaction_columns(model), element_columns(model), motion_columns(model), further_columns(model)}) {
      for (const Column& other : columns) {
        if (other.name == column.column.name || !is_kin(other, column.column)) continue;
        if (!fits(runs, column.values, other, sign, allowed)) continue;
        return fmt::format("it agrees with {}{}: on another side, in other axes, or of the other sign?",
                           sign < 0.0 ? "-" : "", other.name);
      }
    }
  }
  return factor;
}

}  // namespace concord::compare
