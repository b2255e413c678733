#include "tests/faults/catalogue.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/faults/planted.h"

namespace concord::faults {

std::vector<Fault> read_catalogue() {
  std::ifstream file(CONCORD_FAULTS "/catalogue.json");
  std::vector<Fault> faults;
  for (const auto& said : nlohmann::json::parse(file)) {
    faults.push_back({static_cast<int>(faults.size()), said.at("name"), said.at("file"), said.at("joint"),
                      said.at("machine"), said.value("check", ""), said.value("rule", "")});
  }
  return faults;
}

int number_of(const std::vector<Fault>& faults, const std::string& name) {
  const auto found = std::find_if(faults.begin(), faults.end(), [&](const Fault& fault) { return fault.name == name; });
  return found == faults.end() ? -1 : found->number;
}

const std::vector<Standard>& standard_faults() {
  static const std::vector<Standard> kStandard{
      {"driver force left in the reaction", "machine_rigid"}, {"sign of the driver force", "machine_rigid"},
      {"mass off by a part in 1e10", "machine_need"},         {"reaction on ground not opposite", "machine_modes"},
      {"second derivative of a driver", "machine_rigid"},     {"soft part of a stop too weak", "machine_laws"},
      {"slip without its speed scale", "machine_tires"}};
  return kStandard;
}

Planting::Planting(int fault, int second) {
  planted = fault;
  accomplice = second;
}

Planting::~Planting() { planted = accomplice = -1; }

}  // namespace concord::faults
