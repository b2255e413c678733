#pragma once

#include <array>
#include <functional>
#include <string>

namespace CLI {
class App;
}

/// What the two programs of the suite share. `concord` judges runs; `concord-campaigns` does all other work: analyses,
/// random machines, nights, the battery, the joint check. The first hands the commands of the second over to it, so
/// that a user knows one program, and whoever builds for a first verdict does not wait for the rest.
namespace concord::compare {

struct CampaignCommand {
  const char* name;
  const char* about;
};

/// The commands that `concord` hands over, in the order in which --help lists them.
inline constexpr std::array kCampaignCommands{
    CampaignCommand{"statics", "Static equilibrium by both solvers"},
    CampaignCommand{"linearize", "Eigenvalues and modes about the start or the equilibrium, by both solvers"},
    CampaignCommand{"kinematics", "Motion and reactions of a machine whose motion is fully driven, by both solvers"},
    CampaignCommand{"inverse",
                    "Total coordinate forces (springs and motors of the coordinate included) that give the kept\n"
                    "coordinates prescribed accelerations, by both solvers"},
    CampaignCommand{"joint",
                    "Prove or refute joint types: what they forbid, permit and read, by both solvers, in all kinds of "
                    "rigs"},
    CampaignCommand{"invariance", "Hold each solver against itself: the same machine described in equivalent ways"},
    CampaignCommand{"fuzz", "Compare random machines; failing ones are reduced and kept"},
    CampaignCommand{"nightly",
                    "Run a suite of cases, each in its own process, and compare the results with the accepted ones"},
    CampaignCommand{"accept", "Make results the baselines of a suite, with a reason"},
    CampaignCommand{"history", "The trend of a case over the nights, with its steps"},
    CampaignCommand{"diff", "What changed between two files of results, nights or commits"},
    CampaignCommand{"report", "Write a folder of results, or a night, as one HTML page"}};

/// Runs a program as both do: standard streams are open, SIGINT, SIGTERM and SIGHUP are watched, an exception ends it
/// with kCouldNotFinish and its text, and so does a standard output that cannot be written. Returns the exit code.
int run_guarded(const std::function<int()>& program);

/// Becomes `concord-campaigns`, which stands beside this program, with the same command line. Returns the exit code
/// only if it cannot, after saying why.
int become_campaigns(char** argv);

/// Lets the --help of each command of the program end with its examples (program/examples).
void add_examples(CLI::App& program);

/// Throws CLI::ValidationError for a first word that is no command, naming a near one.
void require_known_command(const CLI::App& program, int argc, char** argv);

/// Throws CLI::ValidationError if an option was given without anything in it, as by an empty variable of a script;
/// after the command line has been parsed.
void require_values(const CLI::App& program);

}  // namespace concord::compare
