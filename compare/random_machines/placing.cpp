#include "compare/random_machines/placing.h"

#include <algorithm>
#include <numeric>

#include "common/decompositions.h"
#include "common/joints/named_coordinates.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/referee.h"
#include "compare/random_machines/random.h"
#include "compare/random_machines/velocities.h"

namespace concord::compare::fuzz {

namespace {

constexpr double kZero = 1e-9;         // of the largest singular value
constexpr double kFarFromZero = 0.04;  // what is not zero is more than this
constexpr double kIndependent = 0.1;   // the least new part of a unit row that is taken for independent
constexpr double kLargestSpeed = 5.0;  // solved speeds over those that were drawn

void follow_laws(Machine& machine) {
  for (JointPlan& joint : machine.joints) {
    const std::vector<NamedCoordinate> named = named_coordinates(*joint.type);
    for (std::size_t k = 0; k < named.size(); ++k) {
      if (!joint.coordinates[k].law) continue;
      const TimeFunctionValue value = evaluate(*joint.coordinates[k].law, 0.0);
      joint.q(first_q(*joint.type, named[k].word) + named[k].component) = value.f;
      joint.u(first_u(*joint.type, named[k].word) + named[k].component) = value.fdot;
    }
  }
}

void close_loops(Machine& machine, const std::vector<Pose>& poses) {
  for (JointPlan& joint : machine.joints) {
    if (!joint.closes_loop) continue;
    const Motion motion = motion_of(joint, joint.own_type());
    const Pose parent = frame_of(joint.ends[0], poses[joint.ends[0].body]);
    const Pose& child = poses[joint.ends[1].body];
    joint.ends[1].point = child.A.transpose() * (parent.r + parent.A * motion.placement.d - child.r);
    joint.ends[1].p = parameters_of(child.A.transpose() * parent.A * motion.placement.R);
  }
}

struct Rank {
  int rank = 0;
  bool is_clear = true;
};

Rank rank_of(const MatX& rows) {
  Rank found;
  if (rows.rows() == 0 || rows.cols() == 0) return found;
  const VecX values = singular_values(rows);
  for (const double value : values) {
    if (value <= kZero * values(0)) continue;
    ++found.rank;
    found.is_clear = found.is_clear && value > kFarFromZero * values(0);
  }
  return found;
}

/// Rows of what is prescribed, and what their right sides are.
struct Prescribed {
  MatX rows;
  VecX values;

