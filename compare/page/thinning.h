#pragma once

#include <cstddef>
#include <functional>
#include <vector>

/// Fewer points for the same picture. Samples are put into bins of equal numbers of neighbours; a bin keeps its least
/// and its largest value, in the order in which they come, so that no peak is lost however thin the curve becomes.
namespace concord::compare::page {

/// How a run of `samples` is put into bins. Where all samples fit, each is a point of its own.
class Bins {
 public:
  /// No more than `points` points for `samples` samples, two for each bin; at least one bin.
  Bins(std::size_t samples, std::size_t points);

  [[nodiscard]] std::size_t samples() const { return samples_; }
  [[nodiscard]] bool thins() const { return count_ < samples_; }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Points of a curve: two for each bin, or all samples.
  [[nodiscard]] std::size_t points() const { return thins() ? 2 * count_ : samples_; }
  /// First sample of a bin, and the one after its last.
  [[nodiscard]] std::size_t begin(std::size_t bin) const { return bin * samples_ / count_; }
  [[nodiscard]] std::size_t end(std::size_t bin) const { return begin(bin + 1); }

 private:
  std::size_t samples_;
  std::size_t count_;
};

/// Value of a curve at a sample; NaN where there is none.
using ValueAt = std::function<double(std::size_t sample)>;

/// Abscissae of the points: of a bin its first and its last sample.
std::vector<double> thin_times(const Bins& bins, const std::vector<double>& t);

/// Points of a curve: of a bin its least and its largest value in the order in which they come. NaN where a bin holds
/// no number.
std::vector<double> thin(const Bins& bins, const ValueAt& value);

/// The largest size in each bin, one number for each bin. NaN where a bin holds no number.
std::vector<double> largest_sizes(const Bins& bins, const ValueAt& value);

}  // namespace concord::compare::page
