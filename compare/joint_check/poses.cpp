#include "compare/joint_check/poses.h"

#include <algorithm>

#include "common/decompositions.h"
#include "common/model.h"
#include "common/rotation.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/referee.h"

namespace concord::compare::joint_check {

namespace {

constexpr double kTurnReach = 20.0;      // rad, a little more than three turns to each side
constexpr double kElevationReach = 1.2;  // rad
constexpr double kSlideReach = 0.4;      // m
constexpr double kSpeed = 2.0;           // rad/s, m/s
constexpr double kPartOfMedian = 0.2;
constexpr int kMedianPoses = 101;
constexpr int kMostTries = 1000;

/// How the words that have coordinates read, arms left out: the reading of each word of the motion, or nullptr.
const joints::Read* reading_of(const JointType& type, std::size_t word) {
  std::size_t place = 0;
  for (std::size_t before = 0; before < word; ++before) place += n_q(type.permits[before]) > 0 ? 1 : 0;
  return place < type.reads.size() ? &type.reads[place] : nullptr;
}

/// How far a coordinate reaches to both sides where its word does not say.
double reach_of(joints::CoordinateKind kind, const joints::Read* reading) {
  if (kind == joints::CoordinateKind::length) return kSlideReach;
  return reading != nullptr && is_elevation(*reading) ? kElevationReach : kTurnReach;
}

}  // namespace

Numbers::Numbers(std::uint32_t seed, std::uint32_t stream) {
  std::seed_seq sequence{seed, stream};
  engine_.seed(sequence);
}

double Numbers::operator()() {
  // The standard fixes the engine, but not its distributions.
  const auto high = static_cast<double>(engine_());
  const auto low = static_cast<double>(engine_());
  return (4294967296.0 * high + low) / 9223372036854775808.0 - 1.0;
}

Vec3 Numbers::vector(double size) {
  const double x = (*this)();
  const double y = (*this)();
  const double z = (*this)();
  return size * Vec3(x, y, z);
}

VecX Numbers::vector(Eigen::Index n, double size) {
  VecX v(n);
  for (double& entry : v) entry = size * (*this)();
  return v;
}

Mat3X Numbers::columns(Eigen::Index n, double size) {
  Mat3X m(3, n);
  for (Eigen::Index c = 0; c < n; ++c) m.col(c) = vector(size);
  return m;
}

Mat3 Numbers::rotation() {
  const Vec3 axis = vector(1.0).normalized();
  return rotation_about(axis, 2.5 * (*this)());
}

std::vector<Coordinate> coordinates_of(const JointType& type) {
  std::vector<Coordinate> coordinates;
  for (std::size_t k = 0; k < type.permits.size(); ++k) {
    const joints::Permit& permit = type.permits[k];
    if (is_orientation(permit)) continue;
    const int word = static_cast<int>(k);
    const joints::StatedCoordinates stated = stated_coordinates(permit);
    for (int c = 0; c < stated.size(); ++c) {
      Coordinate coordinate{word, c, first_q(type, word) + c, first_u(type, word) + c};
      coordinate.is_turn = stated[c].kind == joints::CoordinateKind::angle;
      const double reach = reach_of(stated[c].kind, reading_of(type, k));
      coordinate.least = stated[c].range ? (*stated[c].range)[0] : -reach;
      coordinate.greatest = stated[c].range ? (*stated[c].range)[1] : reach;
      coordinates.push_back(coordinate);
    }
  }
  return coordinates;
}

double rank_value(const JointType& type, const VecX& q) {
  if (type.n_u() == 0) return 1.0;
  const VecX u = VecX::Zero(type.n_u());
  const MatX S = referee_permits(type, q, u).S.leftCols(type.n_u());
  return singular_values(S).minCoeff();
}

PoseSource::PoseSource(const JointType& type, std::uint32_t seed)
    : type_(&type), seed_(seed), coordinates_(coordinates_of(type)) {
  Numbers numbers(seed, streams::kMedian);
  std::vector<double> values;
  for (int k = 0; k < kMedianPoses; ++k) values.push_back(rank_value(type, draw_q(numbers)));
  std::nth_element(values.begin(), values.begin() + kMedianPoses / 2, values.end());
  least_rank_value_ = kPartOfMedian * values[kMedianPoses / 2];
}

bool PoseSource::is_regular(const VecX& q) const { return rank_value(*type_, q) >= least_rank_value_; }

VecX PoseSource::draw_q(Numbers& numbers) const {
  VecX q(type_->n_q());
  for (std::size_t k = 0; k < type_->permits.size(); ++k) {
    if (!is_orientation(type_->permits[k])) continue;
    q.segment<4>(first_q(*type_, static_cast<int>(k))) = numbers.vector(4, 1.0).normalized();
  }
  for (const Coordinate& coordinate : coordinates_) {
    const double middle = 0.5 * (coordinate.least + coordinate.greatest);
    q(coordinate.q) = middle + 0.5 * (coordinate.greatest - coordinate.least) * numbers();
  }
  return q;
}

VecX nearest_possible(const JointType& type, const VecX& q, const VecX& u, const std::vector<SpeedValue>& known) {
  if (type.permits_speeds.empty()) return u;
  const joints::FunctionOfCoordinates::Motion motion = referee_permits(type, q, u);
  const MatX free = free_speeds(type, motion.placement.R, motion.S.leftCols(type.n_u()));
  const auto n = free.cols();
  const auto n_known = static_cast<Eigen::Index>(known.size());
  MatX conditions = MatX::Zero(n + n_known, n + n_known);
  VecX right(n + n_known);
  conditions.topLeftCorner(n, n) = free.transpose() * free;
  right.head(n) = free.transpose() * u;
  for (Eigen::Index k = 0; k < n_known; ++k) {
    const SpeedValue& one = known[static_cast<std::size_t>(k)];
    conditions.row(n + k).head(n) = free.row(one.speed);
    conditions.col(n + k).head(n) = free.row(one.speed).transpose();
    right(n + k) = one.value;
  }
  return free * VecX(solve_by_complete_pivoting(conditions, right)).head(n);
}

MotionPose PoseSource::pose(int number) const {
  Numbers numbers(seed_, streams::kFirstPose + static_cast<std::uint32_t>(number));
  MotionPose pose{number, draw_q(numbers), {}};
  for (int tries = 0; tries < kMostTries && !is_regular(pose.q); ++tries) pose.q = draw_q(numbers);
  pose.u = nearest_possible(*type_, pose.q, numbers.vector(type_->n_u(), kSpeed));
  return pose;
}

}  // namespace concord::compare::joint_check
