#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cartesian/solver.h"
#include "common/error.h"
#include "common/reading/model_file.h"
#include "compare/audit/balance.h"
#include "compare/random_machines/generator.h"
#include "compare/random_machines/writer.h"
#include "compare/report/files.h"
#include "compare/report/text_table.h"
#include "compare/resolution/weighed_states.h"
#include "compare/states/states.h"
#include "compare/verdict/refinement.h"
#include "compare/workers/pool.h"
#include "relative/solver.h"
#include "tests/faults/catalogue.h"
#include "tests/second_reading/second_reading.h"

namespace concord::compare {
namespace {

using faults::Fault;
using faults::Planting;

constexpr int kNeighbours = 4;         // states beside the start
constexpr double kExercised = 1e-6;    // of the scale: a fault that changes a result by more acts on the machine
constexpr const char* kAgree = "-";    // no verdict against the machine
constexpr const char* kIdle = "idle";  // the fault changes nothing there

struct Solvers {
  std::unique_ptr<Solver> cartesian;
  std::unique_ptr<Solver> relative;

  explicit Solvers(const Model& model)
      : cartesian(cartesian::make_solver(model)), relative(relative::make_solver(model)) {}
  [[nodiscard]] std::array<Solver*, 2> both() const { return {cartesian.get(), relative.get()}; }
};

/// A machine of a seed: its files, and states of it that the sound solvers closed.
struct Subject {
  std::uint64_t seed = 0;
  std::uint64_t number = 0;
  std::string text;
  std::filesystem::path file;
  std::vector<OwnedState> states;
  std::array<MatX, 2> values;  // what each solver says there
  VecX scales;

  [[nodiscard]] Model read() const { return parse_model(text, file); }
};

bool all_pass(const Verdict& verdict) {
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (row.unique && row.same_state && !meets_need(row, Check::same_state)) return false;
    }
  }
  return true;
}

/// What the audit says of both solvers, by the rule that is farthest below its need; kAgree if it holds.
std::string audit(const Model& model, const std::vector<SharedState>& states) {
  for (const Who who : {Who::cartesian, Who::relative}) {
    Auditor auditor(model);
    for (const SharedState& one : states) auditor.add(one.state, one.evaluations[index(who)]);
    const AuditReport report = auditor.report();
    if (!report.holds()) return fmt::format("audit: {}", name_of(report.worst.rule));
  }
  return kAgree;
}

/// The first check that two solvers miss at given states: of rank, same state and audit; or that one refuses.
std::string judge(const Model& model, const Solvers& solvers, const std::vector<OwnedState>& states) {
  try {
    SharedStates shared = share(solvers.both(), states);
    if (!shared.failures.empty() || !shared.singular.empty()) return "refused";
    if (!shared.refusals.empty()) return "closures";
    const QuantityLayout layout(model);
    const WeighedStates weighed = weigh(layout, solvers.both(), std::move(shared.states), kSeed);
    if (!weighed.dropped.empty()) return "refused";
    if (!weighed.findings.empty()) return "rank";
    Verdict verdict;
    make_rows(layout, verdict);
    record(layout, measure(layout, weighed.series, weighed.budget()), Check::same_state, verdict);
    judge(verdict);
    if (!has_judged(verdict) || !carries_something(verdict)) return "refused";
    if (!all_pass(verdict)) return "same state";
    return audit(model, weighed.states);
  } catch (const InputError&) {
    return "refused";
  } catch (const SolverError&) {
    return "refused";
  } catch (const IncompleteResult&) {
    return "refused";
  }
}

