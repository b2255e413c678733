#pragma once

#include <string>
#include <vector>

/// The planted faults as catalogue.json states them.
namespace concord::faults {

struct Fault {
  int number = 0;  // in the catalogue: what the switch is set to
  std::string name;
  std::string file;     // that holds it
  std::string where;    // joint, coupling, force element or body that must be named; "-": a fault of the comparator, or
                        // of the machine
  std::string machine;  // the model that it is planted in
  std::string check;    // that was expected to catch it, before it was run; empty for the oldest ones
  std::string rule;     // of the audit, for faults that both solvers take from common

  [[nodiscard]] bool is_in(const std::string& folder) const { return file.starts_with(folder + "/"); }
};

/// All of them, in the order of their numbers. Throws what the JSON library throws if the file cannot be read.
std::vector<Fault> read_catalogue();

/// The number of the fault of that name; -1 if there is none.
int number_of(const std::vector<Fault>& faults, const std::string& name);

/// A fault of one solver, or of common, in which a fault of the comparator must show.
struct Standard {
  std::string fault;
  std::string machine;
};
const std::vector<Standard>& standard_faults();

/// Switches faults on for as long as it lives.
class Planting {
 public:
  explicit Planting(int fault, int second = -1);
  ~Planting();
  Planting(const Planting&) = delete;
  Planting& operator=(const Planting&) = delete;
};

}  // namespace concord::faults
