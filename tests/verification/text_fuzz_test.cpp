#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cctype>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../unit/common/broken_models.h"
#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "common/reading/modes_file.h"
#include "compare/verdict/reference.h"
#include "relative/solver.h"

/// Text fuzzing: shipped model files, modes files, references and command lines, mutated. Whatever the text, it is read
/// or refused as bad input: no crash, no hang, no appetite for memory. CONCORD_TEXT_FUZZ is the number of inputs,
/// CONCORD_TEXT_FUZZ_SEED the seed; an input follows from the seed and its number alone.
namespace {

namespace fs = std::filesystem;
using namespace concord;
using Random = std::mt19937_64;

constexpr double kLongest = 5.0;                              // s an input
[[maybe_unused]] constexpr long kMostMemory = 1024L * 1024L;  // KiB of the whole process

long from_environment(const char* name, long otherwise) {
  const char* said = std::getenv(name);
  return said == nullptr ? otherwise : std::atol(said);
}

std::string read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::size_t below(Random& random, std::size_t end) { return end == 0 ? 0 : static_cast<std::size_t>(random() % end); }

template <class List>
const auto& one_of(const List& list, Random& random) {
  return list[below(random, std::size(list))];
}

enum class Kind { model, modes, reference };

/// A text to start from, and the name under which it is read.
struct Seed {
  Kind kind;
  fs::path file;
  std::string text;
};

std::vector<Seed> seeds() {
  std::vector<Seed> all{{Kind::model, "sound.toml", kSoundModel}};
  std::vector<fs::path> files;
  for (const char* folder : {"models", "modes"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(CONCORD_DATA) / folder)) {
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const std::string text = read(file);
    all.push_back({text.find("\nmodes = ") != std::string::npos && text.find("[[joint]]") == std::string::npos
                       ? Kind::modes
                       : Kind::model,
                   file, text});
  }
  all.push_back({Kind::reference, "",
                 "# Somebody, fig. 3\n# error = 0.5 %\n# error B.child.F_x = 0.2 N\n"
                 "t [s],A.child.T_y [N m],B.child.F_x [N],rod.v_x [m/s],D.tau_1 [N]\n"
                 "0,1.5,-2,0.1,1\n0.2, +1.25 ,3e-1,4,5\n0.5,\"1\",2,3,4\n"});
  return all;
}

/// Where words and numbers of a text begin and end.
std::vector<std::pair<std::size_t, std::size_t>> words_of(const std::string& text) {
  std::vector<std::pair<std::size_t, std::size_t>> words;
  const auto is_inside = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
  };
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (!is_inside(text[k])) continue;
    const std::size_t first = k;
    while (k < text.size() && is_inside(text[k])) ++k;
    words.emplace_back(first, k);
  }
  return words;
}

constexpr std::array kValues{"0",
                             "-0.0",
                             "1",
                             "-1",
                             "2",
                             "1e150",
                             "1e151",
                             "1e-151",
                             "-3e149",
                             "1e308",
                             "1e-320",
                             "1e999",
                             "nan",
                             "-inf",
                             "9223372036854775807",
                             "9223372036854775808",
                             "0x7fff",
                             "0b1",
                             "1_000",
                             "100000",
                             "1000000000",
                             "true",
                             "1997-10-01",
                             "[]",
                             "{}",
                             "[[]]",
                             "[1, 2, 3]",
                             "[1e150, 1e150, 1e150]",
                             "[0, 0, 0]",
                             "\"\"",
                             "\"1/0\"",
                             "\"sqrt(-1)\"",
                             "\"20 deg\"",
                             "\"a + b\"",
                             "\"2^500\"",
                             "\"(((((\"",
                             "\"1 ? 2 : 3\"",
                             "\"x = 3\"",
                             "\"max()\"",
                             "\"1, 2\"",
                             "\"-----1\"",
                             "\"pi deg\"",
                             "\"0x10\"",
                             "\"1e400\"",
                             "\"\\u0000\"",
                             "\"ground\"",
                             "\"../\"",
                             "\"/dev/zero\"",
                             "\"\\n\"",
                             "'''x'''"};
