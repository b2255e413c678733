#include "tests/second_reading/laws.h"

#include <stdexcept>
#include <utility>

#include "common/overloaded.h"

namespace concord::second_reading {

namespace {

/// A law of time as a file writes it: its word, and its numbers by their keys.
struct WrittenLaw {
  std::string word;
  std::vector<std::pair<std::string, VecX>> numbers;
};

VecX one(double number) { return VecX::Constant(1, number); }

WrittenLaw written(const TimeFunction& law) {
  return std::visit(
      Overloaded{[](const ConstantSpeed& a) {
                   return WrittenLaw{"constant_speed", {{"start", one(a.start)}, {"speed", one(a.speed)}}};
                 },
                 [](const Polynomial& a) {
                   return WrittenLaw{"polynomial", {{"coefficients", column_of(a.coefficients)}}};
                 },
                 [](const Harmonic& a) {
                   return WrittenLaw{"harmonic",
                                     {{"offset", one(a.offset)},
                                      {"amplitude", one(a.amplitude)},
                                      {"frequency", one(a.frequency)},
                                      {"phase", one(a.phase)}}};
                 },
                 [](const SmoothStep& a) {
                   return WrittenLaw{"smooth_step",
                                     {{"t0", one(a.t0)}, {"t1", one(a.t1)}, {"from", one(a.from)}, {"to", one(a.to)}}};
                 },
                 [](const SplineTable& a) {
                   return WrittenLaw{"spline", {{"times", column_of(a.times())}, {"values", column_of(a.values())}}};
                 }},
      law);
}

/// What a file states under a key of a law, with the defaults that the page names.
VecX stated_number(const StatedTable& law, const std::string& key) {
  if (key == "coefficients" || key == "times" || key == "values") return column_of(law.numbers(key).value());
  const auto number = law.number(key);
  const bool has_default = key == "start" || key == "offset" || key == "phase";
  if (!number && !has_default) throw std::runtime_error("a law without " + key);
  return one(number.value_or(0.0));
}

void hold_table(const std::optional<ForceTable>& read, const StatedTable& table, const std::string& key) {
  const auto stated = table.table(key);
  if (!table.ledger().both_have(table.entry(key), read.has_value(), stated.has_value())) return;
  table.ledger().numbers(stated->entry("x"), column_of(read->points().times()), column_of(*stated->numbers("x")));
  table.ledger().numbers(stated->entry("force"), column_of(read->points().values()),
                         column_of(*stated->numbers("force")));
}

void hold_stop(const std::optional<SmoothStop>& read, const StatedTable& table, const std::string& key) {
  const auto stated = table.table(key);
  if (!table.ledger().both_have(table.entry(key), read.has_value(), stated.has_value())) return;
  stated->hold_number("at", read->at);
  stated->hold_number("stiffness", read->stiffness);
  stated->hold_number("width", read->width);
  stated->hold_number("damping", read->damping, 0.0);
}

}  // namespace

void hold_law_of_time(const TimeFunction& law, const StatedTable& table, const std::string& key) {
  Ledger& ledger = table.ledger();
  const WrittenLaw read = written(law);
  if (!table.has_table(key)) {
    // A constant: whatever law says so.
    const double stated = table.number(key).value();
    const bool is_level = read.word == "constant_speed" || read.word == "polynomial";
    ledger.word(table.entry(key), is_level ? "constant" : read.word, "constant");
    VecX numbers = VecX::Zero(read.numbers.size() == 2 ? 2 : read.numbers.front().second.size());
    VecX levels = numbers;
    for (std::size_t k = 0; k < read.numbers.size() && is_level; ++k) {
      numbers.segment(static_cast<Eigen::Index>(k), read.numbers[k].second.size()) = read.numbers[k].second;
    }
    levels(0) = stated;
    if (is_level) ledger.numbers(table.entry(key), numbers, levels);
    return;
  }
  const auto stated = table.table(key);
  stated->hold_word("law", read.word, "");
  if (stated->text("law") != read.word) return;
  for (const auto& [name, numbers] : read.numbers) {
    const VecX of_file = stated_number(*stated, name);
    const bool is_one_group = name != "coefficients" || numbers.size() != of_file.size();
    if (is_one_group) ledger.numbers(stated->entry(name), numbers, of_file);
    for (Eigen::Index k = 0; k < numbers.size() && !is_one_group; ++k) {
      ledger.number(stated->entry(name), numbers(k), of_file(k));  // each has a unit of its own
    }
  }
}

void hold_force_law(const ForceLaw& law, const StatedTable& table) {
  table.hold_number("stiffness", law.stiffness, 0.0);
  table.hold_number("damping", law.damping, 0.0);
  table.hold_number("preload", law.preload, 0.0);
  table.hold_number("free", law.free, 0.0);
  hold_table(law.spring_table, table, "spring_table");
  hold_table(law.damper_table, table, "damper_table");
  hold_stop(law.lower, table, "lower_stop");
  hold_stop(law.upper, table, "upper_stop");
  if (table.ledger().both_have(table.entry("actuator"), law.actuator.has_value(), table.has("actuator"))) {
    hold_law_of_time(*law.actuator, table, "actuator");
  }
}

}  // namespace concord::second_reading
