#include "compare/program/fuzz_options.h"

#include "compare/fuzz/command.h"

namespace concord::compare::fuzz {

void add_fuzz(CommandLine& line) {
  const auto [fuzz, command] =
      line.add<FuzzCommand>("fuzz", "Compare random machines; failing ones are reduced and kept", fuzz_machines);
  CLI::Option* count =
      fuzz.add_option("--count", command.count, "How many machines; default: 1000, or as many as the minutes allow")
          ->check(whole_number_from(1, 1000000000));
  CLI::Option* minutes =
      fuzz.add_option("--minutes", command.minutes, "Stop after so many minutes")->check([](const std::string& text) {
        return why_not_within(text, 1e-3, 1e5);
      });
  fuzz.add_option("--seed", command.seed, "Seed of the machines; default: 1")->check(why_no_whole_number);
  fuzz.add_option("--first", command.first, "Number of the first machine; default: 0")->check(why_no_whole_number);
  fuzz.add_option("--jobs", command.jobs, "Worker processes; default: one for each processor")
      ->check(whole_number_from(1, 1024));
  fuzz.add_option("--keep", command.keep, "Folder for the failing machines, reduced");
  fuzz.add_option("--style", command.style, "Kind of machines; default: mixed")->check(CLI::IsMember(style_names()));
  fuzz.add_option("--seconds", command.seconds, "Processor time that one machine may use; default: 60")
      ->check([](const std::string& text) { return why_not_within(text, 0.1, 1e4); });
  fuzz.add_option("--megabytes", command.megabytes, "Memory that one machine may use; default: 1024")
      ->check([](const std::string& text) { return why_not_within(text, 16.0, 1e6); });
  fuzz.add_flag("--print", command.print,
                "Print the first machine as a model instead; with --keep: write it there, modes files too")
      ->excludes(count)
      ->excludes(minutes);
}

}  // namespace concord::compare::fuzz
