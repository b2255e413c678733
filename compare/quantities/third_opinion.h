#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compare/audit/digits.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/quantity.h"

namespace concord {
struct Evaluation;
struct State;
}  // namespace concord

/// Somebody else's program, asked what it finds in the states that both solvers were given.
namespace concord::compare {

struct SharedState;

/// Another program's mechanics, bound to one model. The laws of forces are not its own: it is told what they exert.
class ThirdOpinion {
 public:
  virtual ~ThirdOpinion() = default;

  /// "simbody".
  [[nodiscard]] virtual std::string_view name() const = 0;

  /// Accelerations, reactions, total wrenches, forces on joint speeds and of couplings in a closed state, as
  /// Solver::evaluate gives them. Throws SolverError where the other program fails in that state.
  virtual Evaluation evaluate(const State& state) = 0;
};

/// Digits that a component must share with the third opinion, unless the model needs fewer at the same state.
inline constexpr double kThirdNeed = 9.0;

/// How far two of three programs agree on one component. `unexplained`: of what exceeds round-off; this is judged.
struct Accord {
  double digits = kMostDigits;
  double unexplained = kMostDigits;
};

/// Who is off, by two votes against one.
enum class Blame { nobody, cartesian, relative, third, unclear };

/// One component as three programs see it, over the states in which it is judged.
struct ThirdRow {
  Quantity quantity;
  double scale = 0.0;              // in the quantity's unit
  double need = kThirdNeed;        // of the third opinion with both solvers
  double solvers_need = 0.0;       // of both solvers with each other
  std::array<Accord, 2> shared;    // of cartesian, and of relative, with the third opinion
  Accord between;                  // of cartesian with relative
  double t = 0.0;                  // of the largest difference [s]
  std::array<double, 3> values{};  // there: cartesian, relative, third

  [[nodiscard]] double digits() const { return std::min(shared[0].digits, shared[1].digits); }
};

/// Where the solvers agree, the third opinion is off if it shares too few digits with them. Where they differ, the one
/// is off that the third opinion is further from than the other by as much as they differ; unclear if neither is.
Blame blame_in(const ThirdRow& row);

/// All that the third opinion said of one model.
struct ThirdReport {
  std::string name;
  std::string not_expressible;  // why it was not asked; empty if it was
  int states = 0;               // in which it answered
  int failed = 0;               // in which it could not
  std::string first_failure;
  std::vector<ThirdRow> rows;  // those that are judged in any state, in the order of the layout

  /// The worst digits with both solvers of rows of a kind; missing where there is none.
  [[nodiscard]] std::optional<double> digits(Kind kind) const;
};

/// Asks for each of the states that both solvers have evaluated. Force elements are left out: their laws are not the
/// third opinion's own. `budget` has a column for each state.
ThirdReport ask_third(const QuantityLayout& layout, ThirdOpinion& third, const std::vector<SharedState>& states,
                      const Budget& budget);

}  // namespace concord::compare