constexpr std::array kSnippets{"[[",
                               "]]",
                               "[",
                               "]",
                               "{",
                               "}",
                               "\"\"\"",
                               "'''",
                               "\"",
                               "'",
                               "\\",
                               "#",
                               "=",
                               ",",
                               ".",
                               "\n",
                               "\r",
                               "\t",
                               "\n[[body]]\n",
                               "\n[[joint]]\n",
                               "\n[parameters]\n",
                               "\nformat = 1\n",
                               "\n[[include]]\nfile = \"body.toml\"\n",
                               ".a.b.c",
                               " = ",
                               "e5",
                               "-",
                               "\xff",
                               "\xc3",
                               "\xe2\x82\xac",
                               "\xef\xbb\xbf",
                               "\n[run]\n",
                               "\n[[need]]\n",
                               "\\u0000",
                               "%",
                               "error"};

/// One change of a text; a gentle one of a word or a number only, so that more of the texts can be read.
void mutate(std::string& text, const std::vector<Seed>& all, bool is_gentle, Random& random) {
  const std::size_t place = below(random, text.size() + 1);
  const auto words = words_of(text);
  switch (is_gentle ? 13 : below(random, 14)) {
    case 0:
      if (place < text.size()) text[place] = static_cast<char>(random() % 256);
      return;
    case 1:
      text.insert(place, 1, static_cast<char>(random() % 256));
      return;
    case 2:
      text.erase(place, 1 + below(random, 20));
      return;
    case 3:
      text.insert(below(random, text.size() + 1), text.substr(place, 1 + below(random, 60)));
      return;
    case 4:
      text.resize(place);
      return;
    case 5: {  // many of one thing
      const std::string many = one_of(kSnippets, random);
      std::string all_of_it;
      for (std::size_t k = below(random, 3) == 0 ? 3000 : below(random, 60); k > 0; --k) all_of_it += many;
      text.insert(place, all_of_it);
      return;
    }
    case 6: {  // a line away, twice, or elsewhere
      const std::size_t first = text.rfind('\n', place) == std::string::npos ? 0 : text.rfind('\n', place);
      const std::size_t end = std::min(text.find('\n', place + 1), text.size());
      const std::string line = text.substr(first, end - first);
      if (below(random, 3) != 0) text.erase(first, end - first);
      if (below(random, 2) != 0) text.insert(std::min(text.size(), below(random, text.size() + 1)), line);
      return;
    }
    case 7: {  // a part of another text
      const std::string& other = one_of(all, random).text;
      text.insert(place, other.substr(below(random, other.size()), below(random, 400)));
      return;
    }
    case 8:
      text.insert(place, one_of(kSnippets, random));
      return;
    default:
      break;
  }
  if (words.empty()) return;
  const auto [first, end] = one_of(words, random);
  if (!is_gentle && below(random, 3) == 0) {
    const auto [other, other_end] = one_of(words, random);
    text.replace(first, end - first, text.substr(other, other_end - other));
  } else if (below(random, is_gentle ? 1 : 3) == 0 && std::isdigit(static_cast<unsigned char>(text[first])) != 0) {
    const double exponent = static_cast<double>(below(random, 24001)) / 1000.0 - 12.0;
    text.replace(first, end - first, fmt::format("{:.3g}", std::pow(10.0, exponent)));
  } else {
    text.replace(first, end - first, one_of(kValues, random));
  }
}

/// An input from its number.
Seed make_input(const std::vector<Seed>& all, std::uint64_t seed, long number) {
  Random random(seed * 0x9E3779B97F4A7C15U + static_cast<std::uint64_t>(number));
  Seed input = below(random, 12) == 0 ? all.back() : one_of(all, random);
  const bool is_gentle = below(random, 3) == 0;
  const std::size_t most = is_gentle ? 2 : 5;
  for (std::size_t count = 1 + below(random, most); count > 0; --count) mutate(input.text, all, is_gentle, random);
  return input;
}

/// What a crash says last: the handler may only write.
std::array<char, 64> last_words{};
std::size_t last_words_size = 0;

