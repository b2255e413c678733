#pragma once

#include <condition_variable>
#include <mutex>
#include <set>

/// Work that is done side by side, on as many processors as there are.
namespace concord::compare {

/// How many processors this process may use, at least one.
int count_processors();

/// Lets threads work in the order in which they took their turns, so many at a time. What they find must not depend on
/// that number.
class Turns {
 public:
  explicit Turns(int at_a_time) : free_(at_a_time) {}

  /// The place of a thread that is to begin later.
  int take();

  /// Holds a turn: waits for it when made, passes it on when it goes.
  class Held {
   public:
    Held(Turns& turns, int place) : turns_(turns) { turns_.wait(place); }
    ~Held() { turns_.pass_on(); }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

   private:
    Turns& turns_;
  };

 private:
  void wait(int place);
  void pass_on();

  std::mutex guard_;
  std::condition_variable changed_;
  int free_;
  int next_ = 0;
  std::set<int> waiting_;
};

}  // namespace concord::compare
