#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

/// Nights as their users meet them: killed in the middle, on a full disk, by two programs at once.
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A folder with a suite of short cases, and a shell in it.
class NightDesk {
 public:
  NightDesk() : folder_(fs::temp_directory_path() / ("concord_nightly_test_" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::copy_file(fs::path(CONCORD_DATA) / "models" / "double_pendulum_3d.toml", folder_ / "double.toml");
    std::ofstream(folder_ / "suite.toml") << "format = 1\n[[case]]\nname = \"double\"\nmodels = [\"double.toml\"]\n"
                                             "until = 0.05\nstates = 20\nsamples = 50\n[case.sweep]\n"
                                             "start = { seed = 5, count = 8, turn = 0.2, turn_speed = 0.3 }\n";
  }
  ~NightDesk() { fs::remove_all(folder_); }
  NightDesk(const NightDesk&) = delete;
  NightDesk& operator=(const NightDesk&) = delete;

  /// The exit code of a line of bash, in which $concord is the program.
  [[nodiscard]] int run(const std::string& line) const {
    std::ofstream(folder_ / "line.sh") << "concord='" CONCORD_PROGRAM "'\n" << line << "\n";
    const std::string command = "cd '" + folder_.string() + "' && bash line.sh > out 2> err";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  [[nodiscard]] const fs::path& path() const { return folder_; }
  [[nodiscard]] std::string out() const { return text_of(folder_ / "out"); }
  [[nodiscard]] std::string err() const { return text_of(folder_ / "err"); }
  [[nodiscard]] std::string file(const std::string& name) const { return text_of(folder_ / name); }

 private:
  fs::path folder_;
};

}  // namespace

TEST_CASE("A night that is killed goes on where it was", "[program][nightly_suite]") {
  const NightDesk desk;
  // Killed as soon as one case is stored, in the middle of the next.
  REQUIRE(desk.run("$concord nightly suite.toml --jobs 1 --history h.sqlite & night=$!\n"
                   "for k in $(seq 6000); do\n"
                   "  $concord history double/start=0 --history h.sqlite > /dev/null 2>&1 && break; sleep 0.01\n"
                   "done\n"
                   "kill -9 $night; wait $night; test $? = 137") == 0);
  CHECK(desk.run("$concord nightly suite.toml --jobs 1 --history h.sqlite --resume") == 4);
  INFO(desk.err());
  CHECK(holds(desk.err(), "night 1 goes on: "));
  CHECK_FALSE(holds(desk.err(), "goes on: 0 of 8"));
  CHECK(holds(desk.out(), "8 cases: 8 agree; 8 no baseline"));
  const std::string resumed = desk.out();
  REQUIRE(desk.run("$concord nightly suite.toml") == 4);
  CHECK(desk.out() == resumed);
}

TEST_CASE("A night whose history cannot grow is reported all the same, and can be resumed",
          "[program][nightly_suite]") {
  const NightDesk desk;
  CHECK(desk.run("ulimit -f 150; exec $concord nightly suite.toml --jobs 1 --history h.sqlite --json night.json "
                 "--junit night.xml --notify 'cat > mail'") == 3);
  for (const std::string& told : {desk.out(), desk.file("mail"), desk.file("night.json"), desk.file("night.xml")}) {
    INFO(told);
    CHECK(holds(told, "what was stored before stays; --resume goes on from there"));
  }
  CHECK(holds(desk.out(), "red suite: 8 cases: 8 agree"));
  CHECK(desk.run("$concord nightly suite.toml --history h.sqlite --resume") == 4);
  CHECK(holds(desk.err(), "night 1 goes on: "));
  CHECK_FALSE(holds(desk.err(), "goes on: 8 of 8"));
}

TEST_CASE("A night that a full disk ends loses nothing that was stored, and is told", "[program][nightly_suite]") {
  const NightDesk desk;
  CHECK(desk.run("ulimit -f 100; exec $concord nightly suite.toml --jobs 1 --history h.sqlite --notify 'cat > mail'") ==
        3);
  CHECK(holds(desk.err(), "the history h.sqlite cannot be used"));
  CHECK(holds(desk.file("mail"), "the history h.sqlite cannot be used"));
  CHECK(desk.run("$concord nightly suite.toml --history h.sqlite --resume") == 4);
  CHECK(holds(desk.err(), "night 1 goes on: "));
}

TEST_CASE("Two nights on one history do not harm each other", "[program][nightly_suite]") {
  const NightDesk desk;
  REQUIRE(desk.run("$concord nightly suite.toml --jobs 1 --history h.sqlite > one & first=$!\n"
                   "$concord nightly suite.toml --jobs 1 --history h.sqlite > two; second=$?\n"
                   "wait $first; test $? = 4 && test $second = 4 && cmp one two") == 0);
  CHECK(desk.run("$concord diff 1 2 --history h.sqlite") == 0);
  CHECK(desk.run("$concord accept suite.toml --history h.sqlite --reason 'a test' && $concord nightly suite.toml") ==
        0);
  CHECK(desk.run("$concord nightly none.toml") == 2);
}

TEST_CASE("A night sees an analysis whose numbers change their signs, or whose modes are damped otherwise",
          "[program][nightly_suite]") {
  const NightDesk desk;
  const auto bob = [&](double gravity, double damping) {
    std::ofstream(desk.path() / "bob.toml")
        << "format = 1\ngravity = [0, 0, " << gravity << "]\n[[body]]\nname = \"bob\"\nmass = 2\n"
        << "center_of_mass = [0.4, 0, 0]\ninertia = [0.1, 0.2, 0.3]\n"
        << "[[joint]]\nname = \"hinge\"\ntype = \"revolute\"\nparent = { body = \"ground\", x = [1, 0, 0], z = [0, 1, "
           "0] }\n"
        << "child = { body = \"bob\", x = [1, 0, 0], z = [0, 1, 0] }\nstart.turn_z = { keep = 0, keep_speed = 0 }\n"
        << "spring.turn_z = { stiffness = 30, damping = " << damping << " }\n";
  };
  std::ofstream(desk.path() / "analyses.toml")
      << "format = 1\n[[case]]\nname = \"rest\"\nwork = \"statics\"\nmodels = [\"bob.toml\"]\n"
      << "[[case]]\nname = \"modes\"\nwork = \"linearize\"\nat = \"equilibrium\"\nmodels = [\"bob.toml\"]\n";
  bob(-9.81, 0.3);
  REQUIRE(desk.run("$concord accept analyses.toml --reason first") == 0);
  CHECK(desk.run("$concord nightly analyses.toml") == 0);
  bob(9.81, 0.3);
  CHECK(desk.run("$concord nightly analyses.toml --only rest") == 4);  // changed: it is another model
  CHECK(holds(desk.out(), "19.62 | -19.62"));
  CHECK(holds(desk.out(), "| changed |"));
  bob(-9.81, 2.5);
  CHECK(desk.run("$concord nightly analyses.toml --only modes") == 4);  // changed: it is another model
  INFO(desk.out() << desk.err());
  CHECK(holds(desk.out(), "real part of eigenvalue 1"));
}
