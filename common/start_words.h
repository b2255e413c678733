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

/// The words whose coordinates (`role`: role_q) or speeds (role_u) the model keeps.
std::vector<StartWord> kept_words(const Model& model, StartRole WordStart::*role);

/// The model that keeps these words alone, of those that it kept, and guesses the others.
Model keeping_only(Model model, const std::vector<StartWord>& coordinates, const std::vector<StartWord>& speeds);

/// How far an entry of what a start keeps may lie from where the machine closes, where more is kept than is free.
double slack_of(const VecX& slack, const VecX& kept, int entry);

/// Throws StartNotFound, naming them with what is found and what is written, where values that `model` keeps lie
/// farther from q and u of its start (by joint, turns counted) than the last digit leaves open. `fewer`: the model that
/// keeps those alone that are met exactly.
void require_written(const Model& model, const Model& fewer, const std::vector<VecX>& q, const std::vector<VecX>& u);

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
