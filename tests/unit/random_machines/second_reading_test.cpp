#include "tests/second_reading/second_reading.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/reading/model_file.h"
#include "compare/random_machines/generator.h"
#include "compare/random_machines/writer.h"
#include "tests/unit/second_reading/stated_machine.h"
#include "tests/unit/temporary_folder.h"

namespace concord::second_reading {
namespace {

using compare::fuzz::draw_machine;
using compare::fuzz::Style;
using compare::fuzz::write_machine;

constexpr std::uint64_t kSeed = 20261128;
constexpr std::uint64_t kMachines = 1000;

/// What is drawn has all joint types, laws, force elements and flexible bodies in combinations that no shipped model
/// has.
TEST(SecondReading, IsTheFirstOfAThousandDrawnMachines) {
  const compare::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  for (std::uint64_t number = 0; number < kMachines; ++number) {
    const auto style = static_cast<Style>(number % compare::fuzz::style_names().size());
    const compare::fuzz::ModelText text = write_machine(draw_machine(kSeed, number, style));
    for (const auto& [name, content] : text.beside) write_file(folder.path(), name, content);
    const std::filesystem::path file = folder.path() / "machine.toml";
    const Model model = parse_model(text.model, file);
    const SecondReading found = read_again_text(model, text.model, file);
    for (const StatedValue& value : found.differing) {
      ADD_FAILURE() << "machine " << number << ": " << describe(value, "machine.toml");
    }
    for (const std::string& one : found.not_held) ADD_FAILURE() << "machine " << number << ": not held: " << one;
    EXPECT_GT(found.held, 20) << number;
  }
}

}  // namespace
}  // namespace concord::second_reading
