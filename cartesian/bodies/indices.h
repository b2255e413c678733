#pragma once

#include <compare>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/model.h"

/// Where things stand in the machine. Each kind of thing has indices of its own type: none is taken for that of another
/// kind or for a number, nor a number for one of them.
namespace concord::cartesian {

/// The place of a thing among all of its kind. It becomes a number where `value` is asked for, and nowhere else.
template <class Thing>
struct IndexOf {
  int value = 0;

  constexpr IndexOf() = default;
  constexpr explicit IndexOf(int place) : value(place) {}

  friend constexpr auto operator<=>(IndexOf, IndexOf) = default;  // NOLINT(modernize-use-nullptr): the compiler's own
};

using BodyIndex = IndexOf<Body>;                         // in Model::bodies, of which the first is ground
using JointIndex = IndexOf<Joint>;                       // in Model::joints
using CouplingIndex = IndexOf<Coupling>;                 // in Model::couplings
using ElementIndex = IndexOf<ForceElement>;              // in Model::elements, tires among them
using AppliedForceIndex = IndexOf<struct AppliedForce>;  // in AppliedForces::applied_forces()
using RowIndex = IndexOf<struct ConstraintRow>;          // in residuals, gamma and multipliers of the whole machine

/// A row among those of the machine, from the first of its joint or block and its place among theirs, which is a plain
/// number.
constexpr RowIndex operator+(RowIndex first, int own) { return RowIndex(first.value + own); }

constexpr bool is_ground(BodyIndex body) { return body.value == kGround; }
inline BodyIndex body_of(const Attachment& attachment) { return BodyIndex(attachment.body); }

/// Things that follow each other, to be walked through by a range-based for.
template <class Index>
class IndexRange {
 public:
  class Iterator {
   public:
    explicit constexpr Iterator(Index at) : at_(at) {}
    constexpr Index operator*() const { return at_; }
    constexpr Iterator& operator++() {
      ++at_.value;
      return *this;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    Index at_;
  };

  constexpr IndexRange(Index first, int n) : first_(first), n_(n) {}
  [[nodiscard]] constexpr Iterator begin() const { return Iterator(first_); }
  [[nodiscard]] constexpr Iterator end() const { return Iterator(Index(first_.value + n_)); }

 private:
  Index first_;
  int n_;
};
using RowRange = IndexRange<RowIndex>;

/// Of what the model states, one after the other: for (const JointIndex k : indices_of(model.joints)).
template <class Thing>
IndexRange<IndexOf<Thing>> indices_of(const std::vector<Thing>& stated) {
  return {IndexOf<Thing>(0), static_cast<int>(stated.size())};
}

/// What the model states of one thing: pick(model.joints, k).
template <class Thing>
const Thing& pick(const std::vector<Thing>& stated, IndexOf<Thing> at) {
  return stated[at.value];
}

/// A value for each thing of a kind, found by an index of that kind alone.
template <class Index, class Value>
class Table {
 public:
  Table() = default;
  explicit Table(std::size_t n, const Value& value = Value()) : values_(n, value) {}

  [[nodiscard]] Value& operator[](Index at) { return values_[at.value]; }
  [[nodiscard]] const Value& operator[](Index at) const { return values_[at.value]; }
  [[nodiscard]] int size() const { return static_cast<int>(values_.size()); }
  [[nodiscard]] IndexRange<Index> indices() const { return {Index(0), size()}; }

  /// Takes the next index, which is returned.
  Index add(Value value) {
    values_.push_back(std::move(value));
    return Index(size() - 1);
  }

  [[nodiscard]] auto begin() { return values_.begin(); }
  [[nodiscard]] auto end() { return values_.end(); }
  [[nodiscard]] auto begin() const { return values_.begin(); }
  [[nodiscard]] auto end() const { return values_.end(); }

 private:
  std::vector<Value> values_;
};

template <class Value>
using ByBody = Table<BodyIndex, Value>;
template <class Value>
using ByJoint = Table<JointIndex, Value>;
template <class Value>
using ByCoupling = Table<CouplingIndex, Value>;
template <class Value>
using ByAppliedForce = Table<AppliedForceIndex, Value>;

}  // namespace concord::cartesian
