#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/read_back/read_back.h"

/// The numbers of a run by joint, side and component, with NaN where they are not unique: found here once more.
namespace concord::read_back {

inline constexpr std::array<const char*, 6> kComponents{"F_x", "F_y", "F_z", "T_x", "T_y", "T_z"};
inline constexpr std::array<const char*, 2> kSides{"parent", "child"};

inline const char* unit_of_component(std::size_t component) { return component < 3 ? "N" : "N m"; }

/// Units of the coordinates, the speeds, and the forces on the speeds of a joint.
struct JointUnits {
  std::vector<std::string> q;
  std::vector<std::string> u;
  std::vector<std::string> tau;
};
JointUnits units_of(const Joint& joint);

/// Whether driver, motor, spring and damper act on each speed of a joint; laws of force by their parts.
std::vector<std::array<bool, 4>> actors_of(const Joint& joint);
inline constexpr std::array kActorNames{"driver", "motor", "spring", "damper"};

/// Whether a force element has an end on this side: a load and a tire have none on the parent.
bool has_end(const ForceElement& element, std::size_t side);

/// Wrenches of a joint that files hold.
enum class Which { reaction, total };
enum class Axes { joint, global };

class Expected {
 public:
  explicit Expected(const Run& run);

  [[nodiscard]] const Run& run() const { return run_; }
  [[nodiscard]] std::size_t samples() const { return run_.trajectory.samples.size(); }
  [[nodiscard]] const Sample& sample(std::size_t k) const { return run_.trajectory.samples[k]; }

  /// The solver's own number.
  [[nodiscard]] double own(Which which, Axes axes, std::size_t k, std::size_t joint, std::size_t side,
                           std::size_t component) const;
  /// NaN where it is not unique; so are the next two.
  [[nodiscard]] double known(Which which, Axes axes, std::size_t k, std::size_t joint, std::size_t side,
                             std::size_t component) const;
  [[nodiscard]] double known_tau(std::size_t k, std::size_t joint, std::size_t speed) const;
  /// What of it one actor exerts.
  [[nodiscard]] double known_share(std::size_t k, std::size_t joint, std::size_t speed, std::size_t actor) const;
  [[nodiscard]] double known_coupling(std::size_t k, std::size_t coupling) const;
  /// Whether a component in the joint's frame is unique.
  [[nodiscard]] bool is_unique(Which which, std::size_t k, std::size_t joint, std::size_t side,
                               std::size_t component) const;

 private:
  [[nodiscard]] bool may_be_open(Which which, std::size_t joint, std::size_t side, std::size_t component) const;
  [[nodiscard]] bool flag(std::size_t row, std::size_t k) const;

  Run run_;
  std::vector<std::vector<std::array<int, 4>>> share_rows_;  // likewise of each actor there, where others act too
  std::vector<std::vector<int>> tau_rows_;  // of each joint: a row for each speed on which something acts, else -1
  std::size_t first_coupling_ = 0;
};

/// What in the CSV files, and in the NetCDF file, of a run is not that run.
std::vector<std::string> unlike_csv_files(const std::filesystem::path& folder, const Expected& expected);
std::vector<std::string> unlike_netcdf(const std::filesystem::path& path, const Expected& expected);

/// Whether two numbers are one, or none both.
bool is_same(double one, double other);

/// Complaints about one file: a few for each, the rest counted.
class Complaints {
 public:
  explicit Complaints(std::string file) : file_(std::move(file)) {}

  void add(const std::string& what);
  void expect(bool holds, const std::string& what) {
    if (!holds) add(what);
  }
  [[nodiscard]] std::vector<std::string> all() const;

 private:
  std::string file_;
  std::vector<std::string> told_;
  std::size_t more_ = 0;
};

}  // namespace concord::read_back
