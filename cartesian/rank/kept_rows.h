#pragma once

#include <vector>

#include "cartesian/bodies/joint_rows.h"
#include "cartesian/dynamics/equations.h"
#include "common/start_words.h"

namespace concord::cartesian {

/// A row that is no constraint of the machine: a coordinate or speed that the start keeps.
struct KeptRow {
  JointIndex joint;
  ConstraintRow row;  // gradient and, for coordinates, value less the kept value
  double target;      // of a speed
  double size;        // of the kept value, which the round-off of `row` is relative to
  int component;      // of its word
};

enum class Kept { coordinates, speeds };

/// What the model's start keeps, in the order of joints and their words.
std::vector<KeptRow> kept_rows(const Equations& equations, Kept what);
/// Appends the rows of a word as if the start kept it; none of coordinates that drivers move.
void add_kept_rows(const Equations& equations, const StartWord& word, std::vector<KeptRow>& kept);

/// All words of the joints, those first of which the start keeps coordinates (speeds).
std::vector<StartWord> words_kept_first(const Model& model, Kept what);

/// Calls visit(joint, index among its q, reading, component) for each reading that counts turns by itself.
template <class Visit>
void each_counting_reading(const Model& model, const Visit& visit) {
  for (const JointIndex k : indices_of(model.joints)) {
    int place = 0;
    for (const joints::Read& read : pick(model.joints, k).type->reads) {
      const joints::CoordinateKinds kinds = kinds_of(read);
      for (int c = 0; c < kinds.size(); ++c) {
        if (kinds[c] == joints::CoordinateKind::angle && !reads_turn(read, c)) {
          visit(k, place + c, read, c);
        }
      }
      place += n_q(read);
    }
  }
}

/// Readings that count turns by themselves, held at known coordinates of the joints.
std::vector<KeptRow> turn_rows(const Equations& equations, const std::vector<VecX>& known);

}  // namespace concord::cartesian
