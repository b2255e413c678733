#include "compare/workers/pool.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "compare/workers/worker.h"

namespace concord::compare::workers {

std::string to_string(End end) {
  constexpr std::array kNames{"answered", "threw", "crashed", "hung", "out of memory"};
  return kNames.at(static_cast<std::size_t>(end));
}

class Pool::Crew {
 public:
  Crew(Task task, int workers, Limits limits)
      : task_(std::move(task)), limits_(limits), workers_(static_cast<std::size_t>(std::max(1, workers))) {}

  void run(const Source& next, const Sink& done) {
    std::optional<std::string> waiting = next();
    std::size_t given = 0;
    std::size_t told = 0;
    std::map<std::size_t, Report> reports;  // that wait for earlier ones
    while (waiting || told < given) {
      while (waiting && give(given, *waiting)) {
        ++given;
        waiting = next();
      }
      wait();
      for (auto& worker : workers_) {
        if (!worker) continue;
        const std::size_t number = worker->number();
        if (auto report = worker->look()) reports.emplace(number, std::move(*report));
        if (worker->has_ended()) worker.reset();
      }
      for (auto first = reports.begin(); first != reports.end() && first->first == told; first = reports.begin()) {
        done(told++, first->second);
        reports.erase(first);
      }
    }
  }

  void run_apart(const AssignmentSource& next, const Watch& watch) {
    for (auto& worker : workers_) worker.reset();
    std::size_t given = 0;
    std::size_t told = 0;
    bool has_more = true;
    while (has_more || told < given) {
      for (auto& worker : workers_) {
        if (worker || !has_more) continue;
        const std::optional<Assignment> assignment = next();
        has_more = assignment.has_value();
        if (!has_more) break;
        worker = std::make_unique<Worker>(task_, assignment->limits, descriptors());
        worker->give(given, assignment->input);
        watch.started(given++);
      }
      wait();
      for (auto& worker : workers_) {
        const auto report = worker ? worker->look() : std::nullopt;
        if (!report) continue;
        const std::size_t number = worker->number();
        worker.reset();
        ++told;
        watch.ended(number, *report);
      }
      watch.waited();
    }
  }

 private:
  /// Whether a worker was free to take the task.
  bool give(std::size_t number, const std::string& input) {
    const auto is_free = [](const std::unique_ptr<Worker>& worker) { return !worker || !worker->is_busy(); };
    const auto found = std::find_if(workers_.begin(), workers_.end(), is_free);
    if (found == workers_.end()) return false;
    if (!*found) *found = std::make_unique<Worker>(task_, limits_, descriptors());
    (*found)->give(number, input);
    return true;
  }

  [[nodiscard]] std::vector<int> descriptors() const {
    std::vector<int> all;
    for (const auto& worker : workers_) {
      if (worker) all.insert(all.end(), {worker->answers(), worker->words()});
    }
    return all;
  }

  /// Until a worker says something, or it is time to look at the clocks.
  void wait() const {
    constexpr int kMilliseconds = 20;
    std::vector<pollfd> watched;
    for (const auto& worker : workers_) {
      if (!worker || !worker->is_busy()) continue;
      watched.push_back({worker->answers(), POLLIN, 0});
      watched.push_back({worker->words(), POLLIN, 0});
    }
    if (!watched.empty()) poll(watched.data(), watched.size(), kMilliseconds);
  }

  Task task_;
  Limits limits_;
  std::vector<std::unique_ptr<Worker>> workers_;
};

Pool::Pool(Task task, int workers, Limits limits) : crew_(std::make_unique<Crew>(std::move(task), workers, limits)) {}
Pool::~Pool() = default;

void Pool::run(const Source& next, const Sink& done) { crew_->run(next, done); }

void Pool::run_apart(const AssignmentSource& next, const Watch& watch) { crew_->run_apart(next, watch); }

}  // namespace concord::compare::workers
