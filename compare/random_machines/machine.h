#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/joints/joint_type.h"
#include "common/laws/time_function.h"
#include "common/model.h"
#include "common/types.h"

/// A machine that is going to be written as a model file: parts that can be taken away one by one.
namespace concord::compare::fuzz {

/// One key of a table and its value as TOML text. What is not needed may be left out.
struct Entry {
  std::string key;
  std::string value;
  bool needed = false;
};
using Entries = std::vector<Entry>;

/// A number, and a list of numbers, as TOML: they read back as the same.
std::string number_text(double value);
std::string list_text(const VecX& values);

/// Euler parameters, scalar first, to a rotation and back.
Mat3 rotation_of(const Vec4& p);
Vec4 parameters_of(const Mat3& A);

/// A place on a body: a point (undeformed, body frame, m) and a frame. On a flexible body it is reached by a stiff arm
/// from the node.
struct End {
  int body = 0;
  Vec3 point = Vec3::Zero();
  Vec4 p{1.0, 0.0, 0.0, 0.0};
  int node = 0;
};

struct Flexible {
  Entries beam;            // of [body.beam]; empty: modes stand in a file of their own
  std::string modes_file;  // its text
  std::vector<std::string> node_names;
  std::vector<Vec3> nodes;  // undeformed, body frame, m
  VecX a;
  VecX adot;
};

struct BodyPlan {
  std::string name;
  double mass = 0.0;  // of a flexible body roughly: what a rigid one in its place has
  Vec3 center_of_mass = Vec3::Zero();
  Vec6 inertia = Vec6::Zero();  // xx, yy, zz, xy, xz, yz
  std::optional<Flexible> flexible;
};

/// What acts on one named coordinate of a joint.
struct CoordinatePlan {
  Entries drive;                    // empty: none
  std::optional<TimeFunction> law;  // the same
  Entries spring;                   // empty: none
};

struct JointPlan {
  std::string name;
  const joints::JointType* type = nullptr;  // of the catalogue
  std::vector<double> parameters;
  std::array<End, 2> ends;
  bool closes_loop = false;  // its child's end follows from the pose
  bool named_as_cut = false;
  VecX q;
  VecX u;
  std::vector<CoordinatePlan> coordinates;  // as named_coordinates(type)
  /// Whether the start keeps each word of the motion; found by place().
  std::vector<bool> keeps_q;
  std::vector<bool> keeps_u;

  /// The type with the joint's own parameters.
  [[nodiscard]] joints::JointType own_type() const;
};

struct TermPlan {
  int joint = 0;
  int coordinate = 0;  // among the named ones
  double factor = 0.0;
};

struct CouplingPlan {
  std::string name;
  std::vector<TermPlan> terms;
  double offset = 0.0;  // found by place()
};

struct ElementPlan {
  std::string table;  // "load", "line_spring", ...
  std::string name;
  std::optional<End> parent;  // of elements between two bodies
  End child;                  // the one body of a load or a tire
  bool has_frame = true;      // the frames of the ends mean something
  Entries entries;
  Entries road;  // of the road that a tire has to itself
};

struct Machine {
  std::string name;
  Vec3 gravity = Vec3::Zero();
  double until = 1.0;
  double length = 1.0;            // m, its size: the unit of slides against turns
  bool is_redundant = false;      // built with constraints that depend on each other
  bool is_regular = true;         // no straight, flat or folded pose on purpose
  std::vector<BodyPlan> bodies;   // ground first
  std::vector<JointPlan> joints;  // joint k ties body k + 1 to earlier ones; those that close loops stand last
  std::vector<CouplingPlan> couplings;
  std::vector<ElementPlan> elements;

  /// Nothing in it is a reason to refuse it.
  [[nodiscard]] bool should_be_judged() const { return is_regular && !is_redundant; }
};

}  // namespace concord::compare::fuzz
