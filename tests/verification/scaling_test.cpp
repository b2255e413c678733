#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "compare/audit/digits.h"
#include "compare/invariance/units.h"
#include "judged_machines.h"

/// No threshold has a unit: a machine a million times longer, heavier or slower, or smaller by as much, gets the same
/// verdict, with digits within one of those in the middle of all scales. Powers of two are exact, so that every digit
/// that is printed stays.
namespace concord::verification {
namespace {

using compare::invariance::told_in_units;
using compare::invariance::Units;

/// A machine of data/models, or with a folder of tests/verification/machines, and the run that is looked at [s].
struct Scaled {
  std::string folder;
  std::string name;
  double until;
};

/// Rigid, flexible, redundant; bushings, springs and stops, couplings, a skate, a rolling ball, tires, drivers, links.
const std::vector<Scaled> kScaled{
    {"", "slider_crank_spatial_rigid", 0.01},
    {"", "slider_crank_spatial_flexible", 0.002},
    {"", "slider_crank_redundant", 0.01},
    {"", "body_on_bushings", 0.05},
    {"", "planetary_differential", 0.05},
    {"", "chaplygin_sleigh", 0.2},
    {"", "ball_on_turntable", 0.1},
    {"", "suspension_two_rods", 0.05},
    {"", "motor_and_crossed_link", 0.03},
    {"textbook", "quarter_car", 0.4},
    {"textbook", "laval_rotor", 0.003},
    {"rare", "couplings_beyond_a_turn", 0.05},
    {"rare", "modes_file_and_free_free", 0.002},
};

Model model_of(const Scaled& machine) {
  if (!machine.folder.empty()) return machine_of(machine.folder, machine.name);
  return read_model(std::filesystem::path(CONCORD_DATA) / "models" / (machine.name + ".toml"));
}

/// Lengths, masses and times by a factor, each alone, then all of them; modes of flexible bodies keep unit modal mass.
std::vector<Units> scales(double factor) {
  std::vector<Units> scales{{factor, 1.0, 1.0}, {1.0, factor, 1.0}, {1.0, 1.0, factor}, {factor, factor, factor}};
  for (Units& units : scales) units.modal = std::sqrt(units.mass) * units.length;
  return scales;
}

std::string to_string(const Units& units) {
  return fmt::format("lengths x {:.3g}, masses x {:.3g}, times x {:.3g}", units.length, units.mass, units.time);
}

/// Few states and samples: the thresholds are passed all the same.
compare::Verdict verdict_in(const Scaled& machine, const Model& model, const Units& units) {
  compare::VerifyOptions options;
  options.until = machine.until * units.time;
  options.samples = 10;
  options.states = 16;
  return judged(told_in_units(model, units), options);
}

/// Beyond this the worst of some hundred differences is a few units of round-off, and differs from scale to scale.
constexpr double kRoundOff = 13.0;

/// Digits of the checks and of the audit; the most where a check judges nothing.
std::array<double, 4> digits_of(const compare::Verdict& verdict) {
  std::array<double, 4> digits{};
  std::size_t k = 0;
  for (const auto* check : {&verdict.same_state, &verdict.same_run, &verdict.refined, &verdict.audit}) {
    digits[k++] = check->digits.value_or(compare::kMostDigits);
  }
  return digits;
}

/// Set CONCORD_PRINT_DIGITS to see every machine in every scale.
void tell(const Scaled& machine, const Units& units, const compare::Verdict& verdict) {
  if (std::getenv("CONCORD_PRINT_DIGITS") == nullptr) return;
  const auto digits = digits_of(verdict);
  std::cout << fmt::format("{}, {}: {} {:.1f} / {:.1f} / {:.1f} / {:.1f}, {} of {}\n", machine.name, to_string(units),
                           compare::to_string(verdict.outcome), digits[0], digits[1], digits[2], digits[3],
                           verdict.judged, verdict.total)
            << std::flush;
}

/// Of each check the digits in the middle of all scales. In one scale alone they are one draw of round-off: a run at
/// rtol 1e-11 is known to 11.0 digits in one scale and to 12.1 in another, without any order in between.
std::array<double, 4> typical_digits(const std::vector<compare::Verdict>& verdicts) {
  std::array<double, 4> typical{};
  for (std::size_t check = 0; check < typical.size(); ++check) {
    std::vector<double> all;
    for (const compare::Verdict& verdict : verdicts) all.push_back(std::min(digits_of(verdict)[check], kRoundOff));
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    typical[check] = *middle;
  }
  return typical;
}

void expect_same_verdicts(const Scaled& machine, const Model& model, const compare::Verdict& first,
                          const std::vector<Units>& all_units) {
  std::vector<compare::Verdict> verdicts{first};
  for (const Units& units : all_units) {
    verdicts.push_back(verdict_in(machine, model, units));
    tell(machine, units, verdicts.back());
  }
  const std::array<double, 4> typical = typical_digits(verdicts);
  for (std::size_t k = 0; k < verdicts.size(); ++k) {
    const compare::Verdict& again = verdicts[k];
    const Units units = k == 0 ? Units{} : all_units[k - 1];
    INFO(machine.name << ", " << to_string(units) << '\n'
                      << compare::format_verdict(told_in_units(model, units), again, false));
    CHECK(again.outcome == first.outcome);
    CHECK(again.judged == first.judged);
    CHECK(again.total == first.total);
    const std::array<double, 4> found = digits_of(again);
    for (std::size_t check = 0; check < found.size(); ++check) {
      CAPTURE(check, typical[check]);
      CHECK(std::abs(std::min(found[check], kRoundOff) - typical[check]) <= 1.0);
    }
  }
}

/// Every number of the rows that has no unit.
std::string printed_digits(const compare::Verdict& verdict) {
  std::string text;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const auto& row : *rows) {
      text += fmt::format("{} {}", row.unique, compare::to_string(row.judgement));
      for (const auto& digits : {row.same_state, row.same_run, row.refined}) {
        text += digits ? " " + compare::format_digits(*digits) : " -";
      }
      for (const compare::CheckDetail& detail : row.detail) {
        text += detail.resolvable ? " of " + compare::format_digits(*detail.resolvable) : " of ?";
      }
      text += '\n';
    }
  }
  return text;
}

