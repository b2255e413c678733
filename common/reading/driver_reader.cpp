#include "common/reading/driver_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

/// The law; nothing after a complaint at the key if the law's derivatives overflow.
std::optional<TimeFunction> if_usable(TimeFunction law, const TableReader& table, std::string_view key) {
  constexpr double kStart = 0.0;
  if (stays_usable(law, kStart)) return law;
  table.complain(key, fmt::format("the law or one of its first two derivatives goes beyond {}", kLargestSize));
  return std::nullopt;
}

std::optional<TimeFunction> read_constant_speed(const TableReader& table) {
  if (!table.require({"speed"})) return std::nullopt;
  const auto speed = table.number("speed");
  if (!speed) return std::nullopt;
  return ConstantSpeed{.start = table.number("start").value_or(0.0), .speed = *speed};
}

std::optional<TimeFunction> read_polynomial(const TableReader& table) {
  if (!table.require({"coefficients"})) return std::nullopt;
  const auto coefficients = table.numbers("coefficients");
  if (!coefficients) return std::nullopt;
  if (coefficients->empty()) {
    table.complain("coefficients", "'coefficients' must have at least one number: those of 1, t, t^2, ...");
    return std::nullopt;
  }
  return Polynomial{*coefficients};
}

std::optional<TimeFunction> read_harmonic(const TableReader& table) {
  if (!table.require({"amplitude", "frequency"})) return std::nullopt;
  const auto amplitude = table.number("amplitude");
  const auto frequency = table.number("frequency");
  if (!amplitude || !frequency) return std::nullopt;
  const Harmonic law{.offset = table.number("offset").value_or(0.0),
                     .amplitude = *amplitude,
                     .frequency = *frequency,
                     .phase = table.number("phase").value_or(0.0)};
  return if_usable(law, table, "amplitude");
}

std::optional<TimeFunction> read_smooth_step(const TableReader& table) {
  if (!table.require({"t0", "t1", "from", "to"})) return std::nullopt;
  const auto t0 = table.number("t0");
  const auto t1 = table.number("t1");
  const auto from = table.number("from");
  const auto to = table.number("to");
  if (!t0 || !t1 || !from || !to) return std::nullopt;
  if (*t1 <= *t0) {
    table.complain("t1", fmt::format("'t1' must be later than 't0' = {} s, found {} s", *t0, *t1));
    return std::nullopt;
  }
  return if_usable(SmoothStep{.t0 = *t0, .t1 = *t1, .from = *from, .to = *to}, table, "to");
}

std::optional<TimeFunction> read_spline(const TableReader& table) {
  auto points = read_points(table, "times", "values", " s");
  if (!points) return std::nullopt;
  return if_usable(SplineTable(std::move(points->x), std::move(points->y)), table, "values");
}

struct Law {
  std::string_view name;
  KnownKeys keys;
  std::optional<TimeFunction> (*read)(const TableReader&);
};

const std::array<Law, 5>& laws() {
  static const std::array<Law, 5> kLaws{
      Law{"constant_speed", {"law", "start", "speed"}, read_constant_speed},
      Law{"polynomial", {"law", "coefficients"}, read_polynomial},
      Law{"harmonic", {"law", "offset", "amplitude", "frequency", "phase"}, read_harmonic},
      Law{"smooth_step", {"law", "t0", "t1", "from", "to"}, read_smooth_step},
      Law{"spline", {"law", "times", "values"}, read_spline}};
  return kLaws;
}

}  // namespace

std::optional<TimeFunction> read_time_function(const toml::table& table, const std::string& title,
                                               FileReading& reading) {
  std::vector<std::string> names;
  KnownKeys all_keys;
  for (const Law& law : laws()) {
    names.emplace_back(law.name);
    all_keys.insert(all_keys.end(), law.keys.begin(), law.keys.end());
  }
  const toml::node* said = table.get("law");
  const auto name = said == nullptr ? std::nullopt : said->value_exact<std::string>();
  const auto law = std::find_if(laws().begin(), laws().end(), [&](const Law& one) { return name == one.name; });
  if (law != laws().end()) return law->read(TableReader(table, title, law->keys, reading));
  const TableReader unknown(table, title, all_keys, reading);
  if (unknown.require({"law"}) && unknown.text("law")) {
    unknown.complain("law", fmt::format("unknown law '{}': {}", *name, help_with_word(*name, names, "laws")));
  }
  return std::nullopt;
}

std::optional<TimeFunction> read_law_or_number(const TableReader& table, std::string_view key) {
  if (!table.has(key)) return std::nullopt;
  if (const toml::table* law = table.node(key)->as_table()) {
    return read_time_function(*law, fmt::format("{}, {}", table.title(), key), table.reading());
  }
  const auto text = table.node(key)->value_exact<std::string>();
  const bool names_a_law = std::any_of(laws().begin(), laws().end(), [&](const Law& law) { return text == law.name; });
  if (names_a_law) {
    table.complain(key,
                   fmt::format("the numbers of the law are missing: write {} = {{ law = \"{}\", ... }}", key, *text));
    return std::nullopt;
  }
  if (!table.node(key)->is_number() && !text) {
    table.complain(key, fmt::format("'{}' must be a number or a table such as {{ law = \"harmonic\", ... }}, found {}",
                                    key, type_name(*table.node(key))));
    return std::nullopt;
  }
  const auto value = table.number(key);
  if (!value) return std::nullopt;
  return ConstantSpeed{.start = *value, .speed = 0.0};
}

std::optional<Points> read_points(const TableReader& table, std::string_view x_key, std::string_view y_key,
                                  std::string_view unit) {
  constexpr std::size_t kFewest = 4;
  constexpr double kUnevenest = 1e9;
  if (!table.require({x_key, y_key})) return std::nullopt;
  auto x = table.numbers(x_key);
  auto y = table.numbers(y_key);
  if (!x || !y) return std::nullopt;
  if (x->size() < kFewest) {
    table.complain(x_key, fmt::format("a spline takes at least {} points, found {}", kFewest, x->size()));
    return std::nullopt;
  }
  if (x->size() != y->size()) {
    table.complain(y_key,
                   fmt::format("'{}' must be as many as '{}', {}, found {}", y_key, x_key, x->size(), y->size()));
    return std::nullopt;
  }
  const auto falls = std::adjacent_find(x->begin(), x->end(), std::greater_equal<>());
  if (falls != x->end()) {
    table.complain(
        x_key, fmt::format("'{0}' must rise, but after {1}{3} comes {2}{3}", x_key, *falls, *std::next(falls), unit));
    return std::nullopt;
  }
  double shortest = x->back() - x->front();
  double longest = 0.0;
  for (std::size_t k = 0; k + 1 < x->size(); ++k) {
    shortest = std::min(shortest, (*x)[k + 1] - (*x)[k]);
    longest = std::max(longest, (*x)[k + 1] - (*x)[k]);
  }
  if (longest > kUnevenest * shortest) {
    table.complain(x_key, fmt::format("'{0}' lie {1:.3g}{3} apart in one place and {2:.3g}{3} in another: a cubic "
                                      "spline resolves distances that differ by a factor of {4:g} at most",
                                      x_key, longest, shortest, unit, kUnevenest));
    return std::nullopt;
  }
  return Points{std::move(*x), std::move(*y)};
}

}  // namespace concord
