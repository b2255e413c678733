#include "tests/second_reading/run_and_needs.h"

namespace concord::second_reading {

namespace {

template <class Number>
void hold_optional(const StatedTable& table, const std::string& key, const std::optional<Number>& read) {
  const auto stated = table.number(key);
  if (table.ledger().both_have(table.entry(key), read.has_value(), stated.has_value())) {
    table.ledger().number(table.entry(key), static_cast<double>(*read), *stated);
  }
}

void hold_run_without_table(const RunSettings& run, Ledger& ledger) {
  ledger.number({"run", "until"}, run.until, 1.0);
  ledger.both_have({"run", "rtol"}, run.rtol.has_value(), false);
  ledger.both_have({"run", "samples"}, run.samples.has_value(), false);
  ledger.word({"run", "start"}, run.from_equilibrium ? "equilibrium" : "given", "given");
}

}  // namespace

void hold_run(const RunSettings& run, const std::vector<const StatedFile*>& files) {
  bool is_held = false;
  for (const StatedFile* file : files) {
    const auto table = file->top->table("run");
    if (!table) continue;
    table->rename("run");
    if (is_held) table->pass_over();
    if (is_held) continue;
    is_held = true;
    table->hold_number("until", run.until, 1.0);
    hold_optional(*table, "rtol", run.rtol);
    hold_optional(*table, "samples", run.samples);
    table->hold_word("start", run.from_equilibrium ? "equilibrium" : "given", "given");
  }
  if (!is_held) hold_run_without_table(run, files.front()->top->ledger());
}

void hold_gravity(const Vec3& gravity, const std::vector<const StatedFile*>& files) {
  bool is_held = false;
  for (const StatedFile* file : files) {
    const auto stated = file->top->vector("gravity");
    if (!stated || is_held) continue;
    is_held = true;
    file->top->ledger().numbers({"gravity", "gravity", file->top->entry("gravity").line}, gravity, *stated);
  }
  if (!is_held) files.front()->top->ledger().numbers({"gravity", "gravity"}, gravity, Vec3(Vec3::Zero()));
}

void hold_need(const NeedOverride& need, const StatedTable& table) {
  Ledger& ledger = table.ledger();
  const auto hold_name = [&](const char* key, Names kind, const std::string& read) {
    ledger.word(table.entry(key), read, table.has(key) ? table.reference(kind, key) : "");
  };
  hold_name("joint", Names::joints, need.joint);
  hold_name("element", Names::elements, need.element);
  hold_name("body", Names::bodies, need.body);
  table.hold_word("component", need.component, "");
  hold_optional(table, "same_state", need.same_state);
  hold_optional(table, "same_run", need.same_run);
  hold_optional(table, "refined", need.refined);
  table.hold_word("because", need.because, "");
}

}  // namespace concord::second_reading
