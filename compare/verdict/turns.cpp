#include "compare/verdict/turns.h"

#include <sched.h>

#include <algorithm>

namespace concord::compare {

int count_processors() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  return sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? std::max(1, CPU_COUNT(&allowed)) : 1;
}

int Turns::take() {
  const std::lock_guard lock(guard_);
  waiting_.insert(next_);
  return next_++;
}

void Turns::wait(int place) {
  std::unique_lock lock(guard_);
  changed_.wait(lock, [&] { return free_ > 0 && *waiting_.begin() == place; });
  --free_;
  waiting_.erase(place);
  changed_.notify_all();
}

void Turns::pass_on() {
  const std::lock_guard lock(guard_);
  ++free_;
  changed_.notify_all();
}

}  // namespace concord::compare
