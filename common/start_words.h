#pragma once

#include <string>
#include <vector>

#include "common/model.h"

/// What the solvers say of a start that they refuse, in the words of the model. They find it each by its own equations.
namespace concord {

/// One word of a joint's motion: a turn, a slide, a ball.
struct StartWord {
  int joint = 0;
  int word = 0;
};

/// The words of all joints that have coordinates, in the order of the model.
std::vector<StartWord> start_words(const Model& model);

/// "turn_x and turn_y of joint 'B', slide_z of joint 'D'": words in the order of the model.
std::string names_of(const Model& model, std::vector<StartWord> words);

/// How far a joint that does not close stands open: from where the child's joint frame would stand if the joint
/// permitted it to where it stands, in the parent's joint frame.
struct JointGap {
  Vec3 apart_C = Vec3::Zero();   // m
  Vec3 turned_C = Vec3::Zero();  // rotation vector, rad
  Mat3 A_C = Mat3::Identity();   // parent's joint frame to global
};

/// "0.1 m along -z of its frame on the parent (in the world along (0, 1, 0))"; of a gap and a turn both, unless one is
/// round-off beside the other. `length`: what a displacement is held against a turn by [m].
std::string words_of(const JointGap& gap, double length);

}  // namespace concord
