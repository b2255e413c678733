#include "compare/page/thinning.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace concord::compare::page {

Bins::Bins(std::size_t samples, std::size_t points)
    : samples_(samples), count_(samples <= points ? samples : std::max<std::size_t>(1, points / 2)) {}

std::vector<double> thin_times(const Bins& bins, const std::vector<double>& t) {
  if (!bins.thins()) return t;
  std::vector<double> times;
  for (std::size_t bin = 0; bin < bins.count(); ++bin) {
    times.push_back(t[bins.begin(bin)]);
    // A bin of one sample has two points at one place.
    times.push_back(t[bins.end(bin) - 1]);
  }
  return times;
}

std::vector<double> thin(const Bins& bins, const ValueAt& value) {
  std::vector<double> points;
  for (std::size_t bin = 0; bin < bins.count(); ++bin) {
    if (!bins.thins()) {
      points.push_back(value(bin));
      continue;
    }
    double least = std::numeric_limits<double>::quiet_NaN();
    double largest = least;
    bool least_comes_first = true;
    for (std::size_t k = bins.begin(bin); k < bins.end(bin); ++k) {
      const double here = value(k);
      if (std::isnan(here)) continue;
      if (!(here >= least)) {
        least_comes_first = std::isnan(least);
        least = here;
      }
      if (!(here <= largest)) {
        least_comes_first = true;
        largest = here;
      }
    }
    points.push_back(least_comes_first ? least : largest);
    points.push_back(least_comes_first ? largest : least);
  }
  return points;
}

std::vector<double> largest_sizes(const Bins& bins, const ValueAt& value) {
  std::vector<double> sizes;
  for (std::size_t bin = 0; bin < bins.count(); ++bin) {
    double largest = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t k = bins.begin(bin); k < bins.end(bin); ++k) {
      const double size = std::abs(value(k));
      if (!std::isnan(size) && !(size <= largest)) largest = size;
    }
    sizes.push_back(largest);
  }
  return sizes;
}

}  // namespace concord::compare::page
