#pragma once

#include <map>
#include <string>

#include "compare/random_machines/machine.h"

namespace concord::compare::fuzz {

/// How often parts occur in machines: kind of part, its name, count.
class Coverage {
 public:
  void add(const Machine& machine);

  /// How many parts of a table ("tree", "cut", "reversed", "driven", "coupled", "sprung", "pairs", "bodies",
  /// "elements") and name there were.
  [[nodiscard]] long count(const std::string& table, const std::string& name) const;

  /// Joint types by role, types beside one another on a body, kinds of bodies, force elements.
  [[nodiscard]] std::string format() const;

 private:
  void add_joint(const JointPlan& joint, int outer_body);
  void add_pairs(const Machine& machine);

  std::map<std::string, std::map<std::string, long>> counts_;
};

}  // namespace concord::compare::fuzz
