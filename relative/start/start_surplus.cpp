#include <algorithm>

#include "common/error.h"
#include "relative/rank/closing.h"
#include "relative/start/start.h"
#include "relative/start/start_advice.h"

/// Starts that keep more than the machine has freedoms.
namespace concord::relative {

Start::KeptCount Start::count_kept(const Coordinates& coordinates, const PrescribedMask& prescribed,
                                   ClosureRows rows) const {
  const PrescribedMask& driven = scaled_->equations().driven();
  KeptCount count;
  const auto n_free = static_cast<int>(scaled_->moving_columns(driven, Modes::kept).size());
  count.freedom = n_free - scaled_->rank(coordinates, rows, Modes::kept);
  for (std::size_t c = 0; c < prescribed.size(); ++c) count.kept += prescribed[c] != 0 && driven[c] == 0 ? 1 : 0;
  if (rows == ClosureRows::of_positions) return count;
  for (const StartWord& word : kept_words(stated(), &WordStart::role_u)) {
    count.allowed_surplus += n_u(stated().joints[word.joint].type->permits[word.word]) - 1;
  }
  return count;
}

/// Those of the kept words that come first and fix the closed machine; all where they are no more than that. Nothing
/// where kept words alone do not.
std::optional<std::vector<StartWord>> Start::first_independent(const Coordinates& closed, ClosureRows rows) const {
  const auto role = rows == ClosureRows::of_positions ? &WordStart::role_q : &WordStart::role_u;
  const KeptCount count = count_kept(closed, kept(role), rows);
  if (count.kept - count.freedom <= count.allowed_surplus) return kept_words(stated(), role);
  std::vector<StartWord> words = words_to_keep(*scaled_, closed, rows, role);
  const bool are_kept = std::all_of(words.begin(), words.end(), [&](const StartWord& one) {
    return stated().joints[one.joint].start[one.word].*role == StartRole::keep;
  });
  return are_kept && !words.empty() ? std::optional(std::move(words)) : std::nullopt;
}

/// The model that keeps no more than the machine has freedoms, with guesses near all that it kept; nothing where it
/// does so as it is, or where this cannot be told.
std::optional<Model> Start::without_surplus() const {
  if (kept_words(stated(), &WordStart::role_q).empty() && kept_words(stated(), &WordStart::role_u).empty()) {
    return std::nullopt;
  }
  Equations& equations = scaled_->equations();
  equations.count_turns(VecX::Zero(equations.topology().n_q));
  Coordinates closed = guess();
  equations.count_turns(equations.kinematics().whole_turns(closed.q));
  closed.q = equations.kinematics().without_turns(closed.q);
  try {
    const PrescribedMask all = kept(&WordStart::role_q);
    Closure closure(equations.kinematics(), all);
    come_nearest(*scaled_, closed, closure, scaled_->moving_columns(all, Modes::kept));
    if (!close_positions(*scaled_, closed, equations.driven(), Modes::kept)) return std::nullopt;
  } catch (const SolverError&) {
    return std::nullopt;  // the machine has no such pose
  }
  const auto coordinates = first_independent(closed, ClosureRows::of_positions);
  const auto speeds = first_independent(closed, ClosureRows::of_velocities);
  if (!coordinates || !speeds) return std::nullopt;
  const bool keeps_all = coordinates->size() == kept_words(stated(), &WordStart::role_q).size() &&
                         speeds->size() == kept_words(stated(), &WordStart::role_u).size();
  if (keeps_all) return std::nullopt;
  Model fewer = keeping_only(stated(), *coordinates, *speeds);
  const VecX q = closed.q + static_cast<double>(kWholeTurn) * equations.kinematics().turns();
  for (const StartWord& word : start_words(fewer)) {
    Joint& joint = fewer.joints[word.joint];
    WordStart& start = joint.start[word.word];
    if (start.role_q == StartRole::keep) continue;
    start.role_q = StartRole::guess;
    const int first = equations.topology().joints[JointIndex(word.joint)].first_q + first_q(*joint.type, word.word);
    start.q = q.segment(first, start.q.size());
  }
  return fewer;
}

void Start::require_as_written(const Coordinates& start) const {
  const Equations& equations = scaled_->equations();
  const VecX q = start.q + static_cast<double>(kWholeTurn) * equations.kinematics().turns();
  std::vector<VecX> by_joint;
  std::vector<VecX> speeds;
  for (const Span& span : equations.topology().joints) {
    by_joint.emplace_back(q.segment(span.first_q, span.n_q));
    speeds.emplace_back(start.u.segment(span.first_u, span.n_u));
  }
  require_written(equations.model(), *fewer_, by_joint, speeds);
}

Coordinates Start::find() const {
  try {
    return find_as_said();
  } catch (const InputError&) {
    if (fewer_) throw;
    fewer_ = without_surplus();
    if (!fewer_) throw;
    return find_as_said();
  }
}

}  // namespace concord::relative
