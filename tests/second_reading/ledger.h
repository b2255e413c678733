#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/types.h"
#include "tests/second_reading/second_reading.h"

namespace concord::second_reading {

/// Where a file states something.
struct Entry {
  std::string where;
  std::string key;
  int line = 0;
  std::string file = {};
  /// The largest number in the expressions that state it, whose sums know no more; asked where something differs.
  std::function<double()> terms = {};
};

/// What two evaluations of the same expressions may differ by, in parts of the largest number of a group, and of the
/// largest number in an expression.
inline constexpr double kRoundOff = 1e-11;
inline constexpr double kRoundOffOfTerms = 1e-14;

/// A list of numbers as a column.
VecX column_of(const std::vector<double>& numbers);

/// Keeps what was held and what differs.
class Ledger {
 public:
  /// A group of numbers of one unit. `allowed` is in parts of `scale`; without one, of the largest of them.
  void numbers(const Entry& entry, const MatX& read, const MatX& stated, double allowed = kRoundOff,
               double scale = 0.0);
  void number(const Entry& entry, double read, double stated);
  /// A name, or another word.
  void word(const Entry& entry, const std::string& read, const std::string& stated);
  /// Whether both the model has something and the file states it; only one of them is a difference.
  bool both_have(const Entry& entry, bool read, bool stated);

  /// What of the file cannot be held.
  void leave(const std::string& where, const std::string& what);

  /// What was found, worst first.
  [[nodiscard]] SecondReading result() &&;

 private:
  SecondReading found_;
};

}  // namespace concord::second_reading
