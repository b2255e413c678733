#pragma once

#include <cstddef>

/// Indices of different things, which the compiler does not let be taken for each other.
namespace concord::relative {

/// The index of one kind of thing. It is read as a number wherever one is wanted, but a number, or an index of another
/// kind, becomes one only where that is said.
template <class Kind>
class Index {
 public:
  constexpr Index() = default;
  explicit constexpr Index(int value) : value_(value) {}
  explicit constexpr Index(std::size_t value) : value_(static_cast<int>(value)) {}
  template <class Other>
  explicit Index(Index<Other>) = delete;

  [[nodiscard]] constexpr int value() const { return value_; }
  constexpr operator int() const { return value_; }  // NOLINT(google-explicit-constructor): numbers are read freely
  constexpr Index& operator++() {
    ++value_;
    return *this;
  }

 private:
  int value_ = 0;
};

template <class One, class Other>
bool operator==(Index<One>, Index<Other>) = delete;
template <class Kind>
constexpr bool operator==(Index<Kind> a, Index<Kind> b) {
  return a.value() == b.value();
}

using BodyIndex = Index<struct BodyKind>;    // in Model::bodies
using JointIndex = Index<struct JointKind>;  // in Model::joints
using LinkIndex = Index<struct LinkKind>;    // in Topology::links
using CutIndex = Index<struct CutKind>;      // in Topology::cuts and Closure::cuts
using RowIndex = Index<struct RowKind>;      // of the closure

/// Indices of a kind one after the other, up or down.
template <class One>
class IndexRange {
 public:
  class Iterator {
   public:
    constexpr Iterator(int at, int step) : at_(at), step_(step) {}
    constexpr One operator*() const { return One(at_); }
    constexpr Iterator& operator++() {
      at_ += step_;
      return *this;
    }
    constexpr bool operator!=(Iterator other) const { return at_ != other.at_; }

   private:
    int at_;
    int step_;
  };

  constexpr IndexRange(int begin, int end, int step) : begin_(begin), end_(end), step_(step) {}
  [[nodiscard]] constexpr Iterator begin() const { return {begin_, step_}; }
  [[nodiscard]] constexpr Iterator end() const { return {end_, step_}; }

 private:
  int begin_;
  int end_;
  int step_;
};

/// The indices of n things, in order: for (const LinkIndex l : upward<LinkIndex>(n)).
template <class One>
constexpr IndexRange<One> upward(std::size_t n) {
  return {0, static_cast<int>(n), 1};
}

/// The same from the last one to the first.
template <class One>
constexpr IndexRange<One> downward(std::size_t n) {
  return {static_cast<int>(n) - 1, -1, -1};
}

}  // namespace concord::relative
