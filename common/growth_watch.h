#pragma once

#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"

namespace concord {

/// Sees from sample to sample of a run where its motion has grown beyond all that the model can mean: modes stand for
/// small deflections, and a body that is pushed the harder the farther it is leaves every length behind.
class GrowthWatch {
 public:
  /// From the first state of a run on.
  GrowthWatch(const Model& model, const State& start);

  /// The motion has come to a state. Throws SolverError in the name of `solver` where a mode deflects its body by more
  /// than ten times the body's size and the machine's length, or where a body stands farther from its start than 1e30 lengths of the machine;
  /// tells of which body and mode, since when and how much.
  void follow(const State& state, std::string_view solver);

 private:
  /// Whatever is watched: how large it is, of its limit, and since when it has been above a hundredth of that.
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
    Watched place;
    std::vector<Watched> modes;
  };

  const Model& model_;
  double length_;
  std::vector<WatchedBody> bodies_;  // ground included
};

}  // namespace concord
