#include "compare/random_machines/laws.h"

#include <fmt/format.h>

#include <cmath>

namespace concord::compare::fuzz {

namespace {

Entry number(const std::string& key, double value, bool needed = false) { return {key, number_text(value), needed}; }

LawPlan constant_speed(double start, double speed) {
  return {ConstantSpeed{start, speed},
          {{"law", "\"constant_speed\"", true}, number("start", start), number("speed", speed, true)}};
}

LawPlan polynomial(double start, double reach, double time, Random& random) {
  std::vector<double> coefficients{start};
  for (int k = 1; k <= 3; ++k) coefficients.push_back(random.between(-reach, reach) / std::pow(time, k));
  const VecX listed = Eigen::Map<const VecX>(coefficients.data(), static_cast<Eigen::Index>(coefficients.size()));
  return {Polynomial{coefficients}, {{"law", "\"polynomial\"", true}, {"coefficients", list_text(listed), true}}};
}

LawPlan harmonic(double offset, double amplitude, double time, Random& random) {
  const Harmonic law{offset, amplitude, random.between(0.5, 4.0) / time, random.between(-3.0, 3.0)};
  return {law,
          {{"law", "\"harmonic\"", true},
           number("offset", law.offset),
           number("amplitude", law.amplitude, true),
           number("frequency", law.frequency, true),
           number("phase", law.phase)}};
}

LawPlan smooth_step(double from, double reach, double time, Random& random) {
  const double t0 = time * random.between(-0.5, 0.1);
  const SmoothStep law{t0, t0 + time * random.between(0.5, 2.0), from, from + random.between(-reach, reach)};
  return {law,
          {{"law", "\"smooth_step\"", true},
           number("t0", law.t0, true),
           number("t1", law.t1, true),
           number("from", law.from, true),
           number("to", law.to, true)}};
}

LawPlan spline(double start, double reach, double time, Random& random) {
  constexpr int kPoints = 6;
  VecX times(kPoints);
  VecX values(kPoints);
  for (int k = 0; k < kPoints; ++k) {
    times(k) = time * (0.5 * (k - 1) + random.between(-0.1, 0.1));
    values(k) = start + random.between(-0.5 * reach, 0.5 * reach);
  }
  return {SplineTable({times.begin(), times.end()}, {values.begin(), values.end()}),
          {{"law", "\"spline\"", true}, {"times", list_text(times), true}, {"values", list_text(values), true}}};
}

std::string table_text(double reach, double force, Random& random) {
  constexpr int kPoints = 5;
  VecX x(kPoints);
  VecX forces(kPoints);
  for (int k = 0; k < kPoints; ++k) {
    x(k) = reach * (k - 2 + random.between(-0.2, 0.2));
    forces(k) = force * (0.4 * (k - 2) + random.between(-0.3, 0.3));
  }
  return fmt::format("{{ x = {}, force = {} }}", list_text(x), list_text(forces));
}

std::string stop_text(double at, double reach, double force, double time, Random& random) {
  Entries entries{number("at", at), number("stiffness", random.between(2.0, 20.0) * force / reach),
                  number("width", random.between(0.05, 0.3) * reach)};
  if (random.chance(0.5)) entries.push_back(number("damping", random.between(0.05, 0.5) * force * time / reach));
  return inline_text(entries);
}

}  // namespace

std::string inline_text(const Entries& entries) {
  std::string text = "{ ";
  for (std::size_t k = 0; k < entries.size(); ++k) {
    text += fmt::format("{}{} = {}", k > 0 ? ", " : "", entries[k].key, entries[k].value);
  }
  return text + " }";
}

LawPlan draw_law(double start, double reach, double time, Random& random) {
  switch (random.below(5)) {
    case 0:
      return constant_speed(start, random.between(-reach, reach) / time);
    case 1:
      return polynomial(start, 0.5 * reach, time, random);
    case 2:
      return harmonic(start, random.between(0.1, 0.4) * reach, time, random);
    case 3:
      return smooth_step(start, reach, time, random);
    default:
      return spline(start, 0.3 * reach, time, random);
  }
}

LawPlan draw_load_law(double size, double time, Random& random) {
  const double level = size * (random.chance(0.5) ? 1.0 : -1.0) * random.between(0.3, 1.0);
  return draw_law(level, 0.5 * size, time, random);
}

Entries draw_force_law(double x, double reach, double force, const Units& units, bool is_line, Random& random) {
  const double time = units.time;
  Entries entries;
  bool has_spring = false;
  if (random.chance(0.7)) {
    entries.push_back(number("stiffness", units.stiffer * random.log_between(0.3, 30.0) * force / reach));
    has_spring = true;
  }
  if (random.chance(0.5))
    entries.push_back(number("damping", units.damped * random.log_between(0.03, 1.0) * force * time / reach));
  if (random.chance(0.2)) {
    entries.push_back({"spring_table", table_text(reach, force, random)});
    has_spring = true;
  }
  if (random.chance(0.2)) entries.push_back({"damper_table", table_text(2.0 * reach / time, 0.3 * force, random)});
  if (random.chance(0.15)) {
    entries.push_back({"lower_stop", stop_text(x + reach * random.between(-0.5, -0.03), reach, force, time, random)});
  }
  if (random.chance(0.15)) {
    entries.push_back({"upper_stop", stop_text(x + reach * random.between(-0.02, 0.4), reach, force, time, random)});
  }
  if (random.chance(0.3)) {
    const std::string actuator = random.chance(0.3) ? number_text(random.between(-force, force))
                                                    : inline_text(draw_load_law(force, time, random).entries);
    entries.push_back({"actuator", actuator});
  }
  if (random.chance(0.2) || entries.empty()) entries.push_back(number("preload", random.between(-force, force)));
  const double free = x + reach / units.stiffer * random.between(-0.3, 0.3);
  if (has_spring) entries.push_back({"free", number_text(is_line ? std::abs(free) : free), is_line});
  return entries;
}

}  // namespace concord::compare::fuzz
