#include "compare/audit/cures.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "common/decompositions.h"
#include "common/joints/catalogue.h"
#include "common/products.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/machine_rank.h"

namespace concord::compare {

namespace {

/// A change, and what self-stresses would do along the directions that it frees: a column for each self-stress.
struct Candidate {
  JointChange change;
  int freed = 0;
  MatX work;
};

/// Places of the speeds of a joint on which something acts.
std::vector<int> forced_speeds_of(const Model& model, int joint) {
  const Joint& one = model.joints[static_cast<std::size_t>(joint)];
  std::vector<int> forced;
  for (const Driver& driver : one.drivers) forced.push_back(first_u(*one.type, driver.word) + driver.component);
  for (const JointSpring& spring : one.springs) forced.push_back(first_u(*one.type, spring.word) + spring.component);
  for (const Coupling& coupling : model.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      if (term.joint == joint) forced.push_back(first_u(*one.type, term.word) + term.component);
    }
  }
  return forced;
}

/// Whether another type has speeds of the same names that mean the same motion.
bool keeps(const std::vector<int>& forced, const joints::JointType& has, const Mat6X& permitted,
           const joints::JointType& type, const Mat6X& directions) {
  constexpr double kSame = 1e-9;
  const std::vector<std::string> names = speed_names(type);
  return std::all_of(forced.begin(), forced.end(), [&](int speed) {
    const std::string name = speed_names(has).at(static_cast<std::size_t>(speed));
    const auto found = std::find(names.begin(), names.end(), name);
    return found != names.end() && (directions.col(found - names.begin()) - permitted.col(speed)).norm() <= kSame;
  });
}

/// Directions in which a joint of another type could move from where its frames stand, [d / l; turn] in the parent's
/// joint frame; nothing where they cannot stand so.
std::optional<Mat6X> directions_of(const joints::JointType& type, const RelativeMotion& at, double length) {
  constexpr double kThere = 1e-9;
  const JointMotion motion = read_motion(type, at, {});
  if (!((motion.d - at.d).norm() <= kThere * length && (motion.R - at.R).norm() <= kThere)) return std::nullopt;
  Mat6X directions = product(motion.S, motion.free);
  directions.topRows<3>() /= length;
  return directions;
}

/// Whether all that `inner` spans is among what `outer` spans.
bool spans(const Mat6X& outer, const Mat6X& inner) {
  constexpr double kContained = 1e-9;
  const MatX basis = orthonormal_columns(outer);
  return outside_span(basis, inner).norm() <= kContained * (1.0 + inner.norm());
}

std::vector<Candidate> candidates(const Model& model, const MachineConstraints& constraints) {
  std::vector<Candidate> all;
  for (int joint = 0; joint < static_cast<int>(model.joints.size()); ++joint) {
    const MatX stresses = constraints.stresses_of(joint);
    if (stresses.norm() <= constraints.unmoved()) continue;
    const joints::JointType& has = *model.joints[static_cast<std::size_t>(joint)].type;
    if (!has.permits_speeds.empty()) continue;
    const Mat6X permitted = constraints.permitted_by(joint);
    const std::vector<int> forced = forced_speeds_of(model, joint);
    for (const joints::JointType* type : joints::catalogue()) {
      const bool is_like_it = type->parameters.empty() && type->permits_speeds.empty();
      const int freed = type->n_u() - has.n_u();
      if (!is_like_it || freed < 1 || freed > stresses.cols()) continue;
      const auto directions = directions_of(*type, constraints.placement_of(joint), model.length_scale());
      if (!directions || !spans(*directions, permitted)) continue;
      if (!keeps(forced, has, permitted, *type, *directions)) continue;
      all.push_back({{joint, type}, freed, transposed_product(*directions, stresses)});
    }
  }
  return all;
}

/// Whether no self-stress is left that does no work along what is freed: then no constraint is redundant, and as many
/// directions are freed as there were redundant constraints, so that none of them is a motion of the machine.
/// `largest`: that self-stresses move of any wrench.
bool leaves_none(const MatX& work, double largest) {
  constexpr double kClear = 1e-6;
  const VecX sizes = singular_values(work);
  return sizes.size() >= work.cols() && sizes(work.cols() - 1) > kClear * largest;
}

}  // namespace

Cures find_cures(const Model& model, const State& state, int most_tries) {
  Cures cures;
  const MachineConstraints constraints(model, state);
  if (!constraints.is_sure() || constraints.self_stresses().cols() == 0) return cures;
  cures.redundant = static_cast<int>(constraints.self_stresses().cols());
  const std::vector<Candidate> all = candidates(model, constraints);
  const auto try_out = [&](const MatX& work, const std::vector<JointChange>& changes) {
    if (cures.tried >= most_tries) {
      cures.is_complete = false;
      return;
    }
    ++cures.tried;
    if (leaves_none(work, constraints.largest_moved())) cures.found.push_back(changes);
  };
  for (const Candidate& one : all) {
    if (one.freed == cures.redundant) try_out(one.work, {one.change});
  }
  if (!cures.found.empty()) return cures;
  for (std::size_t i = 0; i < all.size() && cures.is_complete; ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const bool is_pair = all[i].change.joint != all[j].change.joint;
      if (!is_pair || all[i].freed + all[j].freed != cures.redundant) continue;
      MatX work(all[i].work.rows() + all[j].work.rows(), all[i].work.cols());
      work << all[i].work, all[j].work;
      try_out(work, {all[i].change, all[j].change});
    }
  }
  return cures;
}

std::string describe(const Model& model, const std::vector<JointChange>& changes) {
  std::string text;
  for (const JointChange& change : changes) {
    text += fmt::format("{}joint {}{} {}", text.empty() ? "" : " and ",
                        model.joints[static_cast<std::size_t>(change.joint)].name, text.empty() ? " were" : "",
                        change.to->name);
  }
  return text;
}

}  // namespace concord::compare
