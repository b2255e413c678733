#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "../unit/common/broken_models.h"

/// The program as its users meet it: exit codes, what it prints, what it writes, what it leaves behind.
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using concord::BrokenModel;

const fs::path kModels = fs::path(CONCORD_DATA) / "models";

std::string read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

struct Told {
  int code = -1;
  std::string out;
  std::string err;
};

/// A folder of its own for each test, and the program run in it.
class Desk {
 public:
  Desk() : folder_(fs::temp_directory_path() / ("concord_program_test_" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "work");
  }
  ~Desk() { fs::remove_all(folder_); }
  Desk(const Desk&) = delete;
  Desk& operator=(const Desk&) = delete;

  [[nodiscard]] fs::path work() const { return folder_ / "work"; }

  Told run(const std::string& arguments) const {
    const std::string command = "cd '" + work().string() + "' && exec '" CONCORD_PROGRAM "' " + arguments + " > '" +
                                (folder_ / "out").string() + "' 2> '" + (folder_ / "err").string() + "'";
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), read(folder_ / "out"), read(folder_ / "err")};
  }

  /// A line of the shell in the working folder, with the program as $concord; what it prints is not kept.
  [[nodiscard]] int shell(const std::string& line) const {
    const std::string command = "cd '" + work().string() + "' && concord='" CONCORD_PROGRAM "' && { " + line +
                                "; } 2> '" + (folder_ / "err").string() + "'";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  [[nodiscard]] std::string errors() const { return read(folder_ / "err"); }

  /// Starts the program, waits until `sign` is there and a little longer, and sends a signal.
  Told interrupted(const std::vector<std::string>& arguments, const std::string& sign, int signal) const {
    const pid_t child = fork();
    if (child == 0) {
      chdir_or_die(work());
      std::signal(signal, SIG_DFL);  // nohup ignores one of them, and so does what it starts
      redirect(folder_ / "out", STDOUT_FILENO);
      redirect(folder_ / "err", STDERR_FILENO);
      std::vector<char*> argv{const_cast<char*>(CONCORD_PROGRAM)};
      for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
      argv.push_back(nullptr);
      execv(CONCORD_PROGRAM, argv.data());
      _exit(127);
    }
    const auto pause = std::chrono::milliseconds(50);
    for (int k = 0; k < 1200 && !fs::exists(work() / sign); ++k) std::this_thread::sleep_for(pause);
    std::this_thread::sleep_for(4 * pause);
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(folder_ / "out"), read(folder_ / "err")};
  }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(work() / name) << text;
    return work() / name;
  }

  /// Names of all that lies in the working folder and below.
  [[nodiscard]] std::vector<std::string> left_behind() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(work())) {
      names.push_back(fs::relative(entry.path(), work()).string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  static void chdir_or_die(const fs::path& folder) {
    if (chdir(folder.c_str()) != 0) _exit(126);
  }
  static void redirect(const fs::path& file, int stream) {
    const int opened = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (opened < 0 || dup2(opened, stream) < 0) _exit(126);
  }

  fs::path folder_;
};

std::string model(const std::string& name) { return "'" + (kModels / (name + ".toml")).string() + "'"; }

const std::string kPendulum = R"(format = 1
gravity = [0.3, -9.81, 0.2]

[[body]]
name = "bob"
mass = 1.3
center_of_mass = [0.2, 0.1, -0.05]
inertia = [0.02, 0.03, 0.04]

[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "bob"
start.turn_z = { keep = 0.4, keep_speed = 2 }

[run]
until = 0.3
)";

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

/// The bytes of a JSON document without the only numbers that may change from run to run.
std::string without_wall_times(const std::string& text) {
  REQUIRE(contains(text, "\"wall_s\": "));
  return std::regex_replace(text, std::regex("\"wall_s\": [^,]*,"), "");
}

}  // namespace

TEST_CASE("Agreement is exit 0, with a table and a JSON document", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  const Told told = desk.run("compare pendulum.toml --json verdict.json");
  INFO(told.out << told.err);
  REQUIRE(told.code == 0);
  CHECK(contains(told.out, "| joint | on     | peak F [N] | at t [s] |"));
  CHECK(contains(told.out, "\nagree pendulum: 10 of 10 components judged; passed: rank, same state"));
  const Json json = Json::parse(read(desk.work() / "verdict.json"));
  CHECK(keys(json) == std::vector<std::string>{"format", "name", "verdict", "judged", "total", "same_state", "same_run",
                                               "refined", "audit", "joints", "solvers", "forces", "start"});
  CHECK(json["verdict"] == "agree");
  CHECK(json["judged"] == json["total"]);
  CHECK(json["joints"].size() == json["total"]);
  CHECK(json["solvers"]["cartesian"]["wall_s"].get<double>() > 0.0);
}

