/// benchmarks: what evaluations and runs take, as a table; and instructions of jobs against those that were accepted.

#include <CLI/CLI.hpp>
#include <iostream>

#include "compare/report/console.h"
#include "tests/benchmarks/counts.h"
#include "tests/benchmarks/jobs.h"
#include "tests/benchmarks/table.h"

int main(int argc, char** argv) {
  using namespace concord;
  const std::filesystem::path data = CONCORD_DATA;
  const compare::Console console{std::cout, std::cerr};
  CLI::App app{"Without a command: a table of what evaluations and runs take"};
  std::string folder;
  std::string file;
  std::string reason;
  CLI::App& jobs = *app.add_subcommand("jobs", "Do what is counted, under callgrind");
  CLI::App& judge = *app.add_subcommand("judge", "Hold what callgrind counted against a file");
  CLI::App& accept = *app.add_subcommand("accept", "Make it that file's");
  for (CLI::App* const each : {&judge, &accept}) {
    each->add_option("FOLDER", folder, "profile.* and evaluations of `jobs`")->required();
    each->add_option("FILE", file, "Accepted counts")->required();
  }
  accept.add_option("REASON", reason, "Why they are accepted")->required();
  CLI11_PARSE(app, argc, argv);
  return compare::guarded(console, [&]() -> int {
    if (jobs) benchmarks::do_jobs(data, std::cout);
    if (accept) benchmarks::accept_counts(folder, file, reason, std::cout);
    if (judge) return benchmarks::judge_counts(folder, file, std::cout);
    if (jobs || accept) return 0;
    return benchmarks::print_table(data, std::cout, std::cerr) ? 0 : 1;
  });
}
