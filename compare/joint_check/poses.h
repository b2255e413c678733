#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "common/joints/joint_type.h"
#include "common/types.h"

/// Generic poses of a joint type from a seed, each reproducible by itself.
namespace concord::compare::joint_check {

using joints::JointType;

/// A reproducible source of numbers in [-1, 1].
class Numbers {
 public:
  /// The same two numbers give the same sequence on every machine.
  Numbers(std::uint32_t seed, std::uint32_t stream);

  double operator()();
  Vec3 vector(double size);
  VecX vector(Eigen::Index n, double size);
  Mat3X columns(Eigen::Index n, double size);
  Mat3 rotation();

 private:
  std::mt19937 engine_;
};

/// Where one coordinate of a type stands among its numbers, and where it may be.
struct Coordinate {
  int word = 0;       // of the type's motion
  int component = 0;  // of the word
  int q = 0;          // index among the type's q
  int u = 0;          // and u
  bool is_turn = false;
  double least = 0.0;  // rad or m
  double greatest = 0.0;
};

/// The coordinates of a type that are one number each: those that a law can drive or a spring can hold. Turns range
/// over several turns, slides over 0.4 m to both sides, elevations over less than a right angle, motions by functions
/// over what they say.
std::vector<Coordinate> coordinates_of(const JointType& type);

/// Coordinates, speeds and nothing else: a pose of the motion alone.
struct MotionPose {
  int number = 0;
  VecX q;
  VecX u;
};

/// Draws poses away from those where the motion loses rank: the smallest singular value of S is at least a fifth of
/// what it is at the median pose.
class PoseSource {
 public:
  PoseSource(const JointType& type, std::uint32_t seed);

  /// Pose `number` of the seed, whatever was asked before.
  [[nodiscard]] MotionPose pose(int number) const;

  /// Whether the motion keeps its rank at q.
  [[nodiscard]] bool is_regular(const VecX& q) const;

  /// Any q in range.
  [[nodiscard]] VecX draw_q(Numbers& numbers) const;

 private:
  const JointType* type_;
  std::uint32_t seed_;
  std::vector<Coordinate> coordinates_;
  double least_rank_value_ = 0.0;
};

/// A speed of a joint whose value is known.
struct SpeedValue {
  int speed = 0;
  double value = 0.0;
};

/// The speeds nearest to u that the type permits at q, the known ones exactly; u itself for a type that forbids no
/// velocity alone.
VecX nearest_possible(const JointType& type, const VecX& q, const VecX& u, const std::vector<SpeedValue>& known = {});

/// Smallest singular value of the columns S at q; 1 if the type permits nothing.
double rank_value(const JointType& type, const VecX& q);

/// Streams of numbers of one seed, so that nothing that is drawn depends on what else is.
namespace streams {
inline constexpr std::uint32_t kRig = 1;
inline constexpr std::uint32_t kMedian = 2;
inline constexpr std::uint32_t kFirstPose = 1000;
inline constexpr std::uint32_t kFirstState = 1000000;
inline constexpr std::uint32_t kFirstDisturbance = 2000000;
}  // namespace streams

}  // namespace concord::compare::joint_check
