#include "compare/verdict/turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

namespace concord::compare {
namespace {

TEST(Turns, ComeInTheOrderInWhichTheyWereTakenWhoeverWaitsFirst) {
  Turns turns(1);
  constexpr int kThreads = 6;
  std::vector<int> order;
  std::vector<int> places;
  for (int k = 0; k < kThreads; ++k) places.push_back(turns.take());
  std::vector<std::thread> threads;
  for (int k = kThreads - 1; k >= 0; --k) {
    threads.emplace_back([&turns, &order, place = places[static_cast<std::size_t>(k)]] {
      const Turns::Held turn(turns, place);
      order.push_back(place);  // one at a time
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(order, places);
}

TEST(Turns, SoManyAreHeldAtATime) {
  Turns turns(2);
  std::atomic<int> at_a_time = 0;
  std::atomic<int> most = 0;
  std::vector<std::thread> threads;
  for (int k = 0; k < 8; ++k) {
    threads.emplace_back([&, place = turns.take()] {
      const Turns::Held turn(turns, place);
      const int now = ++at_a_time;
      for (int before = most; now > before && !most.compare_exchange_weak(before, now);) continue;
      std::this_thread::yield();
      --at_a_time;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(most, 2);
  EXPECT_GE(most, 1);
  EXPECT_GE(count_processors(), 1);
}

}  // namespace
}  // namespace concord::compare
