#include "tests/second_reading/ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace concord::second_reading {

VecX column_of(const std::vector<double>& numbers) {
  return Eigen::Map<const VecX>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

void Ledger::numbers(const Entry& entry, const MatX& read, const MatX& stated, double allowed, double scale) {
  found_.held += static_cast<int>(stated.size());
  StatedValue value{entry.where, entry.key, 0.0, 1.0, "", entry.line, entry.file};
  if (read.rows() != stated.rows() || read.cols() != stated.cols()) {
    value.text =
        fmt::format("read {} x {} numbers, stated {} x {}", read.rows(), read.cols(), stated.rows(), stated.cols());
    value.residual = 1.0;
    found_.differing.push_back(value);
    return;
  }
  if (stated.size() == 0) return;
  value.residual = (read - stated).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  value.scale = scale > 0.0 ? scale : std::max(read.cwiseAbs().maxCoeff(), stated.cwiseAbs().maxCoeff());
  if (!(value.scale > 0.0)) value.scale = 1.0;
  if (value.residual <= allowed * value.scale) return;
  if (entry.terms && value.residual <= kRoundOffOfTerms * entry.terms()) return;
  if (std::isnan(value.residual)) value.residual = std::numeric_limits<double>::infinity();
  found_.differing.push_back(value);
}

void Ledger::number(const Entry& entry, double read, double stated) {
  numbers(entry, MatX::Constant(1, 1, read), MatX::Constant(1, 1, stated));
}

void Ledger::word(const Entry& entry, const std::string& read, const std::string& stated) {
  ++found_.held;
  if (read == stated) return;
  found_.differing.push_back({entry.where, entry.key, 1.0, 1.0, fmt::format("read as '{}', stated '{}'", read, stated),
                              entry.line, entry.file});
}

bool Ledger::both_have(const Entry& entry, bool read, bool stated) {
  if (read != stated) word(entry, read ? "given" : "absent", stated ? "given" : "absent");
  return read && stated;
}

void Ledger::leave(const std::string& where, const std::string& what) {
  found_.not_held.push_back(where + ": " + what);
}

SecondReading Ledger::result() && {
  const auto badness = [](const StatedValue& value) {
    return value.text.empty() ? value.residual / value.scale : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(found_.differing.begin(), found_.differing.end(),
                   [&](const StatedValue& a, const StatedValue& b) { return badness(a) > badness(b); });
  return std::move(found_);
}

}  // namespace concord::second_reading
