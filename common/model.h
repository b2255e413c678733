#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/elements/force_element.h"
#include "common/error.h"
#include "common/flexible/modal_data.h"
#include "common/joints/joint_type.h"
#include "common/laws/coupling.h"
#include "common/laws/time_function.h"
#include "common/types.h"

/// The statement of a machine, and nothing of its solution.
namespace concord {

/// A pose of a body frame in the global frame: origin [m] and rotation, body to global.
struct Pose {
  Vec3 r = Vec3::Zero();
  Mat3 A = Mat3::Identity();
};

struct Body {
  std::string name;
  /// Rigid inertia: mass [kg], centre of mass in the body frame [m], inertia tensor about the centre of mass in body
  /// axes (I_xy = -sum of m x y) [kg m2]. All zero if `modal` is set: then ModalData::G has it all.
  double mass = 0.0;
  Vec3 center_of_mass_L = Vec3::Zero();
  Mat3 inertia_L = Mat3::Zero();
  std::optional<ModalData> modal;

  /// Start: a guess of the pose, and modal coordinates and speeds, which are kept.
  std::optional<Pose> pose_guess;
  VecX a_start;
  VecX adot_start;

  SourceLocation where;

  [[nodiscard]] int n_modes() const { return modal ? modal->n_modes() : 0; }
};

/// What is said of the start of one word of a joint's motion (a turn, a slide, a ball): nothing, a guess, or a value
/// that is kept exactly.
enum class StartRole { unsaid, guess, keep };
struct WordStart {
  StartRole role_q = StartRole::unsaid;
  StartRole role_u = StartRole::unsaid;
  /// n_q and n_u numbers of the word; zero (for a ball: no rotation) unless the model says otherwise.
  VecX q;
  VecX u;
  /// How far each of these may lie from where the machine closes, where more is kept than it has freedoms: half a unit
  /// of the last written digit [m, rad, per s]. Empty: kWrittenExactly of the number, at least of 1.
  VecX slack_q = {};
  VecX slack_u = {};
};

/// How exactly a number is meant that is no decimal fraction: a whole one, or an expression.
inline constexpr double kWrittenExactly = 1e-9;

/// Prescribes one coordinate of a joint (a turn or a slide): q = law(t) (S25).
struct Driver {
  int word = 0;
  TimeFunction law;
  int component = 0;  // of the word's coordinates: only a motion by functions has more than one that a law can drive
};

/// A spring, damper and actuator on one coordinate of a joint (a turn, turns counted, or a slide): its coordinate force
/// is tau = actuator - resistance.
struct JointSpring {
  int word = 0;
  ForceLaw law;
  int component = 0;
};

struct Joint {
  std::string name;
  /// A type of the catalogue, or `own_type`.
  const joints::JointType* type = nullptr;
  /// The type with this joint's own parameters, if the type has any.
  std::shared_ptr<const joints::JointType> own_type;
  std::array<Attachment, 2> sides;
  /// One for each word of the type's motion; an arm's is empty.
  std::vector<WordStart> start;
  std::vector<Driver> drivers;
  std::vector<JointSpring> springs;
  /// The model names this joint as the cut joint of its loop.
  bool named_as_cut = false;
  SourceLocation where;

  [[nodiscard]] const Attachment& on(Side side) const { return sides[index(side)]; }
};

/// Index of the first coordinate q, and of the first speed u, of a word of the joint's motion.
int first_q(const joints::JointType& type, int word);
int first_u(const joints::JointType& type, int word);

/// The driver of a coordinate of a word, or nullptr.
const Driver* driver_of(const Joint& joint, int word, int component = 0);

/// A change of the digits needed, made by the model: see compare/README.
struct NeedOverride {
  std::string joint;  // at most one of the three is named; none: everything
  std::string element;
  std::string body;
  std::string component;  // "F_x" ... "T_z"; empty: every component
  std::optional<double> same_state;
  std::optional<double> same_run;
  std::optional<double> refined;
  std::string because;
  SourceLocation where;
};

/// Relative tolerances of a run: below the first round-off rules, above the second nothing is compared.
inline constexpr double kTightestTolerance = 1e-14;
inline constexpr double kLoosestTolerance = 1e-2;

struct RunSettings {
  double until = 1.0;
  std::optional<double> rtol;
  std::optional<int> samples;
  /// The places and modal coordinates of the start are those of the static equilibrium; speeds are what the model says.
  bool from_equilibrium = false;
};

struct Model {
  std::string name;
  std::string file;
  Vec3 gravity = Vec3::Zero();
  /// bodies[kGround] is ground: no mass, fixed.
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Coupling> couplings;
  std::vector<ForceElement> elements;
  RunSettings run;
  std::vector<NeedOverride> needs;
  /// What was put right while reading, each with its place: "crank.toml:12:9: ...".
  std::vector<std::string> notes;

  [[nodiscard]] bool is_flexible() const;
  /// Whether a coupling relates a coordinate of joint k.
  [[nodiscard]] bool is_coupled(int k) const;
  /// Whether joint k can pass no wrench at all: it forbids nothing, nothing drives or couples it and it has no spring.
  [[nodiscard]] bool carries_nothing(int k) const;
  /// Largest distance between the joint points of a body, over all bodies, undeformed [m]; the ends of force elements
  /// count like joint points; where no body has two, the size of the bodies; 1 m if they have none (S42).
  [[nodiscard]] double length_scale() const;
};

/// Rough poses of all bodies at the start (ground included): a body's own guess, else the pose that follows from its
/// neighbour through a joint with the start coordinates, deformed as it starts. A place to start Newton's method from,
/// never a result: each solver closes the machine with its own equations (S43).
std::vector<Pose> guess_poses(const Model& model);

}  // namespace concord
