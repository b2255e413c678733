#include "compare/program/examples.h"

#include <fmt/format.h>

namespace concord::compare {

namespace {

struct Example {
  std::string_view command;
  std::string_view arguments;
  std::string_view about;
};

/// In the order in which --help lists the commands.
constexpr Example kExamples[] = {
    {"compare", "data/models/slider_crank_flexible.toml",
     "judge every joint reaction; one row for each joint and side"},
    {"compare", "data/models/*.toml --json verdict.json",
     "all models, a summary at the end, the verdicts for other programs"},
    {"compare", "my.toml --until 0.5 --rtol 1e-10 --all --out results",
     "all components; NetCDF, CSV, plots and the table in results/"},
    {"compare", "my.toml --report my.html", "a page with table, curves and the machine in motion"},
    {"run", "data/models/car.toml --solver relative --until 1", "one solver alone: peak reactions, its own audit"},
    {"run", "my.toml --solver cartesian --integrator ida --out results",
     "by its implicit integrator; NetCDF and CSV in results/"},
    {"info", "data/models/slider_crank_redundant.toml", "bodies, joints, loops, rank, and which reactions are unique"},
    {"info", "my.toml", "whether a new model can be read, closes and moves as it is meant to"},
    {"statics", "data/models/hanging_chain.toml", "the static equilibrium by both solvers"},
    {"statics", "my.toml --all --json equilibrium.json", "every component; places and reactions for other programs"},
    {"linearize", "data/models/car.toml --at equilibrium", "frequencies, damping ratios and mode shapes at rest"},
    {"linearize", "my.toml --json modes.json", "about the motion through the start"},
    {"kinematics", "data/models/slider_crank_rigid.toml --until 0.1",
     "motion and reactions of a machine whose motion is fully driven"},
    {"kinematics", "my.toml --samples 1000 --out results", "1000 intervals; NetCDF and CSV of each solver in results/"},
    {"inverse", "data/models/compound_pendulum.toml", "forces that hold the kept coordinates at constant speed"},
    {"inverse", "my.toml --acceleration hinge.turn_z=2.5",
     "forces that give a kept coordinate this acceleration, and the way back"},
    {"joint", "universal", "a sheet that proves or refutes the type"},
    {"joint", "--all --out sheets", "every type of the catalogue, a summary, and the sheets in sheets/"},
    {"joint", "universal --seed 7 --poses 100", "other poses, and more of them"},
    {"invariance", "data/models/slider_crank_rigid.toml",
     "each solver against itself: the same machine described in equivalent ways"},
    {"invariance", "my.toml --move units --move sides", "two of the ways alone"},
    {"fuzz", "--count 1000 --keep found", "compares random machines; failing ones are kept in found/, reduced"},
    {"fuzz", "--minutes 10 --style loops --seed 7", "machines with loops, as many as ten minutes allow"},
    {"fuzz", "--seed 7 --first 12 --print", "machine 12 of the seed as a model"},
    {"nightly", "data/smoke.toml",
     "runs a suite of cases in less than a minute, and compares with the accepted results"},
    {"nightly", "data/nightly.toml --history ~/nights.sqlite --out tonight",
     "remembers the night; table, changes and page in tonight/"},
    {"nightly", "data/nightly.toml --history ~/nights.sqlite --slurm --partition=night",
     "the same as jobs of a Slurm cluster"},
    {"accept", "data/nightly.toml --reason \"first baselines\"", "the results of this program become the baselines"},
    {"accept", "data/nightly.toml car --reason \"a better step size\" --history ~/nights.sqlite",
     "those of one case, as the last night found them"},
    {"history", "slider_crank_flexible --history ~/nights.sqlite",
     "the trend of a case, its steps, and the commits before and after"},
    {"history", "car --component F_z --last 10 --history ~/nights.sqlite", "of some components, over ten nights"},
    {"diff", "last-1 last --history ~/nights.sqlite", "what changed since the night before"},
    {"diff", "before.json after.json --markdown changes.md", "between two files of nightly --json or compare --json"},
    {"report", "results -o machine.html", "the folder of compare --out as one page"},
    {"report", "~/nights.sqlite -o night.html", "the last night and all trends as one page"}};

std::string text_of(const Example& example) {
  return fmt::format("  concord {} {}\n      {}\n", example.command, example.arguments, example.about);
}

}  // namespace

std::string examples_of(std::string_view command) {
  std::string text;
  for (const Example& example : kExamples) {
    if (example.command == command) text += text_of(example);
  }
  return text.empty() ? text : "Examples:\n" + text;
}

std::string first_examples() {
  std::string text = "Examples (more by `concord COMMAND --help`):\n";
  std::string_view last;
  for (const Example& example : kExamples) {
    if (example.command != last) text += text_of(example);
    last = example.command;
  }
  return text;
}

}  // namespace concord::compare