  void add(const VecX& row, double value) {
    const double size = row.norm();
    append_rows(rows, row.transpose() / size);
    values.conservativeResize(values.size() + 1);
    values(values.size() - 1) = value / size;
  }
};

int column_of(const Machine& machine, const Velocities& velocities, const TermPlan& term) {
  const joints::JointType& type = *machine.joints[term.joint].type;
  const NamedCoordinate named = named_coordinates(type)[term.coordinate];
  return velocities.first(term.joint) + first_u(type, named.word) + named.component;
}

Prescribed prescribed(const Machine& machine, const Velocities& velocities) {
  Prescribed all{MatX(0, velocities.n()), VecX()};
  for (int k = 0; k < static_cast<int>(machine.joints.size()); ++k) {
    const JointPlan& joint = machine.joints[k];
    for (int c = 0; c < static_cast<int>(joint.coordinates.size()); ++c) {
      if (!joint.coordinates[c].law) continue;
      const int column = column_of(machine, velocities, {k, c, 1.0});
      const double speed = evaluate(*joint.coordinates[c].law, 0.0).fdot;
      all.add(VecX::Unit(velocities.n(), column), speed / velocities.scale(column));
    }
  }
  for (const CouplingPlan& coupling : machine.couplings) {
    VecX row = VecX::Zero(velocities.n());
    for (const TermPlan& term : coupling.terms) {
      const int column = column_of(machine, velocities, term);
      row(column) += term.factor * velocities.scale(column);
    }
    all.add(row, 0.0);
  }
  return all;
}

/// A word of a joint's motion among the columns.
struct Word {
  int joint = 0;
  int word = 0;
  int first = 0;
  int count = 0;
  bool is_driven = false;
};

std::vector<Word> words_of(const Machine& machine, const Velocities& velocities) {
  std::vector<Word> words;
  for (int k = 0; k < static_cast<int>(machine.joints.size()); ++k) {
    const JointPlan& joint = machine.joints[k];
    const std::vector<NamedCoordinate> named = named_coordinates(*joint.type);
    for (int w = 0; w < static_cast<int>(joint.type->permits.size()); ++w) {
      const int count = n_u(joint.type->permits[w]);
      if (count == 0) continue;
      bool is_driven = false;
      for (std::size_t c = 0; c < named.size(); ++c) {
        is_driven = is_driven || (named[c].word == w && joint.coordinates[c].law.has_value());
      }
      words.push_back({k, w, velocities.first(k) + first_u(*joint.type, w), count, is_driven});
    }
  }
  return words;
}

/// Words whose columns complete the rows to all columns; nothing if no whole words do.
std::optional<std::vector<bool>> choose_kept(const MatX& rows, const std::vector<Word>& words,
                                             const std::vector<int>& order) {
  const auto n = rows.cols();
  MatX basis(n, 0);  // orthonormal columns that span the rows so far
  if (rows.rows() > 0) {
    basis = svd_of(rows).V.leftCols(rank_of(rows).rank);
  }
  std::vector<bool> kept(words.size(), false);
  for (const int k : order) {
    const Word& word = words[k];
    if (word.is_driven) continue;
    MatX grown = basis;
    bool is_new = true;
    for (int c = 0; c < word.count && is_new; ++c) {
      VecX part = VecX::Unit(n, word.first + c);
      for (int twice = 0; twice < 2; ++twice) part -= grown * (grown.transpose() * part);
      is_new = part.norm() > kIndependent;
      if (!is_new) break;
      grown.conservativeResize(n, grown.cols() + 1);
      grown.rightCols(1) = part.normalized();
    }
    if (!is_new) continue;
    basis = grown;
    kept[k] = true;
  }
  if (basis.cols() != n) return std::nullopt;
  return kept;
}

std::vector<int> shuffled(int count, Random& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  for (int k = count - 1; k > 0; --k) std::swap(order[k], order[random.below(k + 1)]);
  return order;
}

std::optional<std::vector<bool>> choose_kept(const MatX& rows, const std::vector<Word>& words, Random& random) {
  constexpr int kMostOrders = 100;  // a ball fits only before the slides that it rolls along
  for (int tries = 0; tries < kMostOrders; ++tries) {
    const auto order = shuffled(static_cast<int>(words.size()), random);
    if (auto kept = choose_kept(rows, words, order)) return kept;
  }
  return std::nullopt;
}

/// Speeds with the kept ones as drawn and all others as the constraints ask; whether there are any of decent size.
bool solve_speeds(Machine& machine, const Velocities& velocities, const std::vector<Word>& words,
                  const std::vector<bool>& kept, MatX rows, VecX values) {
  const int n = velocities.n();
  VecX drawn(n);
  for (std::size_t k = 0; k < machine.joints.size(); ++k) {
    drawn.segment(velocities.first(static_cast<int>(k)), machine.joints[k].u.size()) = machine.joints[k].u;
  }
  for (int c = 0; c < n; ++c) drawn(c) /= velocities.scale(c);
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (!kept[k]) continue;
    MatX more = MatX::Zero(words[k].count, n);
    more.middleCols(words[k].first, words[k].count).setIdentity();
    append_rows(rows, more);
    const auto old = values.size();
    values.conservativeResize(old + words[k].count);
    values.tail(words[k].count) = drawn.segment(words[k].first, words[k].count);
  }
  const VecX u = least_squares(rows, values);
  const double largest = std::max(drawn.lpNorm<Eigen::Infinity>(), values.lpNorm<Eigen::Infinity>());
  if ((rows * u - values).norm() > 1e-9 * largest || u.lpNorm<Eigen::Infinity>() > kLargestSpeed * largest)
    return false;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (kept[k] || words[k].is_driven) continue;
    JointPlan& joint = machine.joints[words[k].joint];
    for (int c = 0; c < words[k].count; ++c) {
      const int column = words[k].first + c;
      joint.u(column - velocities.first(words[k].joint)) = u(column) * velocities.scale(column);
    }
  }
  return true;
}