/// States of a machine; nothing if the sound solvers do not agree there.
std::optional<Subject> draw(std::uint64_t seed, std::uint64_t number, const std::filesystem::path& folder) {
  const fuzz::ModelText written = fuzz::write_machine(fuzz::draw_machine(seed, number, fuzz::Style::mixed));
  for (const auto& [name, content] : written.beside) write_file(folder / name, content);
  Subject subject{seed, number, written.model, folder / "machine.toml", {}, {}, {}};
  try {
    const Model model = subject.read();
    const Solvers solvers(model);
    subject.states.push_back({solvers.cartesian->assemble(), Who::cartesian});
    subject.states.push_back({solvers.relative->assemble(), Who::relative});
    SharedStates near = share_random(model, solvers.both(), subject.states, kSeed, kNeighbours);
    if (!near.failures.empty() || !near.refusals.empty()) return std::nullopt;
    for (std::size_t k = 0; k < near.states.size(); ++k) {
      subject.states.push_back({std::move(near.states[k].state), static_cast<Who>(k % 2)});
    }
    if (judge(model, solvers, subject.states) != kAgree) return std::nullopt;
    const QuantityLayout layout(model);
    const Series series = align(layout, share(solvers.both(), subject.states).states);
    subject.values = series.values;
    const std::vector<Measured> measured = measure(layout, series);
    subject.scales.resize(static_cast<Eigen::Index>(measured.size()));
    for (std::size_t row = 0; row < measured.size(); ++row) {
      subject.scales(static_cast<Eigen::Index>(row)) = measured[row].scale;
    }
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const SolverError&) {
    return std::nullopt;
  } catch (const IncompleteResult&) {
    return std::nullopt;
  }
  return subject;
}

/// Whether a solver with the fault says something else in any of the states, or does not accept it.
bool is_exercised(const Subject& subject, const QuantityLayout& layout, Solver& solver, Who who) {
  const MatX& sound = subject.values[index(who)];
  for (std::size_t k = 0; k < subject.states.size(); ++k) {
    try {
      const State& state = subject.states[k].state;
      const VecX change = layout.observe(state, solver.evaluate(state)) - sound.col(static_cast<Eigen::Index>(k));
      if (!change.allFinite() || (change.cwiseAbs().array() > kExercised * subject.scales.array()).any()) return true;
    } catch (const SolverError&) {
      return true;
    }
  }
  return false;
}

/// What becomes of a machine with a fault of a solver or of common.
std::string try_fault(const Subject& subject, const Fault& fault) {
  const Planting planting(fault.number);
  try {
    const Model model = subject.read();
    const Solvers solvers(model);
    const QuantityLayout layout(model);
    bool acts = false;
    for (const Who who : {Who::cartesian, Who::relative}) {
      const bool holds_it = fault.is_in("common") || fault.is_in(kSolverNames[index(who)]);
      acts = acts || (holds_it && is_exercised(subject, layout, *solvers.both()[index(who)], who));
    }
    if (acts && !second_reading::read_again_text(model, subject.text, subject.file).differing.empty()) return "reading";
    // A fault in the rank shows in what is called unique, not in any number.
    const std::string found = acts || fault.check == "rank" ? judge(model, solvers, subject.states) : kIdle;
    return fault.check == "rank" && found == kAgree ? kIdle : found;
  } catch (const InputError&) {
    return "refused";
  } catch (const SolverError&) {
    return "refused";
  } catch (const IncompleteResult&) {
    return "refused";
  }
}

/// Numbers separated by blanks: seed, machine, faults that are still wanted. Answers with one line for each fault that
/// acts: its number and what became of it.
std::string work(const std::string& input, const std::vector<Fault>& all, const std::filesystem::path& scratch) {
  std::istringstream words(input);
  std::uint64_t seed = 0;
  std::uint64_t number = 0;
  words >> seed >> number;
  const std::filesystem::path folder = scratch / std::to_string(getpid());
  std::filesystem::create_directories(folder);
  std::string answer;
  const auto subject = draw(seed, number, folder);
  if (!subject) return answer;
  for (std::size_t wanted = 0; words >> wanted;) {
    const Fault& fault = all[wanted];
    std::fprintf(stderr, "fault: %s\n", fault.name.c_str());
    const std::string found = try_fault(*subject, fault);
    if (found != kIdle) answer += fmt::format("{} {}\n", wanted, found);
  }
  return answer;
}

/// What became of the machines on which a fault acts.
struct Rate {
  int exercised = 0;
  int caught = 0;
  std::map<std::string, int> by;
  std::vector<std::uint64_t> missed;  // machines
};

struct Settings {
  std::uint64_t seed = 20261122;
  std::uint64_t machines = 4000;
  int wanted = 200;
  int jobs = 1;
};

class Scan {
 public:
  explicit Scan(const Settings& settings)
      : settings_(settings),
        scratch_(std::filesystem::temp_directory_path() / fmt::format("concord_faults.{}", getpid())),
        rates_(all_.size()),
        pool_([this](const std::string& input) { return work(input, all_, scratch_); }, settings.jobs,
              {600.0, 2048.0}) {
    std::filesystem::create_directories(scratch_);
  }

