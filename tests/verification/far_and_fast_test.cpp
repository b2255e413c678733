#include <catch2/catch.hpp>

#include "judged_machines.h"

/// Machines that drivers move faster than they are looked at, that stand far from the origin, or that travel far.
namespace concord::verification {
namespace {

// The work of drivers is integrated like the rest: a step as long as the time between two outputs, or a law that comes
// and goes between them, may not lose it.
TEST_CASE("Machines that motors move fast agree and keep their energy", "[fast]") {
  for (const std::string& name : machines_of("fast")) {
    DYNAMIC_SECTION(name) {
      const Model model = machine_of("fast", name);
      compare::VerifyOptions options;
      options.states = 40;
      expect_to_agree(model, options);
    }
  }
}

// Round-off of places grows with the distance from the origin. It limits what is resolved, and is no difference.
TEST_CASE("Machines far from the origin and on long ways agree", "[far]") {
  for (const std::string& name : machines_of("far")) {
    DYNAMIC_SECTION(name) {
      const Model model = machine_of("far", name);
      compare::VerifyOptions options;
      options.states = 40;
      expect_to_agree(model, options);
    }
  }
}

}  // namespace
}  // namespace concord::verification
