#include "compare/states/near_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "compare/audit/balance.h"
#include "compare/audit/places.h"
#include "compare/audit/same_machine.h"
#include "compare/states/body_frames.h"

namespace concord::compare {

namespace {

constexpr double kFar = 10.0;
constexpr double kFarAway = 1000.0;
constexpr double kTooFarForShapes = 1e6;
constexpr double kLeastNeed = 1.0;

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

/// Refuses a flexible body of whose places a frame that is farther away leaves fewer digits than the audit of beams
/// needs.
void refuse_lost_shape(const Body& body, const Midst& midst) {
  const double away = midst.center.norm();
  if (away <= kTooFarForShapes * midst.size) return;
  throw InputError(body.where,
                   fmt::format("body '{}' (flexible): its frame is {:.3g} m from its mass centre, {:.2g} times what it "
                               "measures ({:.3g} m), allowed {:g}: double precision leaves too few digits of its "
                               "shape; describe it in a frame that lies in it or beside it",
                               body.name, away, away / midst.size, midst.size, kTooFarForShapes));
}

/// What concord did wrong itself, in words that let nobody look for it in the model or in a solver.
SolverError own_fault(const Model& model, std::string_view what, const std::string& found) {
  return SolverError(fmt::format(
      "{}: concord's own change of frames is wrong, neither the model nor a solver is: {}: {}; nothing is judged: "
      "report it, or describe bodies in frames that lie in them and the machine near the origin, which are not changed",
      model.name, what, found));
}

AuditReport audit_of(const Model& model, const Trajectory& run) {
  Auditor auditor(model);
  for (const Sample& sample : run.samples) auditor.add(sample.state, sample.evaluation);
  return auditor.report();
}

}  // namespace

NearFrames::NearFrames(Model given)
    : given_(std::move(given)), model_(given_), moved_(given_.bodies.size(), Vec3::Zero()) {
  const std::vector<Midst> midsts = midsts_of(given_);
  for (std::size_t i = 1; i < moved_.size(); ++i) {
    const Body& body = given_.bodies[i];
    if (midsts[i].center.norm() <= kFar * midsts[i].size) continue;
    if (body.modal) refuse_lost_shape(body, midsts[i]);
    moved_[i] = midsts[i].center;
    model_.bodies[i] = with_frame(body, {moved_[i], Mat3::Identity()});
    note_ += fmt::format("{}{}", note_.empty() ? "" : ", ", body.name);
  }
  moved_[kGround] = far_place_of(given_);
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
  const std::string difference = difference_of_machines(given_, model_, moved_[kGround]);
  if (!difference.empty()) throw own_fault(given_, "frames near the bodies make another machine of it", difference);
}

Trajectory NearFrames::led_back(Trajectory run) const {
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

Trajectory NearFrames::back(Trajectory run) const {
  if (note_.empty()) return run;
  const AuditReport near = audit_of(model_, run);
  run = led_back(std::move(run));
  const AuditReport found = audit_of(given_, run);
  double distance = 0.0;
  for (const Vec3& by : moved_) distance = std::max(distance, by.norm());
  const double lost = std::max(0.0, std::log10(distance / model_.length_scale()));
  for (std::size_t rule = 0; rule < found.rules.size(); ++rule) {
    const AuditFinding& one = found.rules[rule];
    const double need = std::max(need_of(one.rule) - lost, kLeastNeed);
    if (!near.rules[rule].holds() || one.digits >= need) continue;
    throw own_fault(given_, "the run that was led back to the frames of the model breaks what it kept before",
                    fmt::format("{} (need {:.1f})", one.text(), need));
  }
  return run;
}

std::array<std::optional<Trajectory>, 2> NearFrames::back(std::array<std::optional<Trajectory>, 2> runs) const {
  for (auto& run : runs) {
    if (run) run = back(std::move(*run));
  }
  return runs;
}

}  // namespace concord::compare
