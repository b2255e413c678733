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

struct RangeWriter {
  const joints::Read* reading;
  Coordinate& coordinate;

  void operator()(const joints::Turn&) const {
    const bool rises = reading != nullptr && std::holds_alternative<joints::ElevationOfGap>(*reading);
    reach(true, rises ? kElevationReach : kTurnReach);
  }
  void operator()(const joints::Slide&) const { reach(false, kSlideReach); }
  void operator()(const joints::Arm&) const {}
  void operator()(const joints::Ball&) const {}
  void operator()(const joints::ByMotion& by) const {
    const bool is_turn = by.turns[coordinate.component];
    reach(is_turn, is_turn ? kTurnReach : kSlideReach);
    if (by.ranges.empty()) return;
    coordinate.least = by.ranges[coordinate.component][0];
    coordinate.greatest = by.ranges[coordinate.component][1];
  }

 private:
  void reach(bool is_turn, double to_both_sides) const {
    coordinate.is_turn = is_turn;
    coordinate.least = -to_both_sides;
    coordinate.greatest = to_both_sides;
  }
};

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
    if (std::holds_alternative<joints::Ball>(permit)) continue;
    const int word = static_cast<int>(k);
    for (int c = 0; c < n_u(permit); ++c) {
      Coordinate coordinate{word, c, first_q(type, word) + c, first_u(type, word) + c};
      std::visit(RangeWriter{reading_of(type, k), coordinate}, permit);
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
    if (!std::holds_alternative<joints::Ball>(type_->permits[k])) continue;
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
