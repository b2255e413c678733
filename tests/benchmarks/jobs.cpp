#include "tests/benchmarks/jobs.h"

#include <fmt/format.h>
#include <valgrind/callgrind.h>

#include <functional>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "cartesian/solver.h"
#include "common/joints/revolute.h"
#include "common/joints/spherical.h"
#include "compare/program/commands.h"
#include "relative/solver.h"
#include "tests/benchmarks/evaluators.h"

namespace concord::benchmarks {

namespace {

class Jobs {
 public:
  explicit Jobs(std::ostream& out) : out_(out) {}

  /// Counts `work`, which returns its evaluations, and nothing before or after it.
  void count(const std::string& job, const std::function<long()>& work) {
    CALLGRIND_START_INSTRUMENTATION;
    CALLGRIND_ZERO_STATS;
    const long evaluations = work();
    CALLGRIND_DUMP_STATS_AT(job.c_str());
    CALLGRIND_STOP_INSTRUMENTATION;
    out_ << fmt::format("{},{}\n", job, evaluations);
  }

  /// One evaluation by each solver, not the first.
  void evaluate(const std::string& what, const Machine& machine) {
    for (const auto& [name, make] : {std::pair{"cartesian", &make_cartesian}, {"relative", &make_relative}}) {
      const std::unique_ptr<Evaluator> evaluator = make(machine);
      evaluator->evaluate();
      count(fmt::format("{} by {}", what, name), [&] {
        evaluator->evaluate();
        return 1L;
      });
    }
  }

  /// A run by each solver, its start and the decisions that are taken once left out.
  void run(const std::string& what, const Machine& machine, double until) {
    for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
      const std::unique_ptr<Solver> solver = make(machine.model);
      RunOptions options = compare::run_options(machine.model, {});
      options.until = until;
      options.samples = 10;
      static_cast<void>(solver->rank(solver->assemble()));
      count(fmt::format("{} for {} s by {}", what, until, solver->name()),
            [&] { return solver->integrate(options, [](double /*t*/) {}).statistics.evaluations; });
    }
  }

  /// A command of the program.
  void command(const std::string& words, const std::function<int(const compare::Console&)>& work) {
    count(words, [&] {
      std::ostringstream said;
      if (work({said, said}) != 0) throw std::runtime_error(fmt::format("{}: {}", words, said.str()));
      return 0L;
    });
  }

 private:
  std::ostream& out_;
};

}  // namespace

void do_jobs(const std::filesystem::path& data, std::ostream& out) {
  const auto file = [&](const char* name) { return data / "models" / (std::string(name) + ".toml"); };
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  Jobs jobs(out);
  jobs.evaluate("chain of 256", make_chain(256, joints::revolute));
  jobs.evaluate("spherical chain of 256", make_chain(256, joints::spherical));
  jobs.evaluate("tree of 255", make_tree(255));
  jobs.evaluate("ladder of 40", make_ladder(40));
  const Machine car = read_machine(file("car"));
  jobs.evaluate("car", car);
  jobs.run("car", car, 0.1);
  jobs.run("slider_crank_flexible", read_machine(file("slider_crank_flexible")), 0.1);
  jobs.run("slider_crank_spatial_flexible", read_machine(file("slider_crank_spatial_flexible")), 0.005);
  jobs.command("info car",
               [&](const compare::Console& console) { return compare::show_info(file("car"), makers, console); });
  jobs.command("compare slider_crank_flexible --same-state", [&](const compare::Console& console) {
    compare::CompareCommand command;
    command.models = {file("slider_crank_flexible")};
    command.options.integrates = false;
    return compare::compare_models(command, makers, console);
  });
}

}  // namespace concord::benchmarks
