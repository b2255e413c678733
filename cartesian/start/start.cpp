#include "cartesian/start/start.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "cartesian/bodies/euler_parameters.h"
#include "cartesian/bodies/joint_coordinates.h"
#include "cartesian/dynamics/evaluation.h"
#include "cartesian/rank/closing.h"
#include "cartesian/rank/constraint_rank.h"
#include "cartesian/start/open_joint.h"
#include "cartesian/start/start_search.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// Of the first of these joints, or of the model's first joint.
SourceLocation first_place(const Model& model, const std::vector<std::string>& joints) {
  for (const Joint& joint : model.joints) {
    const bool is_sought = joints.empty() || joint.name == joints.front();
    if (is_sought && !joint.where.file.empty()) return joint.where;
  }
  return {model.file, 0, 0};
}

bool keeps_something(const Joint& joint) {
  return std::any_of(joint.start.begin(), joint.start.end(), [](const WordStart& word) {
    return word.role_q == StartRole::keep || word.role_u == StartRole::keep;
  });
}

/// Names of the joints of which the start keeps something.
std::vector<std::string> keeping_joints(const Model& model) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints) {
    if (keeps_something(joint)) names.push_back(joint.name);
  }
  return names;
}

bool keeps_coordinates(const Model& model) {
  const auto is_kept = [](const WordStart& word) { return word.role_q == StartRole::keep; };
  return std::any_of(model.joints.begin(), model.joints.end(),
                     [&](const Joint& joint) { return std::any_of(joint.start.begin(), joint.start.end(), is_kept); });
}

bool closes_without_what_is_kept(Equations& equations, VecX q, VecX Y) {
  return close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y).places_closed;
}

/// Which joints do not close and where, or what else is left open.
std::string words_of_opening(Equations& equations, const Closing& closing, const VecX& q, const VecX& Y) {
  if (closing.is_off_branch) {
    return fmt::format("joint {} closes turned round: axes that should point the same way point against each other",
                       closing.joints_left_open.front());
  }
  const std::string where =
      closing.places_closed ? "" : words_of_open_joint(equations, 0.0, Hold::start, closing, q, Y);
  if (!where.empty()) return fmt::format("{} do not close: {}", named_open(closing), where);
  return fmt::format("{} do not close (position residual {:.2g}, velocity residual {:.2g})", named_open(closing),
                     closing.position_residual, closing.velocity_residual);
}

[[noreturn]] void refuse_open_start(Equations& equations, const Closing& closing, const VecX& q, const VecX& Y) {
  const Model& model = equations.model();
  const bool may_be_kept_values =
      keeps_coordinates(model) && (closing.is_off_branch || closes_without_what_is_kept(equations, q, Y));
  const char* said =
      closing.places_closed ? "the start values contradict each other: with what is kept and driven, {}; correct the "
                              "kept values"
      : may_be_kept_values  ? "the start values contradict each other, or the guesses are too far off: with what is "
                              "kept and driven, {}, and other starts round about do no better; correct the kept "
                              "values, or give better guesses"
                            : "the guesses do not lead to a pose that closes, whatever is kept: {}, and other starts "
                              "round about do no better; correct the points and axes of these joints, or give better "
                              "guesses of joint coordinates or body poses";
  throw StartNotFound(first_place(model, closing.joints_left_open),
                      fmt::format(fmt::runtime(said), words_of_opening(equations, closing, q, Y)));
}

/// A ball keeps three speeds or none, also where fewer are free, as on slides that are driven: the others only have to
/// agree with what is free, which closing decides.
bool is_right(const KeptCount& kept) {
  const int surplus = kept.speeds - kept.speed_freedom;
  return kept.coordinates == kept.coordinate_freedom && surplus >= 0 && surplus <= kept.speeds_kept_as_wholes;
}

/// A ball keeps three coordinates or none: of a rod between two balls nothing can keep how far it has turned about
/// itself.
const char* hint_at_rod_between_balls(const Model& model, const KeptCount& kept) {
  std::vector<int> balls(model.bodies.size(), 0);
  for (const Joint& joint : model.joints) {
    const bool is_ball = joint.type->permits.size() == 1 && joints::is_orientation(joint.type->permits.front());
    if (!is_ball || joint.start.front().role_q == StartRole::keep) continue;
    for (const Attachment& side : joint.sides) {
      if (side.body != kGround) ++balls[side.body];
    }
  }
  const bool has_rod = std::any_of(balls.begin(), balls.end(), [](int count) { return count > 1; });
  return kept.coordinates < kept.coordinate_freedom && has_rod
             ? "; a rod between two balls turns freely about itself: let one of the two joints be universal"
             : "";
}

/// Whether the constraints lose rank at this closed pose: poses round about have more.
bool is_singular_pose(Equations& equations, const VecX& q, const VecX& Y, const std::vector<VecX>& turns) {
  equations.update(0.0, q, Y);
  const int rank = choose_rows(equations).rank;
  State here = equations.layout().pack(0.0, q, Y);
  here.q = turns;
  return decide_for_the_machine(equations, here).generic > rank;
}

/// ", for example turn_z of joint 'A'": what could be kept; empty where that is not known.
std::string examples(const Model& model, const std::vector<StartWord>& words) {
  return words.empty() ? "" : fmt::format(", for example {}", names_of(model, words));
}

