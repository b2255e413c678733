#pragma once

#include <arkode/arkode.h>

#include <memory>

/// The explicit Runge-Kutta pair that the solver integrates with.
namespace concord::relative {

struct FreeButcherTable {
  void operator()(ARKodeButcherTable table) const { ARKodeButcherTable_Free(table); }
};
using ButcherTable = std::unique_ptr<ARKodeButcherTableMem, FreeButcherTable>;

/// Prince and Dormand's RK8(7)13M, 13 stages, order 8 with an embedded solution of order 7 (J. Comp. Appl. Math. 7
/// (1981) 67, table 2).
///
/// Fehlberg's pair of the same orders, which ARKODE brings, estimates its error from rates at the two ends of a step
/// alone. Where rates depend on time only, as the power of a driver that moves its bodies by a law, that estimate is
/// zero whatever the error: work would be wrong and nothing would tell.
ButcherTable prince_dormand();

}  // namespace concord::relative
