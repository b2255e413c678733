#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/audit/digits.h"

/// One property of a joint type in plain words, and the worst that was found of it.
namespace concord::compare::joint_check {

struct Property {
  Property(std::string in_words, std::optional<double> needed_digits)
      : name(std::move(in_words)), need(needed_digits) {}

  std::string name;
  /// Digits that must match; missing: it holds or it does not.
  std::optional<double> need;

  double digits = kMostDigits;
  int pose = -1;        // of the worst; -1: at no pose in particular
  std::string where;    // what was found at the worst; empty: nothing wrong at all
  bool looked = false;  // false: there was nothing to look at, such as the readings of a weld

  [[nodiscard]] bool holds() const { return !looked || digits >= need.value_or(kMostDigits); }

  /// Takes note of a relative error (0 where it simply holds); `describe()` says what it is, if it is the
  /// worst so far.
  template <class Describe>
  void note(double error, int at_pose, const Describe& describe) {
    const double found = matching_digits(error, 1.0) + 0.0;  // never minus zero
    const bool first = !looked;
    looked = true;
    if (found == kMostDigits || (!first && found >= digits)) return;
    digits = found;
    pose = at_pose;
    where = describe();
  }

  /// Takes note of something that holds or does not.
  template <class Describe>
  void require(bool holds_here, int at_pose, const Describe& describe) {
    note(holds_here ? 0.0 : 1.0, at_pose, describe);
  }
};

using Properties = std::vector<Property>;

}  // namespace concord::compare::joint_check
