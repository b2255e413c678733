#include "tests/second_reading/second_reading.h"

#include <fmt/format.h>

#include <exception>
#include <functional>
#include <optional>
#include <set>

#include "tests/second_reading/bodies.h"
#include "tests/second_reading/joints.h"
#include "tests/second_reading/laws.h"
#include "tests/second_reading/run_and_needs.h"
#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

namespace {

using Files = std::vector<const StatedFile*>;

/// What a table says that cannot be read is told, and the rest of the file is held.
void guarded(Ledger& ledger, const std::string& where, const std::function<void()>& hold) {
  try {
    hold();
  } catch (const std::exception& error) {
    ledger.leave(where, error.what());
  }
}

template <class Item>
const Item* find_named(const std::vector<Item>& items, const std::string& name) {
  for (const Item& item : items) {
    if (item.name == name) return &item;
  }
  return nullptr;
}

/// Holds each table of a kind against the item of the model that has its name; gives their number.
template <class Item, class Hold>
int hold_named(const Files& files, const std::string& key, const std::string& kind, const std::vector<Item>& items,
               const Hold& hold) {
  int count = 0;
  for (const StatedFile* file : files) {
    for (const StatedTable& table : file->top->tables(key)) {
      ++count;
      const std::string name = table.own_name();
      table.rename(fmt::format("{} {}", kind, name));
      const Item* item = find_named(items, name);
      table.ledger().word(table.entry("name"), item != nullptr ? name : "", name);
      if (item == nullptr) table.pass_over();
      if (item != nullptr) guarded(table.ledger(), table.where(), [&] { hold(*item, table); });
    }
  }
  return count;
}

void hold_count(Ledger& ledger, const std::string& key, std::size_t read, int stated) {
  ledger.number({"model", key}, static_cast<double>(read), stated);
}

void hold_bodies(const Model& model, const Files& files, Ledger& ledger) {
  const int count = hold_named(files, "body", "body", model.bodies, hold_body);
  hold_count(ledger, "body", model.bodies.size(), count + 1);
  if (model.bodies.empty()) return;
  const Body& ground = model.bodies.front();
  ledger.word({"body ground", "name"}, ground.name, "ground");
  ledger.number({"body ground", "mass"}, ground.mass, 0.0);
  ledger.both_have({"body ground", "beam"}, ground.modal.has_value(), false);
}

void hold_joints(const Model& model, const Files& files, Ledger& ledger) {
  const int joints = hold_named(files, "joint", "joint", model.joints,
                                [&](const Joint& joint, const StatedTable& table) { hold_joint(model, joint, table); });
  hold_count(ledger, "joint", model.joints.size(), joints);
  const int couplings =
      hold_named(files, "coupling", "coupling", model.couplings,
                 [&](const Coupling& coupling, const StatedTable& table) { hold_coupling(model, coupling, table); });
  hold_count(ledger, "coupling", model.couplings.size(), couplings);
}

void hold_elements(const Model& model, const Files& files, Ledger& ledger) {
  int count = 0;
  for (const std::string kind : kElementTables) {
    count += hold_named(
        files, kind, "force", model.elements,
        [&](const ForceElement& element, const StatedTable& table) { hold_element(model, element, table, kind); });
  }
  hold_count(ledger, "force elements", model.elements.size(), count);
}

/// Roads stand in the model with the tires that roll on them; one without a tire is no part of it.
void hold_roads(const Model& model, const Files& files) {
  for (const StatedFile* file : files) {
    for (const StatedTable& table : file->top->tables("road")) {
      const std::string name = table.own_name();
      table.rename("road " + name);
      bool is_used = false;
      for (const ForceElement& element : model.elements) {
        const Tire* tire = std::get_if<Tire>(&element.what);
        if (tire == nullptr || !tire->road || tire->road->name != name) continue;
        is_used = true;
        guarded(table.ledger(), table.where(), [&] { hold_road(*tire->road, table); });
      }
      if (!is_used) table.pass_over();
    }
  }
}

void hold_needs(const Model& model, const Files& files, Ledger& ledger) {
  std::size_t next = 0;
  for (const StatedFile* file : files) {
    for (const StatedTable& table : file->top->tables("need")) {
      table.rename("need " + std::to_string(next + 1));
      if (next < model.needs.size()) {
        guarded(ledger, table.where(), [&] { hold_need(model.needs[next], table); });
      }
      ++next;
    }
  }
  hold_count(ledger, "need", model.needs.size(), static_cast<int>(next));
}

/// What stands at the top of each file: its number of the format; a name counts in the model file only.
void hold_top(const Model& model, const Files& files) {
  for (const StatedFile* file : files) {
    const StatedTable& top = *file->top;
    top.ledger().number(top.entry("format"), 1.0, top.number("format").value_or(0.0));
    const auto name = top.text("name");
    if (file == files.front()) top.ledger().word(top.entry("name"), model.name, name.value_or(file->path.stem()));
    if (const auto parameters = top.table("parameters")) parameters->pass_over();
  }
}

void hold_model(const Model& model, const StatedFile& root, Ledger& ledger) {
  const Files files = all_files(root);
  guarded(ledger, "model", [&] { hold_top(model, files); });
  guarded(ledger, "gravity", [&] { hold_gravity(model.gravity, files); });
  guarded(ledger, "model", [&] { hold_bodies(model, files, ledger); });
  guarded(ledger, "model", [&] { hold_joints(model, files, ledger); });
  guarded(ledger, "model", [&] { hold_elements(model, files, ledger); });
  guarded(ledger, "model", [&] { hold_roads(model, files); });
  guarded(ledger, "run", [&] { hold_run(model.run, files); });
  guarded(ledger, "model", [&] { hold_needs(model, files, ledger); });
}

using Opener = std::function<std::unique_ptr<StatedFile>(Ledger&)>;

SecondReading read_with(const Model& model, const Opener& open) {
  Ledger ledger;
  guarded(ledger, "model", [&] {
    const std::unique_ptr<StatedFile> root = open(ledger);
    hold_model(model, *root, ledger);
  });
  return std::move(ledger).result();
}

}  // namespace

std::string describe(const StatedValue& value, const std::string& file) {
  const std::string line = value.line > 0 ? fmt::format(" in line {}", value.line) : "";
  const std::string how =
      value.text.empty() ? fmt::format("off by {:.2e}, of {:.3g}", value.residual, value.scale) : value.text;
  return fmt::format("{}, {}: was not read as {} says{}: {}", value.where, value.key,
                     value.file.empty() ? file : value.file, line, how);
}

SecondReading read_again(const Model& model, const std::filesystem::path& file,
                         const std::map<std::string, double>& parameters) {
  return read_with(model, [&](Ledger& ledger) { return open_model(file, parameters, ledger); });
}

SecondReading read_again_text(const Model& model, std::string_view text, const std::filesystem::path& file) {
  return read_with(model, [&](Ledger& ledger) { return open_model_text(text, file, ledger); });
}

}  // namespace concord::second_reading