[[noreturn]] void refuse_wrong_count(Equations& equations, const KeptCount& kept, const VecX& q, const VecX& Y,
                                     bool is_singular) {
  const Model& model = equations.model();
  const auto to_keep = [&](Kept what) {
    return examples(model, is_singular ? std::vector<StartWord>() : words_to_keep(equations, 0.0, q, Y, what));
  };
  const char* const hint = is_singular
                               ? "; but the start is a singular pose, as a linkage that lies flat or stretched, "
                                 "where it only seems to have more: start it elsewhere"
                               : "";
  const SourceLocation where = first_place(model, keeping_joints(model));
  const std::string found = fmt::format("the start keeps {} joint coordinates and {} joint speeds, but the machine has",
                                        kept.coordinates, kept.speeds);
  if (kept.coordinate_freedom == kept.speed_freedom) {
    throw InputError(where,
                     fmt::format("{} {} independent ones (rigid ones, beside those that drivers move): keep exactly "
                                 "{} of each{}{}{}",
                                 found, kept.coordinate_freedom, kept.coordinate_freedom, to_keep(Kept::coordinates),
                                 hint_at_rod_between_balls(model, kept), hint));
  }
  throw InputError(where,
                   fmt::format("{} {} independent coordinates and {} independent speeds (rigid ones, beside those that "
                               "drivers move; what must not slip restricts speeds alone): keep exactly as many "
                               "coordinates{}, and speeds{}{}",
                               found, kept.coordinate_freedom, kept.speed_freedom, to_keep(Kept::coordinates),
                               to_keep(Kept::speeds), hint));
}

void refuse_dependent(const Model& model, const KeptCount& kept) {
  const bool fixes_places = kept.independent_coordinates == kept.coordinate_freedom;
  if (fixes_places && kept.independent_speeds == kept.speed_freedom) return;
  const std::vector<std::string> names = keeping_joints(model);
  throw InputError(first_place(model, names),
                   fmt::format("the coordinates that the start keeps in joints {} depend on each other: {} of {} "
                               "coordinates and {} of {} speeds are independent",
                               fmt::join(names, ", "), kept.independent_coordinates, kept.coordinates,
                               kept.independent_speeds, kept.speeds));
}

Start assemble_as_said(Equations& equations) {
  const Model& model = equations.model();
  VecX q = VecX::Zero(equations.layout().n_q());
  VecX Y = VecX::Zero(equations.layout().n_Y());
  std::vector<VecX> turns = start_coordinates(model);
  const ClosedStart closed = close_start(equations, q, Y);
  equations.constraints().write_turns(turns);
  KeptCount kept = count_kept(equations, 0.0, q, Y, false);
  // Where rows depend on each other, a closed pose may be known to the root of round-off only.
  if (!is_right(kept)) {
    const KeptCount coarse = count_kept(equations, 0.0, q, Y, true);
    if (is_right(coarse)) kept = coarse;
  }
  // Off the constraints redundant rows look independent: count only where the machine closed.
  if (closed.closing.closed && !is_right(kept)) {
    refuse_wrong_count(equations, kept, q, Y, is_singular_pose(equations, q, Y, turns));
  }
  if (!closed.closing.closed) refuse_open_start(equations, closed.closing, q, Y);
  refuse_dependent(model, kept);
  return {reported_state(equations, q, Y, turns), closed.searched};
}

/// Those of the kept words that come first and fix the machine; all where they are no more than that. Nothing where
/// kept words alone do not.
std::optional<std::vector<StartWord>> first_independent(Equations& equations, const VecX& q, const VecX& Y, Kept what,
                                                        bool has_surplus) {
  const auto role = what == Kept::coordinates ? &WordStart::role_q : &WordStart::role_u;
  const Model& model = equations.model();
  if (!has_surplus) return kept_words(model, role);
  std::vector<StartWord> words = words_to_keep(equations, 0.0, q, Y, what);
  const bool are_kept = std::all_of(words.begin(), words.end(), [&](const StartWord& one) {
    return model.joints[one.joint].start[one.word].*role == StartRole::keep;
  });
  return are_kept && !words.empty() ? std::optional(std::move(words)) : std::nullopt;
}

/// The model that keeps no more than the machine has freedoms, with guesses near all that it kept; nothing where it
/// does so as it is, or where this cannot be told.
std::optional<Model> without_surplus(Equations& equations) {
  VecX q = VecX::Zero(equations.layout().n_q());
  VecX Y = VecX::Zero(equations.layout().n_Y());
  try {
    if (!close_without_kept(equations, q, Y).places_closed) return std::nullopt;
  } catch (const SolverError&) {
    return std::nullopt;  // a deformation out of range on the way
  }
  const KeptCount kept = count_kept(equations, 0.0, q, Y, false);
  const bool has_coordinates = kept.coordinates > kept.coordinate_freedom;
  const bool has_speeds = kept.speeds - kept.speed_freedom > kept.speeds_kept_as_wholes;
  if (!has_coordinates && !has_speeds) return std::nullopt;
  const auto coordinates = first_independent(equations, q, Y, Kept::coordinates, has_coordinates);
  const auto speeds = first_independent(equations, q, Y, Kept::speeds, has_speeds);
  if (!coordinates || !speeds) return std::nullopt;
  Model fewer = keeping_only(equations.model(), *coordinates, *speeds);
  const Layout& layout = equations.layout();
  for (const BodyIndex i : layout.moving_bodies()) {
    fewer.bodies[i.value].pose_guess = Pose{layout.r(q, i), rotation_of(Vec4(layout.p(q, i)).normalized())};
  }
  return fewer;
}

}  // namespace

Start assemble_start(Equations& equations) {
  try {
    return assemble_as_said(equations);
  } catch (const InputError&) {
    const std::optional<Model> fewer = without_surplus(equations);
    if (!fewer) throw;
    Equations of_fewer(*fewer);
    Start start = assemble_as_said(of_fewer);
    require_written(equations.model(), *fewer, start.state.q, start.state.u);
    return start;
  }
}

}  // namespace concord::cartesian
