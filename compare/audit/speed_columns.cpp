#include "compare/audit/speed_columns.h"

namespace concord::compare {

SpeedMatrix nearest_combination(const SpeedColumns& columns, const SpeedColumns& motions) {
  return columns.colPivHouseholderQr().solve(motions);
}

}  // namespace concord::compare