  void run() {
    std::uint64_t given = 0;
    const auto next = [&]() -> std::optional<std::string> {
      const std::string open = wanted();
      if (given >= settings_.machines || open.empty()) return std::nullopt;
      return fmt::format("{} {}{}", settings_.seed, given++, open);
    };
    pool_.run(next, [&](std::size_t number, const workers::Report& report) { take(number, report); });
    std::filesystem::remove_all(scratch_);
  }

  /// Whether every fault that acts on machines was caught on some.
  [[nodiscard]] bool is_each_caught() const {
    return std::all_of(all_.begin(), all_.end(), [&](const Fault& fault) {
      const Rate& rate = rates_[static_cast<std::size_t>(fault.number)];
      return rate.exercised == 0 || rate.caught > 0;
    });
  }

  void print() const {
    std::vector<std::vector<std::string>> lines{{"fault", "acts on", "caught", "by", "missed first"}};
    for (const Fault& fault : all_) {
      if (fault.is_in("compare")) continue;
      const Rate& rate = rates_[static_cast<std::size_t>(fault.number)];
      std::string by;
      for (const auto& [check, count] : rate.by) by += fmt::format("{}{} {}", by.empty() ? "" : ", ", check, count);
      lines.push_back({fault.name, std::to_string(rate.exercised),
                       rate.exercised > 0 ? fmt::format("{:.1f} %", 100.0 * rate.caught / rate.exercised) : "-",
                       by.empty() ? "-" : by, rate.missed.empty() ? "-" : std::to_string(rate.missed.front())});
    }
    fmt::print("{}{} machines of seed {} drawn; {} tasks ended without an answer\n",
               format_table(lines, {false, true, true, false, true}), machines_, settings_.seed, lost_);
  }

 private:
  /// Faults that have not acted on enough machines yet.
  [[nodiscard]] std::string wanted() const {
    std::string open;
    for (const Fault& fault : all_) {
      if (fault.is_in("compare")) continue;
      if (rates_[static_cast<std::size_t>(fault.number)].exercised < settings_.wanted) {
        open += fmt::format(" {}", fault.number);
      }
    }
    return open;
  }

  void take(std::uint64_t number, const workers::Report& report) {
    ++machines_;
    if (report.end != workers::End::answered) {
      ++lost_;
      fmt::print(stderr, "machine {}: {}; {}\n", number, workers::to_string(report.end), report.last_words);
      return;
    }
    std::istringstream lines(report.answer);
    std::string line;
    while (std::getline(lines, line)) {
      const std::size_t blank = line.find(' ');
      Rate& rate = rates_[std::stoul(line.substr(0, blank))];
      if (rate.exercised >= settings_.wanted) continue;
      const std::string found = line.substr(blank + 1);
      ++rate.exercised;
      if (found == kAgree) {
        rate.missed.push_back(number);
      } else {
        ++rate.caught;
        ++rate.by[found];
      }
    }
  }

  Settings settings_;
  std::vector<Fault> all_ = faults::read_catalogue();  // those of the comparator change no result: they act nowhere
  std::filesystem::path scratch_;
  std::vector<Rate> rates_;
  workers::Pool pool_;
  std::uint64_t machines_ = 0;
  int lost_ = 0;
};

}  // namespace
}  // namespace concord::compare

/// random_faults [WANTED [MACHINES [JOBS [SEED]]]]: plants each fault in random machines until it has acted on WANTED
/// of them or MACHINES were drawn, and prints how many of these are judged other than `agree`, at the same state alone.
int main(int argc, char** argv) {
  using namespace concord::compare;
  Settings settings;
  const auto number = [&](int place, auto preset) {
    return argc > place ? static_cast<decltype(preset)>(std::strtoull(argv[place], nullptr, 10)) : preset;
  };
  settings.wanted = number(1, settings.wanted);
  settings.machines = number(2, settings.machines);
  settings.jobs = number(3, settings.jobs);
  settings.seed = number(4, settings.seed);
  Scan scan(settings);
  scan.run();
  scan.print();
  return scan.is_each_caught() ? 0 : 1;
}