TEST_CASE("A difference is exit 1 and says where", "[program]") {
  const Desk desk;
  // The reference is another machine: its gravity is stronger by a thousandth.
  const std::string text = read(kModels / "slider_crank_flexible_free.toml");
  const std::string gravity = "gravity = [0, -9.81, 0]";
  REQUIRE(contains(text, gravity));
  std::string other = text;
  other.replace(other.find(gravity), gravity.size(), "gravity = [0, -9.82, 0]");
  desk.write("machine.toml", text);
  desk.write("other.toml", other);
  REQUIRE(desk.run("run other.toml --solver cartesian --until 0.03 --out other").code == 0);
  desk.write("reference.csv", "# error = 0.001 %\n" + read(desk.work() / "other" / "other.cartesian.reactions.csv"));
  const Told told = desk.run("compare machine.toml --until 0.03 --json verdict.json --reference reference.csv");
  CHECK(told.code == 1);
  CHECK(contains(told.out, "joint D on ground"));
  CHECK(Json::parse(read(desk.work() / "verdict.json"))["verdict"] == "differ");
}

TEST_CASE("A machine in which nothing can be judged is exit 3, never 0", "[program]") {
  const Desk desk;
  std::string text = kPendulum;
  text.replace(text.find("\"revolute\""), 10, "\"free\"");
  text.replace(text.find("start.turn_z"), text.find("\n[run]") - text.find("start.turn_z"), R"(
start.slide_x = { keep = 0, keep_speed = 1 }
start.slide_y = { keep = 0, keep_speed = 2 }
start.slide_z = { keep = 0, keep_speed = 3 }
start.ball = { keep = { x = [1, 0, 0], z = [0, 0, 1] }, keep_speed = [1, 2, 3] }
)");
  desk.write("thrown.toml", text);
  const Told told = desk.run("compare thrown.toml --json verdict.json");
  INFO(told.out << told.err);
  CHECK(told.code == 3);
  CHECK(contains(told.out, "no component was judged"));
  CHECK(Json::parse(read(desk.work() / "verdict.json"))["verdict"] == "failed");
}

TEST_CASE("Bad input is exit 2, at its line, and leaves nothing behind", "[program]") {
  const std::vector<std::pair<std::string, std::string>> cases{
      {kPendulum + "colour = 3\n", "bad.toml:19:1: error: run: unknown key"},
      {"format = 1\n[[body]\n", "bad.toml:2:"},
      {kPendulum + "\n[[need]]\njoint = \"hinge\"\nsame_state = 3\n", "say why with because"},
      {"format = 1\n[[body]]\nname = \"b\"\nmass = -1\ninertia = [1, 1, 1]\n[[joint]]\nname = \"j\"\ntype = "
       "\"weld\"\nparent = \"ground\"\nchild = \"b\"\n",
       "bad.toml:4:"},
  };
  for (const auto& [text, message] : cases) {
    const Desk desk;
    desk.write("bad.toml", text);
    for (const char* command : {"compare bad.toml --out results --json verdict.json",
                                "run bad.toml --solver relative --out results", "info bad.toml"}) {
      const Told told = desk.run(command);
      INFO(command << '\n' << text << '\n' << told.out << told.err);
      if (contains(message, "because") && !contains(command, "compare")) continue;
      CHECK(told.code == 2);
      CHECK(told.out.empty());
      CHECK(contains(told.err, message));
      CHECK(desk.left_behind() == std::vector<std::string>{"bad.toml"});
    }
  }
}

TEST_CASE("Every broken model is refused word by word by compare, run and info, and nothing is left behind",
          "[program]") {
  for (const BrokenModel& broken : concord::broken_models()) {
    const Desk desk;
    desk.write("bad.toml", broken.text());
    const std::string expected = broken.message("bad.toml") + '\n';
    for (const char* command : {"compare bad.toml --out results --json verdict.json",
                                "run bad.toml --solver relative --out results", "info bad.toml"}) {
      const Told told = desk.run(command);
      INFO(broken.name << ": " << command);
      CHECK(told.code == 2);
      CHECK(told.out.empty());
      CHECK(told.err == expected);
      CHECK(desk.left_behind() == std::vector<std::string>{"bad.toml"});
    }
  }
}