void write_kept(Machine& machine, const std::vector<Word>& words, const std::vector<bool>& kept,
                std::vector<bool> JointPlan::*roles) {
  for (JointPlan& joint : machine.joints) (joint.*roles).assign(joint.type->permits.size(), false);
  for (std::size_t k = 0; k < words.size(); ++k) (machine.joints[words[k].joint].*roles)[words[k].word] = kept[k];
}

void set_offsets(Machine& machine) {
  for (CouplingPlan& coupling : machine.couplings) {
    coupling.offset = 0.0;
    for (const TermPlan& term : coupling.terms) {
      const JointPlan& joint = machine.joints[term.joint];
      const NamedCoordinate named = named_coordinates(*joint.type)[term.coordinate];
      coupling.offset += term.factor * joint.q(first_q(*joint.type, named.word) + named.component);
    }
  }
}

/// Why the start cannot be said; empty if it can and is.
std::string find_start(Machine& machine, const std::vector<Pose>& poses, std::uint64_t choice) {
  const Velocities velocities(machine, poses);
  if (velocities.n() == 0) return "";
  const std::vector<Word> words = words_of(machine, velocities);
  const Prescribed laws = prescribed(machine, velocities);
  MatX rows = velocities.loops();
  const Rank loops = rank_of(rows);
  if (!machine.is_redundant && loops.rank < rows.rows()) return "loops depend on each other";
  if (!loops.is_clear && machine.is_regular) return "near a singular pose";
  append_rows(rows, laws.rows);
  Rank rank = rank_of(rows);
  if (rank.rank < loops.rank + laws.rows.rows()) return "laws depend on the joints";
  if (!rank.is_clear && machine.is_regular) return "near a singular pose of its laws";
  Random random(choice, 0);
  const auto kept_q = choose_kept(rows, words, random);
  if (!kept_q) return "whole words do not make up the degrees of freedom";
  VecX values = VecX::Zero(rows.rows());
  values.tail(laws.values.size()) = laws.values;
  const MatX slips = velocities.slips();
  append_rows(rows, slips);
  values.conservativeResize(rows.rows());
  values.tail(slips.rows()).setZero();
  const int before = rank.rank;
  rank = rank_of(rows);
  if (rank.rank < before + slips.rows()) return "slips depend on the joints";
  if (!rank.is_clear && machine.is_regular) return "near a singular pose of what must not slip";
  const auto kept_u = choose_kept(rows, words, random);
  if (!kept_u) return "whole words do not make up the speeds";
  if (!solve_speeds(machine, velocities, words, *kept_u, rows, values)) return "speeds do not fit";
  write_kept(machine, words, *kept_q, &JointPlan::keeps_q);
  write_kept(machine, words, *kept_u, &JointPlan::keeps_u);
  return "";
}

}  // namespace

std::vector<Pose> poses_of(const Machine& machine) {
  std::vector<Pose> poses(machine.bodies.size());
  for (int i = 1; i < static_cast<int>(machine.bodies.size()); ++i) {
    const JointPlan& joint = machine.joints[i - 1];
    const Motion motion = motion_of(joint, joint.own_type());
    const Side outer = outer_side(joint, i);
    const End& end = joint.ends[index(outer)];
    const End& inner = joint.ends[1 - index(outer)];
    const Pose from = frame_of(inner, poses[inner.body]);
    Pose reached;
    if (outer == Side::child) {
      reached = {from.r + from.A * motion.placement.d, from.A * motion.placement.R};
    } else {
      reached.A = from.A * motion.placement.R.transpose();
      reached.r = from.r - reached.A * motion.placement.d;
    }
    poses[i].A = rotation_of(parameters_of(reached.A * rotation_of(end.p).transpose()));
    poses[i].r = reached.r - poses[i].A * end.point;
  }
  return poses;
}

Placing place(Machine& machine, std::uint64_t choice) {
  follow_laws(machine);
  Placing placing;
  placing.poses = poses_of(machine);
  close_loops(machine, placing.poses);
  set_offsets(machine);
  placing.trouble = find_start(machine, placing.poses, choice);
  return placing;
}

}  // namespace concord::compare::fuzz
