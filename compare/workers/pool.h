#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

/// Tasks that may crash, hang or eat memory, each done in a worker process: what one of them does to its process is
/// reported and costs no other task anything.
namespace concord::compare::workers {

inline constexpr double kWallPerProcessor = 30.0;

/// What one task may use. The time is the processor's, so that a busy machine changes no result; a task that sleeps is
/// given `wall_per_processor` times as long by the clock on the wall.
struct Limits {
  double seconds = 20.0;
  double megabytes = 1024.0;  // address space beyond what the process has when it starts
  double wall_per_processor = kWallPerProcessor;
};

enum class End {
  answered,
  threw,         // an exception left the task; the answer is its text
  crashed,       // a signal ended the process, or it left by itself
  hung,          // the time was up
  out_of_memory  // the memory was
};

/// "answered", "threw", "crashed", "hung", "out of memory".
std::string to_string(End end);

struct Report {
  End end = End::answered;
  int signal = 0;          // that ended the process; 0 if none did
  std::string answer;      // of a task that answered or threw
  std::string last_words;  // the last 4 kB that the task wrote to stderr
  double seconds = 0.0;    // processor time, as far as it was seen; no two runs take the same
};

/// Called in a worker process with the input of a task; returns its answer.
using Task = std::function<std::string(const std::string& input)>;
/// The next input, or nothing at the end.
using Source = std::function<std::optional<std::string>()>;
/// Called in the order of the inputs, counted from 0.
using Sink = std::function<void(std::size_t number, const Report& report)>;

/// A task with limits of its own.
struct Assignment {
  std::string input;
  Limits limits;
};
using AssignmentSource = std::function<std::optional<Assignment>()>;

/// Who looks on: called as things happen, whatever the order of the tasks. Tasks are counted from 0 as they are given.
struct Watch {
  std::function<void(std::size_t number)> started;
  std::function<void(std::size_t number, const Report& report)> ended;
  std::function<void()> waited;  // many times a second
};

/// A number of worker processes, each of which does many tasks, one after the other; one that ends is replaced. What is
/// reported does not depend on their number. Processes are forked when they are first needed: the process that owns the
/// pool must have no other threads then.
class Pool {
 public:
  Pool(Task task, int workers, Limits limits);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  /// Does all tasks of the source. Throws std::system_error if no process can be made.
  void run(const Source& next, const Sink& done);

  /// Does each task of the source in a process of its own that ends with it, under the task's limits instead of the
  /// pool's. Reports come when tasks end, so that nothing waits for a long task before it. The source is asked when a
  /// process can be had. Throws std::system_error if none can be made.
  void run_apart(const AssignmentSource& next, const Watch& watch);

 private:
  class Crew;
  std::unique_ptr<Crew> crew_;
};

}  // namespace concord::compare::workers