void expect_same_digits(const Scaled& machine, const Model& model, const compare::Verdict& first, const Units& units) {
  const compare::Verdict again = verdict_in(machine, model, units);
  tell(machine, units, again);
  INFO(machine.name << ", " << to_string(units));
  CHECK(again.outcome == first.outcome);
  CHECK(printed_digits(again) == printed_digits(first));
}

TEST_CASE("Over twelve decades of length, mass and time a machine keeps its verdict", "[scaling][nightly]") {
  const Scaled& machine = GENERATE(from_range(kScaled));
  DYNAMIC_SECTION(machine.name) {
    const Model model = model_of(machine);
    const compare::Verdict first = verdict_in(machine, model, {});
    tell(machine, {}, first);
    CHECK(first.outcome == compare::Outcome::agree);
    std::vector<Units> decades;
    for (const double factor : {1e-6, 1e-3, 1e3, 1e6}) {
      for (const Units& units : scales(factor)) decades.push_back(units);
    }
    expect_same_verdicts(machine, model, first, decades);
    for (const double factor : {0x1p-20, 0x1p20}) {
      for (const Units& units : scales(factor)) expect_same_digits(machine, model, first, units);
    }
  }
}

TEST_CASE("A machine a million times larger or smaller keeps its verdict", "[scaling]") {
  const Scaled& machine = GENERATE(from_range(kScaled));
  DYNAMIC_SECTION(machine.name) {
    const Model model = model_of(machine);
    const compare::Verdict first = verdict_in(machine, model, {});
    tell(machine, {}, first);
    CHECK(first.outcome == compare::Outcome::agree);
    expect_same_verdicts(machine, model, first, {{1e6, 1e-6, 1e6, 1e3}, {1e-6, 1e6, 1e-6, 1e-3}});
    expect_same_digits(machine, model, first, {0x1p20, 1.0, 1.0, 0x1p20});
    expect_same_digits(machine, model, first, {0x1p-20, 0x1p18, 0x1p16, 0x1p-11});
  }
}

}  // namespace
}  // namespace concord::verification