extern "C" void say_last_words(int signal) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, last_words.data(), last_words_size);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Tells which input was at work when a signal ends the process; a hang ends it too.
class Watch {
 public:
  Watch() {
#ifndef CONCORD_SANITIZED  // the sanitizers have handlers of their own
    stack_.resize(1U << 16U);
    stack_t alternative{};
    alternative.ss_sp = stack_.data();
    alternative.ss_size = stack_.size();
    sigaltstack(&alternative, nullptr);
    watch(SIGSEGV);
    watch(SIGFPE);
    watch(SIGABRT);
#endif
    watch(SIGALRM);
  }
  ~Watch() {
    alarm(0);
    for (const auto& [signal, action] : before_) sigaction(signal, &action, nullptr);
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    sigaltstack(&none, nullptr);
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  static void begin(std::uint64_t seed, long number) {
    const std::string text = fmt::format("text fuzz: seed {}, input {}\n", seed, number);
    last_words_size = std::min(text.size(), last_words.size());
    std::copy_n(text.begin(), last_words_size, last_words.begin());
    alarm(60);
  }

 private:
  void watch(int signal) {
    struct sigaction action {};
    action.sa_handler = say_last_words;
    action.sa_flags = SA_ONSTACK;
    struct sigaction before {};
    sigaction(signal, &action, &before);
    before_.emplace_back(signal, before);
  }

  std::vector<char> stack_;
  std::vector<std::pair<int, struct sigaction>> before_;
};

/// Lets both solvers look at a small machine that was read.
void assemble(const Model& model) {
  constexpr std::size_t kMostBodies = 8;
  if (model.bodies.size() > kMostBodies) return;
  for (int who = 0; who < 2; ++who) {
    try {
      const auto solver = who == 0 ? cartesian::make_solver(model) : relative::make_solver(model);
      (void)solver->rank(solver->assemble());
    } catch (const SolverError&) {
    } catch (const InputError&) {
    }
  }
}

/// How often inputs were read, or refused.
struct Tally {
  long read = 0;
  long refused = 0;
};

/// Reads an input; "" if all is well.
std::string try_input(const Seed& input, const Model& sound, const fs::path& scratch, bool also_solve, Tally& tally) {
  try {
    if (input.kind == Kind::modes) {
      (void)parse_modes(input.text, input.file);
    } else if (input.kind == Kind::reference) {
      std::ofstream(scratch, std::ios::binary | std::ios::trunc) << input.text;
      (void)compare::read_reference(scratch, sound);
    } else {
      const Model model = parse_model(input.text, input.file);
      if (also_solve) assemble(model);
    }
    ++tally.read;
  } catch (const InputError& error) {
    ++tally.refused;
    for (const Diagnostic& one : error.diagnostics()) {
      if (one.message.empty()) return "a complaint without words";
    }
    if (error.diagnostics().empty()) return "refused without a complaint";
  } catch (const std::exception& error) {
    return fmt::format("threw what is no InputError: {}", error.what());
  } catch (...) {
    return "threw what is no exception";
  }
  return "";
}

/// Keeps a text that fails.
fs::path keep(const Seed& input, std::uint64_t seed, long number) {
  fs::path path = fs::temp_directory_path() / fmt::format("concord_text_fuzz_{}_{}.txt", seed, number);
  std::ofstream(path, std::ios::binary) << input.text;
  return path;
}

void fuzz_texts(std::uint64_t seed, long count) {
  const std::vector<Seed> all = seeds();
  const Model sound = parse_model(kSoundModel, "sound.toml");
  const fs::path scratch = fs::temp_directory_path() / fmt::format("concord_text_fuzz_{}.csv", getpid());
  const Watch watch;
  Tally tally;
  double slowest = 0.0;
  const auto start = std::chrono::steady_clock::now();
  const auto since = [](auto then) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
  };
  const long first = from_environment("CONCORD_TEXT_FUZZ_FIRST", 0);
  for (long number = first; number < first + count; ++number) {
    const Seed input = make_input(all, seed, number);
    Watch::begin(seed, number);
    const auto begin = std::chrono::steady_clock::now();
    const std::string trouble = try_input(input, sound, scratch, number % 8 == 0, tally);
    const double seconds = since(begin);
    slowest = std::max(slowest, seconds);
    if (trouble.empty() && seconds < kLongest) continue;
    FAIL_CHECK("seed " << seed << ", input " << number << " of " << input.file << ": " << trouble << ", " << seconds
                       << " s; the text is in " << keep(input, seed, number));
  }
  std::error_code ignored;
  fs::remove(scratch, ignored);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#ifndef CONCORD_SANITIZED
  CHECK(usage.ru_maxrss < kMostMemory);
#endif
  std::cerr << fmt::format(
      "text fuzz: seed {}, {} inputs, {} read, {} refused, {:.0f} a second, slowest {:.2f} s, {} MiB\n", seed, count,
      tally.read, tally.refused, static_cast<double>(count) / since(start), slowest, usage.ru_maxrss / 1024);
  CHECK(tally.read > 0);
  CHECK(tally.refused > 0);
}

