#include "compare/verdict/near_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/audit/places.h"
#include "compare/verdict/body_frames.h"

namespace concord::compare {

namespace {

constexpr double kFar = 10.0;
constexpr double kFarAway = 1000.0;

/// The mass centre of a body in its frame, and how far its mass lies around it.
struct Midst {
  Vec3 center;
  double size;

  explicit Midst(const Body& body) {
    if (!body.modal) {
      center = body.center_of_mass_L;
      size = body.mass > 0.0 ? std::sqrt(0.5 * body.inertia_L.trace() / body.mass) : 0.0;
      return;
    }
    const MatX& G = body.modal->G;
    center = G(0, 0) > 0.0 ? Vec3(G.block<3, 1>(1, 0) / G(0, 0)) : Vec3::Zero();
    size = 0.0;
    for (const MassPoint& point : body.modal->mass_points) size = std::max(size, (point.s0_L - center).norm());
  }
};

/// How far each body's mass centre lies from its frame, and what the body measures.
std::vector<Midst> midsts_of(const Model& model) {
  std::vector<Midst> midsts;
  for (const Body& body : model.bodies) midsts.emplace_back(body);
  for_each_attachment(model, [&](const Attachment& side) {
    Midst& midst = midsts[static_cast<std::size_t>(side.body)];
    midst.size = std::max(midst.size, (side.point_L - midst.center).norm());
  });
  return midsts;
}

/// Where the machine stands, if that is far away from the world's origin. A road holds the world where it is.
Vec3 far_place_of(const Model& model) {
  std::vector<Vec3> points;
  for_each_attachment(model, [&](const Attachment& side) {
    if (side.body == kGround) points.push_back(side.point_L);
  });
  const auto has_road = [](const ForceElement& element) { return std::holds_alternative<Tire>(element.what); };
  if (points.empty() || std::any_of(model.elements.begin(), model.elements.end(), has_road)) return Vec3::Zero();
  double size = model.length_scale();
  for (const Vec3& point : points) size = std::max(size, (point - points.front()).norm());
  return points.front().norm() > kFarAway * size ? points.front() : Vec3::Zero();
}

}  // namespace

NearFrames::NearFrames(const Model& model) : model_(model), moved_(model.bodies.size(), Vec3::Zero()) {
  const std::vector<Midst> midsts = midsts_of(model);
  for (std::size_t i = 1; i < moved_.size(); ++i) {
    const Body& body = model.bodies[i];
    if (midsts[i].center.norm() <= kFar * midsts[i].size) continue;
    moved_[i] = midsts[i].center;
    model_.bodies[i] = with_frame(body, {moved_[i], Mat3::Identity()});
    note_ += fmt::format("{}{}", note_.empty() ? "" : ", ", body.name);
  }
  moved_[kGround] = far_place_of(model);
  for (Body& body : model_.bodies) {
    if (body.pose_guess) body.pose_guess->r -= moved_[kGround];
  }
  if (!note_.empty()) {
    note_ = fmt::format("computed about mass centres, from which their frames are far away: {}", note_);
  }
  if (!moved_[kGround].isZero(0.0)) {
    note_ += fmt::format("{}computed about ({:.6g}, {:.6g}, {:.6g}) m: the world's origin is far away",
                         note_.empty() ? "" : "; ", moved_[kGround].x(), moved_[kGround].y(), moved_[kGround].z());
  }
  if (note_.empty()) return;
  for_each_attachment(model_, [&](Attachment& side) {
    const Vec3& by = moved_[static_cast<std::size_t>(side.body)];
    if (!by.isZero(0.0)) side = with_frame(std::move(side), {by, Mat3::Identity()});
  });
}

Trajectory NearFrames::back(Trajectory run) const {
  for (Sample& sample : run.samples) {
    for (std::size_t i = 1; i < moved_.size(); ++i) {
      BodyState& body = sample.state.bodies[i];
      body.r += moved_[kGround];
      if (moved_[i].isZero(0.0)) continue;
      const Vec3 arm = rotation_of(body.p) * moved_[i];
      body.r -= arm;
      body.v -= body.omega.cross(arm);
      take_arm_off(arm, body.omega, sample.evaluation.bodies[i]);
    }
  }
  return run;
}

}  // namespace concord::compare
