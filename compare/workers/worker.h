#pragma once

#include <sys/types.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "compare/workers/pool.h"

/// One worker process as its owner sees it.
namespace concord::compare::workers {

class Worker {
 public:
  /// Starts the process. `to_close` are descriptors of the owner that it must not keep open. Throws std::system_error.
  Worker(const Task& task, const Limits& limits, const std::vector<int>& to_close);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Hands out a task; the worker is idle.
  void give(std::size_t number, const std::string& input);

  [[nodiscard]] bool is_busy() const { return busy_; }
  [[nodiscard]] bool has_ended() const { return ended_; }
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] int answers() const { return answers_; }
  [[nodiscard]] int words() const { return words_; }

  /// Reads what has come; the report once the task is over. After the end of the process the worker is of no use.
  std::optional<Report> look();

 private:
  [[nodiscard]] bool is_over_time();
  void hear_words();
  bool hear_answers();
  std::optional<Report> take_report();
  Report report_end(bool killed_for_time);
  void kill_and_wait(int& status);

  Limits limits_;
  pid_t process_ = -1;
  int answers_ = -1;  // socket: tasks out, answers in
  int words_ = -1;    // pipe: what the worker says on stderr
  bool busy_ = false;
  bool ended_ = false;
  std::size_t number_ = 0;
  double started_processor_ = 0.0;
  double used_ = 0.0;           // processor time of the task when it was last looked at
  double seen_used_ = 0.0;      // processor time at the last progress
  double progress_wall_ = 0.0;  // and when that was
  std::string received_;
  std::string last_words_;
};

}  // namespace concord::compare::workers
