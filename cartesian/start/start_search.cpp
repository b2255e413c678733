#include "cartesian/start/start_search.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>

#include "cartesian/bodies/euler_parameters.h"
#include "cartesian/bodies/joint_coordinates.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

constexpr int kFurtherStarts = 12;
constexpr double kShareOfGuesses = 0.1;  // of how far a coordinate that is not stated is moved

/// Writes what `model` guesses into q and Y, and lets the equations count turns from there.
void set_guesses(Equations& equations, const Model& model, VecX& q, VecX& Y) {
  const Layout& layout = equations.layout();
  const std::vector<Pose> poses = guess_poses(model);
  Y.setZero();
  for (const BodyIndex i : layout.moving_bodies()) {
    layout.r(q, i) = poses[i.value].r;
    layout.p(q, i) = euler_parameters_of(poses[i.value].A);
    layout.a(q, i) = pick(model.bodies, i).a_start;
    layout.adot(Y, i) = pick(model.bodies, i).adot_start;
  }
  State guessed;
  guessed.q = start_coordinates(model);
  equations.count_turns_from(guessed);
}

/// Other guesses for the same machine; what is kept or driven stays.
class GuessPerturbation {
 public:
  explicit GuessPerturbation(const Model& model) : original_(model), perturbed_(model), length_(model.length_scale()) {}

  const Model& perturb() {
    for (const JointIndex k : indices_of(original_.joints)) {
      const Joint& joint = pick(original_.joints, k);
      for (std::size_t word = 0; word < joint.start.size(); ++word) {
        if (joint.start[word].role_q == StartRole::keep) continue;
        perturbed_.joints[k.value].start[word].q = moved(joint.start[word], joint.type->permits[word]);
      }
    }
    for (std::size_t i = 1; i < original_.bodies.size(); ++i) {
      if (original_.bodies[i].pose_guess) perturbed_.bodies[i].pose_guess = moved(*original_.bodies[i].pose_guess);
    }
    return perturbed_;
  }

 private:
  double draw(double size) { return size * spread_(engine_); }

  Vec3 draw_vector(double size) {
    Vec3 drawn;
    for (double& entry : drawn) entry = draw(size);
    return drawn;
  }

  VecX moved(const WordStart& said, const joints::Permit& word) {
    const double part = said.role_q == StartRole::guess ? kShareOfGuesses : 1.0;
    VecX q = said.q;
    if (joints::is_orientation(word)) {
      const Mat3 A = turn_by(draw_vector(part * EIGEN_PI)) * rotation_of(Vec4(q).normalized());
      q = euler_parameters_of(A);
    } else {
      for (int n = 0; n < static_cast<int>(q.size()); ++n) {
        q(n) += draw(part * (joints::is_length(word, n) ? length_ : EIGEN_PI));
      }
    }
    return q;
  }

  Pose moved(const Pose& pose) {
    const Vec3 way = draw_vector(kShareOfGuesses * length_);
    const Mat3 turn = turn_by(draw_vector(kShareOfGuesses * EIGEN_PI));
    return {pose.r + way, turn * pose.A};
  }

  static Mat3 turn_by(const Vec3& vector) {
    const double angle = vector.norm();
    return angle > 0.0 ? Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix() : Mat3::Identity();
  }

  const Model& original_;
  Model perturbed_;
  double length_;
  std::mt19937 engine_{31};
  std::uniform_real_distribution<double> spread_{-1.0, 1.0};
};

/// How far the joints at the last update are from `known`, squared, in lengths and radians without whole turns; what
/// the model does not state counts little.
double distance_from(const Equations& equations, const std::vector<VecX>& known) {
  constexpr double kUnstated = 1e-3;
  const Model& model = equations.model();
  std::vector<VecX> q = known;
  std::vector<VecX> u = zero_speeds(model);
  read_joint_coordinates(model, equations.moving_constraints(), q, u);
  double sum = 0.0;
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& joint = pick(model.joints, k);
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const auto n = joint.start[word].q.size();
      if (n == 0) continue;  // an arm
      const int first = first_q(*joint.type, static_cast<int>(word));
      VecX apart = q[k.value].segment(first, n) - known[k.value].segment(first, n);
      const joints::Permit& permitted = joint.type->permits[word];
      for (int c = 0; c < n && !joints::is_orientation(permitted); ++c) {
        if (joints::is_length(permitted, c)) apart(c) /= model.length_scale();
      }
      sum += (joint.start[word].role_q == StartRole::guess ? 1.0 : kUnstated) * apart.squaredNorm();
    }
  }
  return sum;
}

/// Coordinates that the model states, and what the guessed poses read for others.
std::vector<VecX> guessed_coordinates(Equations& equations, const VecX& q, const VecX& Y) {
  const Model& model = equations.model();
  std::vector<VecX> stated = start_coordinates(model);
  std::vector<VecX> guessed = stated;
  std::vector<VecX> speeds = zero_speeds(model);
  equations.update(0.0, q, Y);
  read_joint_coordinates(model, equations.moving_constraints(), guessed, speeds);
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& joint = pick(model.joints, k);
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      if (joint.start[word].role_q == StartRole::unsaid) continue;
      const int first = first_q(*joint.type, static_cast<int>(word));
      const auto n = joint.start[word].q.size();
      guessed[k.value].segment(first, n) = stated[k.value].segment(first, n);
    }
  }
  return guessed;
}

Closing close_guesses(Equations& equations, const Model& guesses, VecX& q, VecX& Y) {
  set_guesses(equations, guesses, q, Y);
  return close_machine(equations, 0.0, Hold::start, Modes::kept, q, Y);
}

/// The further start from which the machine closes nearest to its guesses; nothing if it does from none.
std::optional<Model> best_further_start(Equations& equations, VecX q, VecX Y) {
  set_guesses(equations, equations.model(), q, Y);
  const std::vector<VecX> known = guessed_coordinates(equations, q, Y);
  GuessPerturbation perturbation(equations.model());
  std::optional<Model> best;
  double least = HUGE_VAL;
  for (int k = 0; k < kFurtherStarts; ++k) {
    const Model& guesses = perturbation.perturb();
    try {
      if (!close_guesses(equations, guesses, q, Y).places_closed) continue;
    } catch (const SolverError&) {
      continue;  // a deformation out of range, or a force without direction on the way
    }
    const double distance = distance_from(equations, known);
    if (distance >= least) continue;
    least = distance;
    best = guesses;
  }
  return best;
}

}  // namespace

ClosedStart close_start(Equations& equations, VecX& q, VecX& Y) {
  const Model& model = equations.model();
  ClosedStart start{close_guesses(equations, model, q, Y), false};
  if (start.closing.places_closed) return start;
  const std::optional<Model> further = best_further_start(equations, q, Y);
  if (!further) {
    start.closing = close_guesses(equations, model, q, Y);
    return start;
  }
  return {close_guesses(equations, *further, q, Y), true};
}

Closing close_without_kept(Equations& equations, VecX& q, VecX& Y) {
  close_guesses(equations, equations.model(), q, Y);
  return close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y);
}

}  // namespace concord::cartesian
