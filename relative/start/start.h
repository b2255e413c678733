#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/start_words.h"
#include "relative/rank/scaled_closure.h"

namespace concord::relative {

/// The start of a machine, read from its model.
class Start {
 public:
  /// The closure must outlive this object.
  explicit Start(const ScaledClosure& scaled) : scaled_(&scaled) {}

  /// Kept and driven values exactly, modal values as given, everything else by Newton's method from the model's
  /// guesses; whole turns are counted apart from then on. Of more kept values than the machine has freedoms the first
  /// independent ones exactly, the others as far as they are written. Throws InputError, naming the joints, if the kept
  /// values are too few, dependent or contradictory, and naming body and axis if the opened tree lacks inertia.
  [[nodiscard]] Coordinates find() const;
  /// Whether the last start that was found lies where another guess than the model's has led to.
  [[nodiscard]] bool has_searched() const { return has_searched_; }

 private:
  /// How many coordinates (rows of positions) or speeds are kept, how many are free, modes not counted, and how many
  /// more may be kept: a ball keeps three speeds or none, also where fewer are free.
  struct KeptCount {
    int kept = 0;
    int freedom = 0;
    int allowed_surplus = 0;
  };

  /// The model, or the one that keeps no more than the machine has freedoms.
  [[nodiscard]] const Model& stated() const { return fewer_ ? *fewer_ : scaled_->equations().model(); }
  [[nodiscard]] Coordinates find_as_said() const;
  [[nodiscard]] KeptCount count_kept(const Coordinates& coordinates, const PrescribedMask& prescribed,
                                     ClosureRows rows) const;
  [[nodiscard]] std::optional<std::vector<StartWord>> first_independent(const Coordinates& closed,
                                                                        ClosureRows rows) const;
  [[nodiscard]] std::optional<Model> without_surplus() const;
  void require_as_written(const Coordinates& start) const;
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
  mutable std::optional<Model> fewer_;  // where the model keeps too many
};

}  // namespace concord::relative
