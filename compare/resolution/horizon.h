#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/quantities/needs.h"
#include "compare/resolution/run_pairs.h"

/// The comparability horizon of a sensitive motion: how long two integrations of it can agree at all. It is taken from
/// each solver alone, from two of its own runs with neighbouring starts, never from what the solvers differ by. Needed
/// by data/models/double_pendulum_3d.toml over 12 s: without it none of them is judged.
namespace concord::compare {

/// The solvers' horizons agree within this part of the longer one, or a sample.
inline constexpr double kSameHorizon = 0.2;

/// By what factor a small displacement of the start has grown at most until each sample of a run: the largest over the
/// bodies of the distance of their origins (by the machine's length) and of the angle between them [rad].
struct Growth {
  std::vector<double> times;  // [s]
  std::vector<double> factors;

  /// The number of samples, from the first, in which nothing has grown by more than `allowed`.
  [[nodiscard]] int samples_within(double allowed) const;
};

/// Integrates once more, from a start beside that of `run`, which the solver integrated with the same options:
/// displaced along what the constraints permit by `size` (of the machine's length, or rad) in a direction that is the
/// same for every solver. Nothing if the machine has no freedom, or if the solver does not finish that run.
std::optional<Growth> measure_growth(const Model& model, Solver& solver, const RunOptions& options,
                                     const Trajectory& run, double size, std::uint64_t seed);

/// How much a displacement of the start may grow while an integration of relative tolerance `rtol` keeps `need` digits,
/// with a margin for the errors of all its steps.
double allowed_growth(double rtol, double need);

/// What both solvers say of the horizon.
struct Horizon {
  double growth = 0.0;            // that is allowed within it
  int samples = 0;                // judged, from the first: those of the shorter one
  std::array<double, 2> times{};  // the last of each solver's [s]
  bool agree = false;             // within kSameHorizon
};
/// Nothing if either does not see its motion part within the run.
std::optional<Horizon> find_horizon(const std::array<Growth, 2>& growths, double allowed);

/// How sensitive both solvers find a machine's motion. Each integrates once more, when it is measured.
class Sensitivity {
 public:
  Sensitivity(const Model& model, const std::array<Solver*, 2>& solvers, std::uint64_t seed)
      : model_(model), solvers_(solvers), seed_(seed) {}

  [[nodiscard]] bool is_measured() const { return is_measured_; }
  /// Takes the growth beside complete runs, each with the integrator named; `need`: digits that they have to keep.
  void measure(const RunPair& pair, const std::array<std::string, 2>& integrators, double need);
  /// Nothing if the motion does not part within the runs that were measured, or if that is not known.
  [[nodiscard]] std::optional<Horizon> horizon(double rtol, double need) const;

 private:
  const Model& model_;
  std::array<Solver*, 2> solvers_;
  std::uint64_t seed_;
  bool is_measured_ = false;
  std::optional<std::array<Growth, 2>> growths_;
};

/// A failure where the solvers disagree on a horizon, and a note where they agree; `run` was judged up to there.
std::string disagreement_on(const Horizon& horizon, Check check);
std::string note_on(const Horizon& horizon, Check check, const RunOptions& run, double need);

}  // namespace concord::compare
