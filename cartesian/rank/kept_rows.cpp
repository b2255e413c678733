#include "cartesian/rank/kept_rows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cartesian/bodies/euler_parameters.h"

namespace concord::cartesian {

namespace {

/// The turn Q as axis times angle, angle in [0, pi]. Its rate is the angular velocity at Q = 1 and, for any Q, along
/// its own axis: unlike the axial vector of Q it vanishes at Q = 1 alone, so that Newton's steps cannot end at a half
/// turn.
Vec3 rotation_vector(const Mat3& Q) {
  const Eigen::AngleAxisd turn(Q);
  return turn.angle() * turn.axis();
}

}  // namespace

void add_kept_rows(const Equations& equations, const StartWord& word, std::vector<KeptRow>& kept) {
  const JointIndex k(word.joint);
  const Joint& stated = pick(equations.model().joints, k);
  const RelativeMotion& motion = equations.moving_constraints().joint(k).motion;
  const WordStart& start = stated.start[word.word];
  const joints::Read* read = read_of(*stated.type, word.word);
  if (read == nullptr) return;
  const int n = n_u(*read);
  ConstraintRow rows[kMaxRows];
  if (is_orientation(*read)) {
    const Vec3 turn = rotation_vector(motion.R * rotation_of(start.q.normalized()).transpose());
    for (int c = 0; c < n; ++c) rows[c] = {.value = turn(c), .over_rho = Vec3::Unit(c)};
  } else {
    for (int c = 0; c < n; ++c) {
      rows[c] = evaluate_read(*read, c, motion);
      const double value = rows[c].value;
      rows[c].value = reads_turn(*read, c) ? turn_from(start.q(c), value) : value - start.q(c);
    }
  }
  for (int c = 0; c < n; ++c) {
    if (driver_of(stated, word.word, c) != nullptr) continue;
    const double size = n == static_cast<int>(start.q.size()) ? std::abs(start.q(c)) : 1.0;
    kept.push_back({k, rows[c], start.u(c), size, c});
  }
}

namespace {

bool is_kept(const Model& model, const StartWord& word, Kept what) {
  const WordStart& start = model.joints[word.joint].start[word.word];
  return (what == Kept::coordinates ? start.role_q : start.role_u) == StartRole::keep;
}

}  // namespace

std::vector<StartWord> words_kept_first(const Model& model, Kept what) {
  std::vector<StartWord> words = start_words(model);
  std::stable_partition(words.begin(), words.end(), [&](const StartWord& word) { return is_kept(model, word, what); });
  return words;
}

std::vector<KeptRow> kept_rows(const Equations& equations, Kept what) {
  std::vector<KeptRow> kept;
  for (const StartWord& word : start_words(equations.model())) {
    if (is_kept(equations.model(), word, what)) add_kept_rows(equations, word, kept);
  }
  return kept;
}

std::vector<KeptRow> turn_rows(const Equations& equations, const std::vector<VecX>& known) {
  std::vector<KeptRow> rows;
  each_counting_reading(equations.model(), [&](JointIndex k, int place, const joints::Read& read, int component) {
    ConstraintRow row = evaluate_read(read, component, equations.moving_constraints().joint(k).motion);
    row.value -= known[k.value](place);
    rows.push_back({k, row, 0.0, std::abs(known[k.value](place)), component});
  });
  return rows;
}

}  // namespace concord::cartesian
