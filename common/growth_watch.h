#pragma once

#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"

namespace concord {

/// Sees from sample to sample of a run where its motion has grown beyond all that the model can mean: modes stand for
/// small deflections, and a body that is pushed the harder the farther it is leaves every length behind. A long flight
/// does not grow so.
class GrowthWatch {
 public:
  /// From the first state of a run on.
  GrowthWatch(const Model& model, const State& start);

  /// The motion has come to a state. Throws SolverError in the name of `solver` where a mode deflects its body by more
  /// than ten times the body's size and the machine's length, or where a body stands farther from its start than 1e10
  /// lengths of the machine and 1e4 times what it had come to in half the time; tells of which body and mode, since
  /// when and how much.
  void follow(const State& state, std::string_view solver);

 private:
  /// A mode: how large it is, of its limit, and since when it has been above a hundredth of that.
  struct Watched {
    double per_unit = 0.0;
    double since = 0.0;  // s
    bool is_large = false;

    /// The part of the limit that `amount` is.
    double follow(double amount, double t);
  };
  struct WatchedBody {
    Vec3 start;
    double size = 0.0;  // undeformed, m
    std::vector<Watched> modes;
    std::vector<double> farthest;  // from the start, by state so far, m
  };

  void follow_place(std::size_t i, const State& state, std::string_view solver);

  const Model& model_;
  double length_;
  std::vector<WatchedBody> bodies_;  // ground included
  std::vector<double> times_;        // s
};

}  // namespace concord
