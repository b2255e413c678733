#pragma once

#include <compare>

namespace concord::cartesian {

/// A constraint row among those of the whole machine: its place in residuals, gamma and multipliers. Rows among those
/// of one joint or of one block are plain numbers.
struct RowIndex {
  int value = 0;

  constexpr RowIndex() = default;
  constexpr explicit RowIndex(int row) : value(row) {}

  friend constexpr RowIndex operator+(RowIndex first, int own) { return RowIndex(first.value + own); }
  friend constexpr auto operator<=>(RowIndex, RowIndex) = default;
};

/// Rows that follow each other, to be walked through by a range-based for.
class RowRange {
 public:
  class Iterator {
   public:
    explicit constexpr Iterator(RowIndex row) : row_(row) {}
    constexpr RowIndex operator*() const { return row_; }
    constexpr Iterator& operator++() {
      ++row_.value;
      return *this;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    RowIndex row_;
  };

  constexpr RowRange(RowIndex first, int n) : first_(first), n_(n) {}
  [[nodiscard]] constexpr Iterator begin() const { return Iterator(first_); }
  [[nodiscard]] constexpr Iterator end() const { return Iterator(first_ + n_); }

 private:
  RowIndex first_;
  int n_;
};

}  // namespace concord::cartesian