TEST_CASE("A command line that cannot be is exit 2", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  for (const char* arguments :
       {"", "compare", "frobnicate", "compare pendulum.toml --wrong", "compare absent.toml",
        "compare pendulum.toml --until -1", "compare pendulum.toml --samples 0", "run pendulum.toml --integrator gauss",
        "compare pendulum.toml --until nan --out r", "run pendulum.toml --solver cartesian --until nan --out r",
        "run pendulum.toml --solver relative --until inf", "compare pendulum.toml --rtol nan --json v.json",
        "run pendulum.toml --solver third", "run pendulum.toml --solver relative --integrator euler",
        "compare pendulum.toml --cartesian-integrator euler", "compare pendulum.toml --json pendulum.toml/below.json",
        "compare pendulum.toml --json ''", "info ''", "run pendulum.toml --solver relative --out ''"}) {
    const Told told = desk.run(arguments);
    INFO(arguments << '\n' << told.out << told.err);
    CHECK(told.code == 2);
    CHECK_FALSE(told.err.empty());
    CHECK(desk.left_behind() == std::vector<std::string>{"pendulum.toml"});
  }
}

TEST_CASE("Help and version are exit 0", "[program]") {
  const Desk desk;
  CHECK(desk.run("--help").code == 0);
  CHECK(contains(
      desk.run("--help").out,
      "Exit codes: 0 agree, 1 differ, 2 bad input, 3 could not finish, 4 a baseline is missing or of another model."));
  CHECK(contains(desk.run("compare --help").out, "--samples"));
  CHECK(contains(desk.run("--version").out, "concord "));
}

TEST_CASE("Everything but wall times is the same from run to run", "[program]") {
  const Desk desk;
  const std::string arguments = GENERATE("compare " + model("slider_crank_rigid") + " --until 0.2 --all --out ",
                                         "compare " + model("slider_crank_spatial_flexible") + " --until 0.01 --out ");
  const Told first = desk.run(arguments + "one --json one.json");
  const Told second = desk.run(arguments + "two --json two.json");
  REQUIRE(first.code == 0);
  CHECK(first.out == second.out);
  CHECK(contains(first.err, "wall time"));
  CHECK(without_wall_times(read(desk.work() / "one.json")) == without_wall_times(read(desk.work() / "two.json")));
  int files = 0;
  for (const auto& entry : fs::directory_iterator(desk.work() / "one")) {
    INFO(entry.path());
    CHECK(read(entry.path()) == read(desk.work() / "two" / entry.path().filename()));
    ++files;
  }
  CHECK(files >= 7);
}

TEST_CASE("The table is the same on one processor as on all", "[program]") {
  const Desk desk;
  const std::string arguments = "compare --all " + model("slider_crank_rigid_free") + " --until 0.1";
  const Told on_all = desk.run(arguments);
  CHECK(on_all.code == 0);
  cpu_set_t all;
  REQUIRE(sched_getaffinity(0, sizeof all, &all) == 0);
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int k = 0; CPU_COUNT(&one) == 0; ++k) {
    if (CPU_ISSET(k, &all)) CPU_SET(k, &one);
  }
  REQUIRE(sched_setaffinity(0, sizeof one, &one) == 0);
  const Told on_one = desk.run(arguments);
  REQUIRE(sched_setaffinity(0, sizeof all, &all) == 0);
  CHECK(on_one.out == on_all.out);
}

TEST_CASE("Without runs states are judged, the last line says so, and options of runs are refused", "[program]") {
  const Desk desk;
  const std::string judged = "; passed: rank, same state [0-9.]+, audit [0-9.]+\n$";
  const Told told = desk.run("compare --same-state " + model("slider_crank_flexible"));
  CHECK(told.code == 0);
  CHECK(contains(told.out, "\n  no run: the start, a short step from it, and states drawn near these\n"));
  CHECK(contains(told.out, "\nstates handed to both: 54, of which 50 perturbed"));
  CHECK(std::regex_search(told.out, std::regex("\nagree slider_crank_flexible: 36 of 36 components judged" + judged)));
  CHECK(told.err.empty());
  for (const std::string option : {"--until 1", "--rtol 1e-9", "--orders", "--out results"}) {
    INFO(option);
    const Told refused = desk.run("compare --same-state " + option + " " + model("slider_crank_rigid"));
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "--same-state excludes " + option.substr(0, option.find(' '))));
  }
}

