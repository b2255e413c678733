#include "compare/nightly/case_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

namespace concord::compare::nightly {

namespace {

using Works = std::vector<Work>;

/// A key and the kinds of work that it means something to.
struct KeyOfWork {
  std::string_view key;
  Works works;
};

Works together(std::initializer_list<Works> parts) {
  Works all;
  for (const Works& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const std::vector<KeyOfWork>& keys_of_works() {
  static const Works any{Work::compare, Work::statics, Work::linearize, Work::kinematics,
                         Work::inverse, Work::joint,   Work::fuzz,      Work::invariance};
  static const Works wrenches{Work::compare, Work::statics, Work::linearize, Work::kinematics, Work::inverse};
  static const Works models = together({wrenches, {Work::invariance}});
  static const Works runs{Work::compare, Work::kinematics};
  static const std::vector<KeyOfWork> keys{
      {"name", any},
      {"work", any},
      {"seconds", any},
      {"megabytes", any},
      {"known_red", any},
      {"judge", any},
      {"models", models},
      {"except", models},
      {"parameters", models},
      {"cut", models},
      {"sweep", models},
      {"need", wrenches},
      {"until", together({runs, {Work::invariance}})},
      {"samples", runs},
      {"rtol", {Work::compare}},
      {"states", {Work::compare}},
      {"cartesian", {Work::compare}},
      {"relative", {Work::compare}},
      {"at", {Work::linearize}},
      {"accelerations", {Work::inverse}},
      {"joints", {Work::joint}},
      {"poses", {Work::joint}},
      {"seed", {Work::fuzz}},
      {"first", {Work::fuzz}},
      {"count", {Work::fuzz}},
      {"shares", {Work::fuzz}},
      {"style", {Work::fuzz}},
  };
  return keys;
}

bool is_for(const Works& works, Work work) { return std::find(works.begin(), works.end(), work) != works.end(); }

std::string words_of_refusal(std::string_view key, Work work, const Works& works) {
  std::vector<std::string> names;
  for (const Work one : works) names.push_back('"' + name_of(one) + '"');
  return fmt::format("'{}' means nothing to the work \"{}\", only to {}", key, name_of(work), fmt::join(names, ", "));
}

}  // namespace

KnownKeys case_keys() {
  KnownKeys keys;
  for (const KeyOfWork& one : keys_of_works()) keys.push_back(one.key);
  return keys;
}

void refuse_keys_without_meaning(const TableReader& table, Work work) {
  for (const auto& [key, works] : keys_of_works()) {
    if (table.has(key) && !is_for(works, work)) table.complain(key, words_of_refusal(key, work, works));
  }
  const toml::table* sweep = table.has("sweep") ? table.node("sweep")->as_table() : nullptr;
  if (sweep == nullptr || work == Work::compare) return;
  for (const std::string_view key : {"rtol", "integrators"}) {
    if (sweep->contains(key)) table.complain("sweep", words_of_refusal(key, work, {Work::compare}));
  }
}

}  // namespace concord::compare::nightly
