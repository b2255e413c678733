#include <gmock/gmock.h>

#include <optional>

#include "common/error.h"
#include "common/reading/model_file.h"
#include "compare/reread/second_reading.h"

namespace concord::compare {
namespace {

std::optional<Model> model_in(const std::filesystem::path& file) {
  try {
    return read_model(file);
  } catch (const InputError&) {
    return {};  // a modes file, a suite or a part of a machine
  }
}

TEST(SecondReading, IsTheFirstOfEveryShippedModel) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(CONCORD_DATA)) {
    if (entry.path().extension() != ".toml") continue;
    const std::optional<Model> model = model_in(entry.path());
    if (!model) continue;
    ++count;
    const SecondReading found = read_again(*model, entry.path());
    for (const StatedValue& value : found.differing) {
      ADD_FAILURE() << entry.path() << ": " << value.where << ": " << value.key << " differs by " << value.residual
                    << " of " << value.scale << " " << value.text;
    }
    EXPECT_THAT(found.not_held, ::testing::IsEmpty()) << entry.path();
    EXPECT_GT(found.held, 50) << entry.path();
  }
  EXPECT_GE(count, 50);
}

TEST(SecondReading, TakesParametersThatWereGiven) {
  const std::filesystem::path file = std::filesystem::path(CONCORD_DATA) / "models/car.toml";
  const Model model = read_model(file, {{"bump_left", 0.04}});
  EXPECT_THAT(read_again(model, file, {{"bump_left", 0.04}}).differing, ::testing::IsEmpty());
  const SecondReading without = read_again(model, file);
  ASSERT_EQ(without.differing.size(), 2U);
  EXPECT_EQ(without.differing[0].key, "height");
  EXPECT_EQ(without.differing[0].where.substr(0, 9), "road fron");
}

}  // namespace
}  // namespace concord::compare
