#pragma once

#include <string>

#include "relative/rank/scaled_closure.h"

namespace concord::relative {

/// The start of a machine, read from its model.
class Start {
 public:
  /// The closure must outlive this object.
  explicit Start(const ScaledClosure& scaled) : scaled_(&scaled) {}

  /// Kept and driven values exactly, modal values as given, everything else by Newton's method from the model's
  /// guesses; whole turns are counted apart from then on. Throws InputError, naming the joints, if the kept values are
  /// too many, too few, dependent or contradictory, and naming body and axis if the opened tree lacks inertia.
  [[nodiscard]] Coordinates find() const;
  /// Whether the last start that was found lies where another guess than the model's has led to.
  [[nodiscard]] bool has_searched() const { return has_searched_; }

 private:
  [[nodiscard]] Coordinates guess() const;
  void measure_unsaid(Coordinates& coordinates) const;
  [[nodiscard]] PrescribedMask kept(StartRole WordStart::*role) const;
  void add_turns_of_couplings(Coordinates& coordinates, const PrescribedMask& prescribed) const;
  void require_independent(const Coordinates& coordinates, const PrescribedMask& prescribed, ClosureRows rows) const;
  [[nodiscard]] const char* idle_turn(const PrescribedMask& prescribed) const;
  void require_number_of_kept(const Coordinates& coordinates, const PrescribedMask& prescribed, ClosureRows rows) const;
  [[noreturn]] void throw_not_closing(const Coordinates& guess, const PrescribedMask& prescribed,
                                      bool closes_unkept) const;
  void choose_branches(Coordinates& closed, const Coordinates& said, const PrescribedMask& prescribed_q,
                       const PrescribedMask& prescribed_u) const;
  void require_kept(const Coordinates& closed, const Coordinates& said) const;
  void require_inertia(const Coordinates& coordinates) const;
  [[nodiscard]] std::string names_of_kept(const PrescribedMask& prescribed) const;
  [[nodiscard]] std::string couplings_of_kept(const PrescribedMask& prescribed) const;
  [[nodiscard]] SourceLocation where_kept(const PrescribedMask& prescribed) const;

  const ScaledClosure* scaled_;
  mutable bool has_searched_ = false;
};

}  // namespace concord::relative