/// A command line of words that the program knows and of nonsense.
std::string command_line(Random& random) {
  constexpr std::array kCommands{"compare",    "run",     "info",  "statics", "linearize",
                                 "kinematics", "inverse", "joint", ""};
  constexpr std::array kOptions{"--until",
                                "--rtol",
                                "--samples",
                                "--json",
                                "--junit",
                                "--out",
                                "--reference",
                                "--solver",
                                "--integrator",
                                "--all",
                                "--at",
                                "--acceleration",
                                "--seed",
                                "--poses",
                                "--pose",
                                "--help",
                                "--version",
                                "--cartesian-integrator",
                                "--relative-integrator",
                                "--",
                                "-x",
                                "---",
                                "--json="};
  constexpr std::array kArguments{"m.toml",
                                  "absent.toml",
                                  ".",
                                  "''",
                                  "/dev/null",
                                  "fifo",
                                  "0",
                                  "-1",
                                  "1e-3",
                                  "0.01",
                                  "nan",
                                  "1e400",
                                  "1e151",
                                  "7",
                                  "relative",
                                  "cartesian",
                                  "weld",
                                  "hinge.turn_z=1",
                                  "hinge.turn_z=",
                                  "=",
                                  ".=1",
                                  "hinge.=nan",
                                  "start",
                                  "equilibrium",
                                  "v.json",
                                  "out",
                                  "$(printf '\\377')",
                                  "\"$(printf 'a\\nb')\"",
                                  "out/../m.toml",
                                  "99999999999999999999",
                                  "ida",
                                  "radau"};
  std::string line = one_of(kCommands, random);
  for (std::size_t k = below(random, 6); k > 0; --k) {
    line += ' ';
    line += below(random, 2) == 0 ? one_of(kOptions, random) : one_of(kArguments, random);
  }
  return line;
}

void fuzz_command_lines(std::uint64_t seed, long count) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("concord_text_fuzz_{}", getpid());
  fs::create_directories(folder);
  const std::string model = R"(format = 1
gravity = [0.3, -9.81, 0.2]
[[body]]
name = "bob"
mass = 1.3
inertia = [0.02, 0.03, 0.04]
center_of_mass = [0.2, 0.1, 0]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "bob"
start.turn_z = { keep = 0.4, keep_speed = 2 }
[run]
until = 0.01
samples = 5
)";
  for (long number = 0; number < count; ++number) {
    Random random(seed + static_cast<std::uint64_t>(number));
    std::ofstream(folder / "m.toml") << model;
    const std::string line = command_line(random);
    const std::string command = "cd '" + folder.string() +
                                "' && { [ -p fifo ] || mkfifo fifo; } && exec timeout 60 '" CONCORD_PROGRAM "' " +
                                line + " < /dev/null > said 2>&1";
    const int status = std::system(command.c_str());
    INFO("seed " << seed << ", command line " << number << ": " << line << '\n'
                 << read(folder / "said").substr(0, 2000));
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) <= 3);
    CHECK(read(folder / "m.toml") == model);
    CHECK_FALSE(read(folder / "said").empty());
  }
  fs::remove_all(folder);
}

}  // namespace

TEST_CASE("Some mutated texts are read or refused", "[program]") { fuzz_texts(1, 400); }

TEST_CASE("Mutated texts are read or refused, never more", "[nightly]") {
  fuzz_texts(static_cast<std::uint64_t>(from_environment("CONCORD_TEXT_FUZZ_SEED", 1997)),
             from_environment("CONCORD_TEXT_FUZZ", 10000));
}

TEST_CASE("Command lines are done or refused, never more", "[nightly]") {
  fuzz_command_lines(static_cast<std::uint64_t>(from_environment("CONCORD_TEXT_FUZZ_SEED", 1997)),
                     from_environment("CONCORD_TEXT_FUZZ", 10000) / 50);
}
