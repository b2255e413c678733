#include "relative/run/drift_watch.h"

namespace concord::relative {

namespace {

constexpr int kSteps = 100;
/// Of allowed errors in each step: integration leaves less than one.
constexpr double kNoError = 1e3;
/// Of the way: where this is more, steps become short; round-off is less but in steps of nothing.
constexpr double kPartOfWay = 1e-7;

}  // namespace

DriftWatch::DriftWatch(Eigen::Index size) : before_(VecX::Zero(size)), taken_(VecX::Zero(size)) {}

bool DriftWatch::pass(const VecX& reached, const Eigen::Ref<const VecX>& projected, const VecX& weights) {
  if (steps_ == kSteps) {
    taken_.setZero();
    way_ = 0.0;
    steps_ = 0;
  }
  taken_ += (projected - reached).cwiseProduct(weights);
  way_ += (projected - before_).cwiseProduct(weights).norm();
  before_ = projected;
  if (++steps_ < kSteps) return true;
  return taken_.norm() < kNoError * kSteps || part() < kPartOfWay;
}

}  // namespace concord::relative
