#include <gmock/gmock.h>

#include "common/reading/model_file.h"
#include "tests/second_reading/folder.h"
#include "tests/second_reading/second_reading.h"

namespace concord::second_reading {
namespace {

TEST(SecondReading, IsTheFirstOfEveryShippedModel) {
  const FolderReading found = read_folder_again(CONCORD_DATA);
  EXPECT_THAT(found.differing, ::testing::IsEmpty());
  EXPECT_THAT(found.not_held, ::testing::IsEmpty());
  EXPECT_GE(found.models, 50);
  EXPECT_GT(found.least_held, 50);
}

/// Those with planted faults have what no shipped model has: whoever misreads that is found here.
TEST(SecondReading, IsTheFirstOfTheMachinesOfTests) {
  for (const char* folder : {"faults", "verification/machines"}) {
    const FolderReading found = read_folder_again(std::filesystem::path(CONCORD_SOURCE) / "tests" / folder);
    EXPECT_THAT(found.differing, ::testing::IsEmpty());
    EXPECT_THAT(found.not_held, ::testing::IsEmpty());
    EXPECT_GE(found.models, 15) << folder;
  }
}

/// Cranks of a sweep of data/nightly.toml: dimensions that the file computes from parameters follow these.
TEST(SecondReading, IsTheFirstOfVariants) {
  const std::filesystem::path file = std::filesystem::path(CONCORD_DATA) / "models/slider_crank_rigid.toml";
  for (const double r : {0.05, 0.10, 0.20}) {
    for (const double L : {0.30, 0.45}) {
      const std::map<std::string, double> parameters{{"r", r}, {"L", L}};
      const SecondReading found = read_again(read_model(file, parameters), file, parameters);
      for (const StatedValue& value : found.differing) ADD_FAILURE() << r << ", " << L << ": " << describe(value, file);
    }
  }
}

TEST(SecondReading, SaysPlaceLineAndSize) {
  const StatedValue number{"body bob", "mass", 0.1, 2.5, "", 5};
  EXPECT_EQ(describe(number, "bob.toml"),
            "body bob, mass: was not read as bob.toml says in line 5: off by 1.00e-01, of 2.5");
  const StatedValue word{"joint A", "child", 1.0, 1.0, "read as 'B', stated 'A'", 0, "arm.toml"};
  EXPECT_EQ(describe(word, "bob.toml"), "joint A, child: was not read as arm.toml says: read as 'B', stated 'A'");
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
}  // namespace concord::second_reading