TEST_CASE("Results hold the rows that were asked for", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  REQUIRE(desk.run("compare pendulum.toml --samples 30 --out results").code == 0);
  for (const char* file : {"pendulum.cartesian.reactions.csv", "pendulum.relative.motion.csv"}) {
    const std::string text = read(desk.work() / "results" / file);
    CHECK(std::count(text.begin(), text.end(), '\n') == 32);
  }
  CHECK(fs::exists(desk.work() / "results" / "pendulum.table.txt"));
  CHECK(fs::exists(desk.work() / "results" / "pendulum.cartesian.nc"));
}

TEST_CASE("Results of an earlier comparison do not stand beside the table of one that failed", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  REQUIRE(desk.run("compare pendulum.toml --out results").code == 0);
  REQUIRE(fs::exists(desk.work() / "results" / "pendulum.cartesian.nc"));
  std::string turning = kPendulum;  // past what a bushing reads
  turning.replace(turning.find("[0.3, -9.81, 0.2]"), 17, "[0, 0, 0]");
  turning.replace(turning.find("until = 0.3"), 11, "until = 3");
  turning +=
      "[[bushing]]\nname = \"torsion\"\nparent = \"ground\"\nchild = \"bob\"\nstiffness = [0, 0, 0, 0.001, 0.001, "
      "0.001]\n";
  desk.write("pendulum.toml", turning);
  desk.write("results/note.txt", "kept");
  const Told told = desk.run("compare pendulum.toml --out results");
  INFO(told.out << told.err);
  CHECK(told.code == 3);
  CHECK(contains(told.out, "is turned by 175"));
  CHECK(contains(read(desk.work() / "results" / "pendulum.table.txt"), "failed pendulum"));
  CHECK(desk.left_behind() == std::vector<std::string>{"pendulum.toml", "results", "results/note.txt",
                                                       "results/pendulum.result.json", "results/pendulum.table.txt"});
}

TEST_CASE("Several models: the summary survives a failing one, the exit code is the worst", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  desk.write("second.toml", kPendulum);
  desk.write("bad.toml", "format = 2\n");
  const Told told = desk.run("compare pendulum.toml bad.toml second.toml --json all.json");
  INFO(told.out << told.err);
  CHECK(told.code == 2);
  CHECK(contains(told.out, "| model    |"));
  CHECK(contains(told.out, "| bad      |"));
  CHECK(contains(told.out, "| bad input |"));
  CHECK(contains(told.out, "agree second: "));
  const Json all = Json::parse(read(desk.work() / "all.json"));
  CHECK(keys(all) == std::vector<std::string>{"pendulum", "bad", "second"});
  CHECK(all["bad"]["verdict"] == "bad input");
  CHECK(contains(all["bad"]["failures"][0].get<std::string>(), "bad.toml:1:1: error: "));
}

TEST_CASE("run and info do what they say", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  const Told run = desk.run("run pendulum.toml --solver cartesian --out results");
  INFO(run.out << run.err);
  CHECK(run.code == 0);
  CHECK(contains(run.out, "| hinge | bob    |"));
  CHECK(fs::exists(desk.work() / "results" / "pendulum.cartesian.nc"));
  CHECK_FALSE(fs::exists(desk.work() / "results" / "pendulum.relative.nc"));
  const Told info = desk.run("info " + model("slider_crank_redundant"));
  CHECK(info.code == 0);
  CHECK(contains(info.out, "cartesian: 20 constraints of rank 17"));
  CHECK(contains(info.out,
                 "across the plane of the loops, normal (0, 0, 1): forces along it and torques about axes in the "
                 "plane in joints A, B, C, D"));
}

TEST_CASE("What analyses write marks what of it is not unique", "[program]") {
  const Desk desk;
  const std::string command = GENERATE("statics", "linearize", "inverse");
  const Told told = desk.run(command + " " + model("slider_crank_redundant") + " --out results");
  INFO(command << told.out << told.err);
  CHECK(told.code == 0);
  for (const char* solver : {"cartesian", "relative"}) {
    const std::string name = std::string("slider_crank_redundant.") + solver + ".reactions.csv";
    const std::string text = read(desk.work() / "results" / name);
    CHECK(contains(text, "# not unique in 1 of 1 samples: "));
    CHECK(contains(text.substr(0, text.find('\n')), "A.child.F_z"));
  }
}

