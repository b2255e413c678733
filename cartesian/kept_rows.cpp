#include "cartesian/kept_rows.h"

#include <Eigen/Geometry>
#include <cmath>

#include "cartesian/euler_parameters.h"

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

std::vector<KeptRow> kept_rows(const Equations& equations, Kept what) {
  std::vector<KeptRow> kept;
  const Model& model = equations.model();
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& stated = pick(model.joints, k);
    const RelativeMotion& motion = equations.moving_constraints().joint(k).motion;
    for (std::size_t word = 0; word < stated.start.size(); ++word) {
      const WordStart& start = stated.start[word];
      if ((what == Kept::coordinates ? start.role_q : start.role_u) != StartRole::keep) continue;
      const joints::Read* read = read_of(*stated.type, static_cast<int>(word));
      if (read == nullptr) continue;
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
        const bool follows_law = driver_of(stated, static_cast<int>(word), c) != nullptr;
        if (follows_law) continue;
        const double size = n == static_cast<int>(start.q.size()) ? std::abs(start.q(c)) : 1.0;
        kept.push_back({k, rows[c], start.u(c), size, c});
      }
    }
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
