#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace concord {

/// Where a statement of a model file stands. Lines and columns count from 1; 0 means "not known".
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;
};

/// One complaint about an input: `file:line:column: error: message`.
struct Diagnostic {
  SourceLocation where;
  std::string message;

  [[nodiscard]] std::string text() const;
};

/// Invalid input: all complaints of a file at once, in the order of the file. The program exits with 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Diagnostic> diagnostics);
  InputError(SourceLocation where, std::string message);

  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Start values that contradict each other, or near which nothing closes: not a start that is found and refused.
class StartNotFound : public InputError {
 public:
  using InputError::InputError;
};

/// A statement that cannot be solved with the joints that are cut; with others it might be.
class UnsuitableCut : public InputError {
 public:
  using InputError::InputError;
};

/// A solver could not finish; the text says which solver, at what time, where and why. The program exits with 3.
class SolverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A state that somebody hands over and that a solver's own constraints do not call closed; `place`: where it is open
/// most ("joint 'A'").
class OpenState : public SolverError {
 public:
  OpenState(const std::string& message, std::string place) : SolverError(message), place_(std::move(place)) {}

  [[nodiscard]] const std::string& place() const { return place_; }

 private:
  std::string place_;
};

/// A pose where the constraints, or the motion that a joint permits, lose rank: motion may branch there and reactions
/// may be unbounded. The text names the joint or loop and the time.
class SingularPose : public SolverError {
 public:
  using SolverError::SolverError;
};

/// A run that takes more evaluations than are reasonable: its integrator is not made for this machine, or the motion
/// locks.
class TooManyEvaluations : public SolverError {
 public:
  using SolverError::SolverError;
};

/// A run that takes more evaluations than it was given (RunOptions::most_evaluations), or would, though it may be on
/// its way.
class EvaluationsSpent : public TooManyEvaluations {
 public:
  using TooManyEvaluations::TooManyEvaluations;
};

}  // namespace concord