TEST_CASE("Places that are no regular file are refused before any work and stay what they are", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  desk.write("whole.toml",
             "format = 1\n[[include]]\nfile = \"pendulum.toml\"\n[[body]]\nname = \"bar\"\n"
             "modes_file = \"bar.modes.toml\"\n");
  desk.write("bar.modes.toml", "format = 1\n");
  desk.write("kept.json", "{}");
  fs::create_symlink("kept.json", desk.work() / "link.json");
  REQUIRE(mkfifo((desk.work() / "fifo").c_str(), 0600) == 0);
  const auto before = desk.left_behind();
  for (const char* command :
       {"compare pendulum.toml --json /dev/null", "compare pendulum.toml --junit /dev/full",
        "compare pendulum.toml --json fifo", "compare pendulum.toml --json link.json",
        "compare pendulum.toml --junit .", "compare pendulum.toml --json pendulum.toml",
        "compare pendulum.toml --json no/../pendulum.toml", "compare whole.toml --json pendulum.toml",
        "compare whole.toml --junit bar.modes.toml", "statics whole.toml --json ./pendulum.toml",
        "compare pendulum.toml --out fifo", "compare pendulum.toml --out /dev/null",
        "compare pendulum.toml --out kept.json", "run pendulum.toml --solver relative --out kept.json/below",
        "statics pendulum.toml --json fifo", "kinematics pendulum.toml --out /dev/null",
        "joint weld --poses 1 --out fifo"}) {
    const Told told = desk.run(command);
    INFO(command << '\n' << told.out << told.err);
    CHECK(told.code == 2);
    CHECK(told.out.empty());
    CHECK(contains(told.err, "error: cannot be written: "));
    CHECK(desk.left_behind() == before);
  }
  CHECK(fs::is_character_file("/dev/null"));
  CHECK(fs::is_symlink(desk.work() / "link.json"));
  CHECK(read(desk.work() / "pendulum.toml") == kPendulum);
}

TEST_CASE("Models, parts and references that are no regular file are refused without waiting", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  REQUIRE(mkfifo((desk.work() / "fifo").c_str(), 0600) == 0);
  desk.write("part.toml", kPendulum + "\n[[include]]\nfile = \"fifo\"\n");
  desk.write("modes.toml", kPendulum + "\n[[body]]\nname = \"flex\"\nmodes_file = \"fifo\"\n");
  for (const char* command :
       {"info fifo", "info /dev/zero", "info .", "compare part.toml", "info modes.toml",
        "compare pendulum.toml --reference fifo", "compare pendulum.toml --reference /dev/zero"}) {
    const Told told = desk.run(command);
    INFO(command << '\n' << told.out << told.err);
    CHECK(told.code == 2);
    CHECK(contains(told.err, "expected a regular file"));
  }
}

TEST_CASE("A full disk, a closed pipe and a closed stream are exit 3 with a word", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  for (const char* line :
       {"\"$concord\" info pendulum.toml > /dev/full", "\"$concord\" --help > /dev/full",
        "\"$concord\" run pendulum.toml --solver relative > /dev/full", "\"$concord\" info pendulum.toml >&-",
        "{ \"$concord\" compare pendulum.toml; echo $? > code; } | sleep 0; exit $(cat code)"}) {
    INFO(line);
    CHECK(desk.shell(line) == 3);
    CHECK(contains(desk.errors(), "could not finish: the standard output cannot be written"));
  }
}

TEST_CASE("A file that grows beyond a limit is told, and leaves nothing half", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  const int kibibytes = GENERATE(1, 12, 24, 40);
  CHECK(desk.shell(
            fmt::format("ulimit -f {}; \"$concord\" compare pendulum.toml --out results > /dev/null", kibibytes)) == 3);
  CHECK(contains(desk.errors(), "could not finish: "));
  CHECK(contains(desk.errors(), "cannot be written: File too large"));
  for (const std::string& left : desk.left_behind()) CHECK_FALSE(contains(left, "unfinished"));
}

TEST_CASE("What a run writes beside a comparison removes what that said", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  REQUIRE(desk.run("compare pendulum.toml --out results").code == 0);
  REQUIRE(fs::exists(desk.work() / "results" / "pendulum.result.json"));
  CHECK(desk.run("run pendulum.toml --solver cartesian --samples 7 --out results").code == 0);
  CHECK(fs::exists(desk.work() / "results" / "pendulum.cartesian.nc"));
  for (const char* ending : {"result.json", "table.txt", "reaction_hinge.svg"}) {
    CHECK_FALSE(fs::exists(desk.work() / "results" / (std::string("pendulum.") + ending)));
  }
}

