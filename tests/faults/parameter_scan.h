#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/quantities/align.h"
#include "compare/states/states.h"

/// How small a slip in one parameter of one solver may be and still be seen at the same state.
namespace concord::compare {

/// A slip in one parameter, by a size relative to the parameter (places: relative to the machine's length).
struct ParameterFault {
  std::string name;
  std::function<void(Model&, double size)> change;
};

/// Slips that leave every closed state closed: masses, centres, inertias, modal data, laws and places of forces,
/// gravity.
std::vector<ParameterFault> parameter_faults(const Model& model);

/// Whether the comparator calls the two solvers different at these states.
bool differs_at_same_state(const Model& model, const std::array<Solver*, 2>& solvers,
                           const std::vector<OwnedState>& states);

class ParameterScan {
 public:
  /// Makes the states: a short run of the model, and neighbours of it.
  explicit ParameterScan(const Model& model);

  /// The sound solvers' largest ratio of a difference to its resolution, its median and 99 % quantile, and the fewest
  /// resolvable digits of a reaction or element, as text.
  std::string ratios();

  bool is_seen(const ParameterFault& fault, Who faulty, double size);

  /// The smallest size on a grid of four to a decade, between 1e-16 and 1e-2, at which the slip is seen; nothing if not
  /// even the largest is.
  std::optional<double> smallest_seen(const ParameterFault& fault, Who faulty);

 private:
  const Model& model_;
  std::array<std::unique_ptr<Solver>, 2> solvers_;
  std::vector<OwnedState> states_;
};

}  // namespace concord::compare
