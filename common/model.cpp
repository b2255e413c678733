#include "common/model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/rotation.h"

namespace concord {

int first_q(const joints::JointType& type, int word) {
  int first = 0;
  for (int k = 0; k < word; ++k) first += n_q(type.permits[k]);
  return first;
}

int first_u(const joints::JointType& type, int word) {
  int first = 0;
  for (int k = 0; k < word; ++k) first += n_u(type.permits[k]);
  return first;
}

const Driver* driver_of(const Joint& joint, int word, int component) {
  for (const Driver& driver : joint.drivers) {
    if (driver.word == word && driver.component == component) return &driver;
  }
  return nullptr;
}

bool Model::is_flexible() const {
  return std::any_of(bodies.begin(), bodies.end(), [](const Body& body) { return body.modal.has_value(); });
}

bool Model::carries_nothing(int k) const {
  const Joint& joint = joints[k];
  if (joint.type->rows() + joint.type->nonholonomic_rows() > 0 || !joint.drivers.empty() || !joint.springs.empty())
    return false;
  return !is_coupled(k);
}

bool Model::is_coupled(int k) const {
  return std::any_of(couplings.begin(), couplings.end(), [k](const Coupling& coupling) {
    return std::any_of(coupling.terms.begin(), coupling.terms.end(),
                       [k](const CouplingTerm& term) { return term.joint == k; });
  });
}

namespace {

/// A length of a machine none of whose bodies has two places: the largest distance of a place from its body's centre of
/// mass, radius of gyration, distance between mass points, or link without mass; zero if there is none.
double size_of_parts(const Model& model, const std::vector<const Attachment*>& places) {
  double largest = 0.0;
  for (const Attachment* place : places) {
    const Body& body = model.bodies[place->body];
    if (place->body == kGround || body.modal) continue;
    largest = std::max(largest, (place->point_L - body.center_of_mass_L).norm());
  }
  for (const Body& body : model.bodies) {
    if (body.mass > 0.0)
      largest = std::max(largest, std::sqrt(std::max(0.0, 0.5 * body.inertia_L.trace() / body.mass)));
    if (!body.modal) continue;
    for (const MassPoint& point : body.modal->mass_points) {
      largest = std::max(largest, (point.s0_L - body.modal->mass_points.front().s0_L).norm());
    }
  }
  for (const Joint& joint : model.joints) {
    for (const joints::Permit& word : joint.type->permits) {
      largest = std::max(largest, std::abs(joints::stated_length(word)));
    }
  }
  return largest;
}

}  // namespace

double Model::length_scale() const {
  constexpr double kRoundOff = 64.0 * std::numeric_limits<double>::epsilon();
  std::vector<const Attachment*> places;
  for (const Joint& joint : joints) {
    for (const Attachment& side : joint.sides) places.push_back(&side);
  }
  for (const ForceElement& element : elements) {
    for (const Side side : {Side::parent, Side::child}) {
      if (const Attachment* end = end_of(element, side)) places.push_back(end);
    }
  }
  std::stable_sort(places.begin(), places.end(), [](auto* one, auto* other) { return one->body < other->body; });
  double largest = 0.0;
  const double of_parts = size_of_parts(*this, places);
  double farthest = of_parts;
  for (auto one = places.begin(); one != places.end(); ++one) {
    farthest = std::max(farthest, (*one)->point_L.norm());
    for (auto other = one + 1; other != places.end() && (*other)->body == (*one)->body; ++other) {
      largest = std::max(largest, ((*one)->point_L - (*other)->point_L).norm());
    }
  }
  // Places stated twice, the second time turned and back, are apart by their round-off.
  if (!(largest > kRoundOff * farthest)) largest = of_parts;
  return largest > 0.0 ? largest : 1.0;
}

namespace {

/// The frame reached by the words so far, led on by each word at its coordinates q.
struct StartMotion {
  const VecX& q;
  Pose& reached;

  void operator()(const joints::Turn& turn) const { reached.A = reached.A * rotation_about(turn.axis, q(0)); }
  void operator()(const joints::Slide& slide) const { reached.r += reached.A.col(index(slide.axis)) * q(0); }
  void operator()(const joints::Arm& arm) const { reached.r += reached.A.col(index(arm.axis)) * arm.length; }
  void operator()(const joints::Ball&) const {  // its rotation alone
    reached.A = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
  }
  void operator()(const joints::ByMotion& by) const {
    joints::FunctionOfCoordinates::Motion motion;
    const VecX rest = VecX::Zero(q.size());
    by.motion->evaluate(q.data(), rest.data(), motion);
    reached = {motion.placement.d, motion.placement.R};
  }
};

/// Position and orientation of the child's joint frame in the parent's for the start coordinates.
Pose start_motion(const Joint& joint) {
  Pose reached;
  for (std::size_t k = 0; k < joint.start.size(); ++k) {
    VecX q = joint.start[k].q;
    for (const Driver& driver : joint.drivers) {
      if (driver.word == static_cast<int>(k)) q(driver.component) = evaluate(driver.law, 0.0).f;
    }
    std::visit(StartMotion{q, reached}, joint.type->permits[k]);
  }
  return reached;
}

Pose compose(const Pose& outer, const Pose& inner) { return {outer.r + outer.A * inner.r, outer.A * inner.A}; }

Pose inverse(const Pose& pose) { return {-(pose.A.transpose() * pose.r), pose.A.transpose()}; }

/// The joint frame on its body, moved and turned by the deformation that the body starts with.
Pose frame_on(const Attachment& side, const VecX& a) {
  if (a.size() == 0) return {side.point_L, side.C};
  const Vec3 theta = side.Psi_r_L * a;
  const double angle = theta.norm();
  const Mat3 turned = angle > 0.0 ? Eigen::AngleAxisd(angle, theta / angle) * side.C : side.C;
  return {side.point_L + side.Psi_t_L * a, turned};
}

}  // namespace

std::vector<Pose> guess_poses(const Model& model) {
  std::vector<std::optional<Pose>> found(model.bodies.size());
  found[kGround] = Pose{};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) found[i] = model.bodies[i].pose_guess;
  const auto reach = [&](const Joint& joint) {
    const Attachment& parent = joint.on(Side::parent);
    const Attachment& child = joint.on(Side::child);
    if (found[parent.body].has_value() == found[child.body].has_value()) return false;
    const auto frame = [&model](const Attachment& side) { return frame_on(side, model.bodies[side.body].a_start); };
    const Pose step = compose(compose(frame(parent), start_motion(joint)), inverse(frame(child)));
    if (found[parent.body]) {
      found[child.body] = compose(*found[parent.body], step);
    } else {
      found[parent.body] = compose(*found[child.body], inverse(step));
    }
    return true;
  };
  // Joints for which the model states no start value come last: theirs are guesses.
  const auto says_something = [](const Joint& joint) {
    return joint.start.empty() || !joint.drivers.empty() ||
           std::any_of(joint.start.begin(), joint.start.end(),
                       [](const WordStart& word) { return word.role_q != StartRole::unsaid; });
  };
  bool moved = true;
  while (moved) {
    moved = std::any_of(model.joints.begin(), model.joints.end(),
                        [&](const Joint& joint) { return says_something(joint) && reach(joint); }) ||
            std::any_of(model.joints.begin(), model.joints.end(), reach);
  }
  std::vector<Pose> poses;
  for (const auto& pose : found) poses.push_back(pose.value_or(Pose{}));
  return poses;
}

}  // namespace concord