TEST_CASE("An interrupted comparison says what was finished and leaves nothing half", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  desk.write("endless.toml", std::regex_replace(kPendulum, std::regex("until = 0.3"), "until = 1e7"));
  desk.write("verdict.json", "of an earlier run");
  const auto [signal, name] =
      GENERATE(table<int, std::string>({{SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}}));
  const Told told =
      desk.interrupted({"compare", "pendulum.toml", "endless.toml", "--out", "results", "--json", "verdict.json"},
                       "results/pendulum.table.txt", signal);
  INFO(told.out << told.err);
  CHECK(told.code == 128 + signal);
  CHECK(contains(told.err, "interrupted by " + name + ": finished: pendulum; "));
  CHECK_FALSE(fs::exists(desk.work() / "verdict.json"));
  CHECK(fs::exists(desk.work() / "results" / "pendulum.relative.nc"));
  for (const std::string& file : desk.left_behind()) {
    CHECK_FALSE(contains(file, "unfinished"));
    CHECK_FALSE(contains(file, "endless.c"));
  }
}

TEST_CASE("One program has every command, and says one sentence about it in both helps", "[program]") {
  const Desk desk;
  const Told overview = desk.run("--help");
  for (const std::string name : {"statics", "linearize", "kinematics", "inverse", "joint", "invariance", "fuzz",
                                 "nightly", "accept", "history", "diff", "report"}) {
    const Told help = desk.run(name + " --help");
    INFO(name << ": " << help.err);
    CHECK(help.code == 0);
    CHECK(contains(help.out, "Usage: concord " + name));
    CHECK(contains(overview.out, help.out.substr(0, help.out.find('\n'))));
  }
  fs::copy_file(CONCORD_PROGRAM, desk.work() / "concord");
  CHECK(desk.shell("./concord fuzz --count 1 --jobs 1") == 0);  // alone in a folder
  CHECK(desk.run("fuzz --count nothing").code == 2);
}

TEST_CASE("Completion knows the commands and their options, and leaves files to the shell", "[program]") {
  const Desk desk;
  const fs::path script = fs::path(CONCORD_DATA) / "../compare/program/completion.bash";
  desk.write("try.bash", "source '" + script.string() + R"('
ask() { COMP_WORDS=(")" CONCORD_PROGRAM R"(" "$@"); COMP_CWORD=$#; _concord; echo "${COMPREPLY[*]}"; }
ask stat > told; ask compare --ref >> told; ask run --so >> told; ask compare car >> told
)");
  CHECK(desk.shell("bash try.bash") == 0);
  CHECK(read(desk.work() / "told") == "statics\n--reference\n--solver\n\n");
}

TEST_CASE("An interrupted fuzz says how many machines it has tried", "[program]") {
  const Desk desk;
  std::string told;
  for (const char* seconds : {"3", "12", "48"}) {  // a busy computer may need longer for its first machines
    const int code = desk.shell(std::string("timeout --signal=TERM --preserve-status ") + seconds +
                                " \"$concord\" fuzz --count 1000000 --jobs 1 > /dev/null 2> told.txt");
    CHECK(code == 143);
    told = read(desk.work() / "told.txt");
    if (!contains(told, "nothing was finished")) break;
  }
  INFO(told);
  CHECK(
      std::regex_search(told, std::regex("interrupted by SIGTERM: [1-9][0-9]* machines were tried, 0 ended wrongly")));
}

TEST_CASE("Two comparisons that write the same results leave whole files", "[program]") {
  const Desk desk;
  desk.write("pendulum.toml", kPendulum);
  REQUIRE(desk.run("compare pendulum.toml --out alone").code == 0);
  const std::string one = "\"$concord\" compare pendulum.toml --out shared --json verdict.json > /dev/null";
  CHECK(desk.shell(one + " & " + one + " & " + one + "; code=$?; wait; exit $code") == 0);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(desk.work() / "shared")) {
    names.push_back(entry.path().filename().string());
    CHECK(read(entry.path()) == read(desk.work() / "alone" / names.back()));
  }
  CHECK(static_cast<long>(names.size()) ==
        std::distance(fs::directory_iterator(desk.work() / "alone"), fs::directory_iterator()));
  CHECK(Json::parse(read(desk.work() / "verdict.json"))["verdict"] == "agree");
}
