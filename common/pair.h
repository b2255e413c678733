#pragma once

/// Two numbers that one instruction handles. A processor that reads a pair waits long if its halves were stored apart.
namespace concord {

using Pair [[gnu::vector_size(16)]] = double;

/// From and to any address.
[[gnu::always_inline]] inline Pair load_pair(const double* numbers) {
  Pair pair;
  __builtin_memcpy(&pair, numbers, sizeof(pair));
  return pair;
}
[[gnu::always_inline]] inline void store_pair(const Pair& pair, double* numbers) {
  __builtin_memcpy(numbers, &pair, sizeof(pair));
}

}  // namespace concord
