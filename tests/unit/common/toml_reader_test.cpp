#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "common/reading/model_file.h"
#include "common/reading/modes_file.h"
#include "common/reading/text_file.h"
#include "common/reading/toml_document.h"

namespace concord {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string repeated(const std::string& part, int times) {
  std::string text;
  for (int k = 0; k < times; ++k) text += part;
  return text;
}

/// What is said of a document; "nothing" if it is read.
std::string said_of(const std::string& text) {
  try {
    (void)parse_toml(text, "m.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(ParseToml, RefusesWhatIsNestedTooDeepWhereItBecomesSo) {
  constexpr int kMany = 50000;
  const std::string reason = "nested deeper than 100 levels: no model needs that";
  EXPECT_EQ(said_of("b = 1\n" + repeated("a.", kMany) + "a = 1\n"), "m.toml:2:202: error: " + reason);
  EXPECT_EQ(said_of("[" + repeated("a . ", kMany) + "a]\n"), "m.toml:1:400: error: " + reason);
  EXPECT_THAT(said_of("[[" + repeated("a.", kMany) + "a]]\n"), HasSubstr(reason));
  EXPECT_THAT(said_of("a = " + repeated("[", kMany) + repeated("]", kMany)), HasSubstr(reason));
  EXPECT_THAT(said_of("a = " + repeated("{a = ", kMany) + "1" + repeated("}", kMany)), HasSubstr(reason));
  EXPECT_THAT(said_of("a = " + repeated("{a.b.c.d.e = [", 60) + "1" + repeated("]}", 60)), HasSubstr(reason));
  EXPECT_THAT(said_of("a = '" + repeated("[", kMany) + "'\nb = " + repeated("[", kMany)), HasSubstr("m.toml:2:"));
}

TEST(ParseToml, CountsNoLevelsInTextsAndComments) {
  const std::string many = repeated("[{a.", 200);
  EXPECT_EQ(said_of("# " + many + "\na = \"" + many + "\\\"" + many + "\"\nb = '" + many + "'\n"), "nothing");
  EXPECT_EQ(said_of("a = \"\"\"\n" + many + "\"\n" + many + "\"\"\"\"\nb = '''" + many + "\n''" + many + "'''\n"),
            "nothing");
  EXPECT_EQ(said_of("a = [" + repeated("0.5, ", 300) + "0.5]\nb = [" + repeated("{ x = 0.5 },\n", 300) + "]\n"),
            "nothing");
}

TEST(ParseToml, RefusesMoreValuesThanAnyModelNeeds) {
  const std::string text = "a = [" + repeated("1,", 4000001) + "1]";
  EXPECT_THAT(said_of(text), HasSubstr("more than 4000000 values in one file"));
}

/// A folder for one test.
class FilesToRead : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              fmt::format("concord_{}", testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string said_of_file(const fs::path& file) {
    try {
      (void)read_text_file(file);
    } catch (const InputError& error) {
      const std::string text = error.what();
      return text.substr(text.find(": error: ") + 9);
    }
    return "nothing";
  }

  fs::path folder_;
};

TEST_F(FilesToRead, AreRegularFilesAndNothingIsWaitedFor) {
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  const std::string expected = ", expected a regular file";
  EXPECT_EQ(said_of_file(folder_ / "fifo"), "cannot read the file: it is a fifo" + expected);
  EXPECT_EQ(said_of_file("/dev/zero"), "cannot read the file: it is a device" + expected);
  EXPECT_EQ(said_of_file(folder_), "cannot read the file: it is a folder" + expected);
  EXPECT_THROW((void)read_text_file(folder_ / std::string("a\0b", 3)), InputError);
  EXPECT_THROW((void)read_modes_file(folder_ / "fifo"), InputError);
  fs::create_symlink("/dev/zero", folder_ / "link");
  EXPECT_EQ(said_of_file(folder_ / "link"), "cannot read the file: it is a device" + expected);
}

TEST_F(FilesToRead, AreNotLongerThanTheLimit) {
  std::ofstream(folder_ / "long.toml") << "# ";
  fs::resize_file(folder_ / "long.toml", kMostBytes + 1);  // a hole: it takes no room on the disk
  EXPECT_EQ(said_of_file(folder_ / "long.toml"), "the file is longer than 64 MiB");
}

TEST_F(FilesToRead, AreToldAtTheKeyThatNamesThem) {
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  const auto said = [&](const std::string& text) {
    try {
      (void)parse_model(text, folder_ / "m.toml");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_THAT(said("format = 1\n[[include]]\nfile = \"fifo\"\n"),
              HasSubstr("m.toml:3:8: error: include: '" + (folder_ / "fifo").generic_string() +
                        "': cannot read the file: it is a fifo"));
  EXPECT_THAT(said("format = 1\n[[body]]\nname = \"b\"\nmodes_file = \"fifo\"\n"),
              HasSubstr("m.toml:4:14: error: body 'b': '" + (folder_ / "fifo").generic_string() +
                        "': cannot read the file: it is a fifo"));
  EXPECT_THAT(said("format = 1\n[[include]]\nfile = \"a\\u0000b\"\n"),
              HasSubstr("m.toml:3:8: error: include: there is"));
}

TEST_F(FilesToRead, MayIncludeEachOtherWithinLimitsOnly) {
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << "format = 1\n" << text;
  };
  const auto said = [&](const std::string& name) {
    try {
      (void)read_model(folder_ / name);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  for (int k = 0; k < 25; ++k) {  // 2^25 files
    const std::string next = fmt::format("twice{}.toml", k + 1);
    write(fmt::format("twice{}.toml", k), fmt::format("[[include]]\nfile = \"{0}\"\nprefix = \"a\"\n"
                                                      "[[include]]\nfile = \"{0}\"\nprefix = \"b\"\n",
                                                      next));
    write(fmt::format("deep{}.toml", k), fmt::format("[[include]]\nfile = \"deep{}.toml\"\n", k + 1));
  }
  for (int k = 25; k < 40; ++k)
    write(fmt::format("deep{}.toml", k), fmt::format("[[include]]\nfile = \"deep{}.toml\"\n", k + 1));
  write("twice25.toml", "");
  write("deep40.toml", "");
  EXPECT_THAT(said("twice0.toml"), HasSubstr("include: more than 1000 files are included in all\n  included from "));
  EXPECT_THAT(said("deep0.toml"),
              HasSubstr("deep29.toml:3:8: error: include: files include each other more than 30 deep"));
  EXPECT_THAT(said("deep12.toml"), Not(HasSubstr("more than")));
  write("long.toml", "# " + std::string(3U << 20U, 'x') + "\n");
  std::string five;
  for (int k = 0; k < 6; ++k) five += fmt::format("[[include]]\nfile = \"long.toml\"\nprefix = \"p{}\"\n", k);
  write("heavy.toml", five);
  EXPECT_THAT(said("heavy.toml"),
              HasSubstr("heavy.toml:18:8: error: include: the included files have more than 16 MiB in all"));
}

TEST(NumberIn, RoundsWholeNumbersThatDoublePrecisionDoesNotHold) {
  const toml::table table = toml::parse("a = 9246817297833421\nb = 7\nc = 0.5");
  EXPECT_EQ(number_in(*table.get("a")), 9246817297833420.0);
  EXPECT_EQ(number_in(*table.get("b")), 7.0);
  EXPECT_EQ(number_in(*table.get("c")), 0.5);
}

TEST(Complaints, EndWhenNobodyCanReadThemAll) {
  std::string text = "format = 1\n[parameters]\nx = 1\n[[body]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, 1]\n";
  for (int k = 0; k < 3000; ++k) text += fmt::format("unknown_{} = 1\n", k);
  try {
    (void)parse_model(text, "m.toml");
    FAIL() << "read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics().size(), 201U);
    EXPECT_THAT(error.what(), HasSubstr("too many errors: these are the first 200"));
  }
}

}  // namespace
}  // namespace concord
