#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compare/analyses/command.h"

namespace CLI {
class App;
}

namespace concord::compare {

/// `statics`, `linearize`, `kinematics` and `inverse` on a command line.
class AnalysisCommands {
 public:
  explicit AnalysisCommands(CLI::App& program);
  AnalysisCommands(const AnalysisCommands&) = delete;  // the command line writes into this object
  AnalysisCommands& operator=(const AnalysisCommands&) = delete;

  /// The one that was asked for, after the line has been parsed; null if it was none of them.
  const analyses::AnalysisCommand* parsed();

 private:
  CLI::App* add(CLI::App& program, analyses::Analysis analysis, const char* name, const char* about);

  analyses::AnalysisCommand command_;
  std::string linearize_at_ = "start";
  std::vector<std::pair<CLI::App*, analyses::Analysis>> commands_;
};

}  // namespace concord::compare
