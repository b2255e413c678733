#include "relative/start/start.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "common/error.h"
#include "relative/rank/closing.h"
#include "relative/start/start_advice.h"
#include "relative/start/start_search.h"

namespace concord::relative {

namespace {

const char* name_of(ClosureRows rows) { return rows == ClosureRows::of_positions ? "coordinates" : "speeds"; }

/// For machines that are driven: the pose in which they are easy to write may be one in which rows depend.
constexpr const char* kMayBeSingular =
    "; a start in a singular pose, such as a linkage lying flat or stretched, seems to have more: start it elsewhere";

std::string degrees(int n) { return fmt::format("{} degree{} of freedom", n, n == 1 ? "" : "s"); }

}  // namespace

/// The driven speeds and those of every word with role `keep`.
PrescribedMask Start::kept(StartRole WordStart::*role) const {
  PrescribedMask prescribed = scaled_->equations().driven();
  const Model& model = stated();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      if (joint.start[word].*role != StartRole::keep) continue;
      const int first =
          scaled_->equations().topology().joints[k].first_u + first_u(*joint.type, static_cast<int>(word));
      std::fill_n(prescribed.begin() + first, n_u(joint.type->permits[word]), static_cast<char>(1));
    }
  }
  return prescribed;
}

/// Coordinates of the joints between the guessed poses of the bodies.
void Start::measure_unsaid(Coordinates& coordinates) const {
  const Model& model = scaled_->equations().model();
  const std::vector<Pose> poses = guess_poses(model);
  std::vector<BodyState> bodies(model.bodies.size());
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const Span& modes = scaled_->equations().topology().modes[i];
    const Eigen::Quaterniond p(poses[i].A);
    bodies[i].r = poses[i].r;
    bodies[i].p << p.w(), p.x(), p.y(), p.z();
    bodies[i].a = coordinates.q.segment(modes.first_q, modes.n_q);
    bodies[i].adot = coordinates.u.segment(modes.first_u, modes.n_u);
  }
  Kinematics kinematics(model);
  kinematics.place(bodies);
  const PrescribedMask nothing(scaled_->equations().topology().n_u, 0);
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
    JointMeasure measured(kinematics.mobilizer(k), nothing.data());
    measured.find_q(kinematics.point(k, Side::parent), kinematics.point(k, Side::child),
                    coordinates.q.data() + scaled_->equations().topology().joints[k].first_q,
                    JointMeasure::Restart::if_better);
  }
}

/// What the model says of the start; where it says nothing, what the guessed poses give.
Coordinates Start::guess() const {
  const Model& model = stated();
  const Topology& topology = scaled_->equations().topology();
  Coordinates start{0.0, scaled_->equations().home(), VecX::Zero(topology.n_u)};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const Span& modes = topology.modes[i];
    if (body.a_start.size() > 0) start.q.segment(modes.first_q, modes.n_q) = body.a_start;
    if (body.adot_start.size() > 0) start.u.segment(modes.first_u, modes.n_u) = body.adot_start;
  }
  const auto say = [&](bool unsaid_too) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Joint& joint = model.joints[k];
      for (std::size_t word = 0; word < joint.start.size(); ++word) {
        const WordStart& said = joint.start[word];
        const int iq = topology.joints[k].first_q + first_q(*joint.type, static_cast<int>(word));
        const int iu = topology.joints[k].first_u + first_u(*joint.type, static_cast<int>(word));
        if (said.q.size() > 0 && (unsaid_too || said.role_q != StartRole::unsaid)) {
          start.q.segment(iq, said.q.size()) = said.q;
        }
        if (said.u.size() > 0 && said.role_u != StartRole::unsaid) start.u.segment(iu, said.u.size()) = said.u;
      }
    }
  };
  say(true);
  measure_unsaid(start);
  say(false);
  scaled_->equations().prescribe(0.0, start.q, start.u);
  return start;
}

std::string Start::names_of_kept(const PrescribedMask& prescribed) const {
  const Model& model = scaled_->equations().model();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Span& span = scaled_->equations().topology().joints[k];
    int count = 0;
    for (int c = span.first_u; c < span.first_u + span.n_u; ++c) {
      if (prescribed[c] != 0 && scaled_->equations().driven()[c] == 0) ++count;
    }
    if (count > 0) names.push_back(fmt::format("{} of joint '{}'", count, model.joints[k].name));
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

SourceLocation Start::where_kept(const PrescribedMask& prescribed) const {
  const Model& model = scaled_->equations().model();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Span& span = scaled_->equations().topology().joints[k];
    for (int c = span.first_u; c < span.first_u + span.n_u; ++c) {
      if (prescribed[c] != 0 && scaled_->equations().driven()[c] == 0) return model.joints[k].where;
    }
  }
  return model.joints.empty() ? SourceLocation{model.file, 0, 0} : model.joints.front().where;
}

/// The couplings that relate nothing but kept and driven values, for the end of a message about the former.
std::string Start::couplings_of_kept(const PrescribedMask& prescribed) const {
  const Model& model = scaled_->equations().model();
  std::string text;
  for (const Coupling& coupling : model.couplings) {
    std::vector<std::string> names;
    for (const CouplingTerm& term : coupling.terms) {
      const Joint& joint = model.joints[term.joint];
      const int place = first_u(*joint.type, term.word) + term.component;
      if (prescribed[scaled_->equations().topology().joints[term.joint].first_u + place] == 0) break;
      names.push_back(fmt::format("'{}'", joint.name));
    }
    if (names.size() < coupling.terms.size()) continue;
    text += fmt::format("; coupling '{}' relates those of joints {}", coupling.name, fmt::join(names, ", "));
  }
  return text;
}

/// What cannot be kept: a ball is kept as a whole, but a rod that ends in two of them has one idle turn.
const char* Start::idle_turn(const PrescribedMask& prescribed) const {
  const Model& model = scaled_->equations().model();
  std::map<int, int> unkept_at;  // balls of a body
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const Mobilizer mobilizer(*joint.type);
    const bool turns_as_a_ball = mobilizer.n_u() == 3 && joints::is_orientation(joint.type->permits[0]);
    const int first = scaled_->equations().topology().joints[k].first_u;
    if (!turns_as_a_ball || prescribed[first] != 0) continue;
    for (const Side side : {Side::parent, Side::child}) ++unkept_at[joint.on(side).body];
  }
  unkept_at.erase(kGround);
  const bool is_idle = std::any_of(unkept_at.begin(), unkept_at.end(), [](const auto& one) { return one.second > 1; });
  return !is_idle ? ""
                  : "; a rod with a ball at either end spins about its axis as it likes: a universal joint for "
                    "one of the balls holds it";
}

/// As many kept values as degrees of freedom, modes and drivers not counted. `coordinates` are closed.
void Start::require_number_of_kept(const Coordinates& coordinates, const PrescribedMask& prescribed,
                                   ClosureRows rows) const {
  const auto [n_kept, freedom, allowed] = count_kept(coordinates, prescribed, rows);
  if (n_kept >= freedom && n_kept - freedom <= allowed) return;
  const auto role = rows == ClosureRows::of_positions ? &WordStart::role_q : &WordStart::role_u;
  const std::vector<StartWord> words = words_to_keep(*scaled_, coordinates, rows, role);
  throw InputError(
      where_kept(prescribed),
      fmt::format("start: the machine has {} beside its drivers and modes, so {} joint {} must be kept{}, but "
                  "{} are ({}){}{}{}",
                  degrees(freedom), freedom, name_of(rows),
                  words.empty() ? "" : ", for example " + names_of(scaled_->equations().model(), words), n_kept,
                  names_of_kept(prescribed), couplings_of_kept(prescribed),
                  n_kept < freedom ? idle_turn(prescribed) : "",
                  scaled_->equations().has_drivers() ? kMayBeSingular : ""));
}

void Start::require_independent(const Coordinates& coordinates, const PrescribedMask& prescribed,
                                ClosureRows rows) const {
  Closure closure(scaled_->equations().kinematics(), prescribed);
  Coordinates copy = coordinates;
  measure(*scaled_, copy, closure);
  const std::vector<int> columns = scaled_->moving_columns(prescribed, Modes::kept);
  if (scaled_->rank_here(closure, rows, columns) == static_cast<int>(columns.size())) return;
  throw InputError(where_kept(prescribed),
                   fmt::format("start: the kept joint {} ({}) depend on each other and leave the rest "
                               "of the machine free: keep others{}",
                               name_of(rows), names_of_kept(prescribed), couplings_of_kept(prescribed)));
}

void Start::require_inertia(const Coordinates& coordinates) const {
  const auto slack = scaled_->equations().find_motion_without_inertia(coordinates.t, coordinates.q, coordinates.u);
  if (!slack) return;
  const Link& link = scaled_->equations().topology().links[slack->link];
  const Vec6 twist = scaled_->equations().kinematics().joint_motion(link.joint).S.leftCols(slack->u.size()) * slack->u;
  const bool slides = scaled_->size().length() * twist.tail<3>().norm() <= 1e-6 * twist.head<3>().norm();
  Vec3 direction = (slides ? twist.head<3>() : twist.tail<3>()).normalized();
  Eigen::Index largest_entry = 0;
  direction.cwiseAbs().maxCoeff(&largest_entry);
  if (direction(largest_entry) < 0.0) direction = -direction;
  const Vec3 shown = direction.unaryExpr([](double x) { return std::abs(x) < 1e-12 ? 0.0 : x; });
  const Joint& joint = scaled_->equations().model().joints[link.joint];
  const bool has_loops = !scaled_->equations().topology().cuts.empty();
  const std::string message = fmt::format(
      "body '{}' and all that it carries{} have no inertia {} the axis ({:.4g}, {:.4g}, {:.4g}) of joint '{}' "
      "(parent's "
      "joint frame): give it inertia{}",
      scaled_->equations().model().bodies[link.body].name, has_loops ? " in the opened tree" : "",
      slides ? "along" : "about", shown.x(), shown.y(), shown.z(), joint.name,
      has_loops ? " or name another cut joint" : "");
  if (has_loops) throw UnsuitableCut(joint.where, message);
  throw InputError(joint.where, message);
}

void Start::throw_not_closing(const Coordinates& guess, const PrescribedMask& prescribed, bool closes_unkept) const {
  const std::string opening = words_of_open_loop(*scaled_, guess, prescribed);
  const std::string where = opening.empty() ? "" : "; " + opening;
  if (!closes_unkept) {
    throw StartNotFound(where_kept(prescribed),
                        fmt::format("start: the loops of {} cannot be closed near the start values, whatever is "
                                    "kept{}: correct the points and axes of the loop's joints, or give better guesses "
                                    "of joint coordinates or body poses{}",
                                    scaled_->equations().model().name, where, couplings_of_kept(prescribed)));
  }
  throw StartNotFound(
      where_kept(prescribed),
      fmt::format("start: the kept joint coordinates ({}) contradict each other, or the guesses are too "
                  "far off: the loops do not close with them{}{}",
                  names_of_kept(prescribed), where, couplings_of_kept(prescribed)));
}

namespace {

/// Whether whole turns of a coordinate that is one number change no pose: an angle about an axis, and nothing else.
bool changes_no_pose_by_turns(const joints::Permit& word, int component) {
  const joints::StatedCoordinate coordinate = stated_coordinates(word)[component];
  return coordinate.kind == joints::CoordinateKind::angle && coordinate.axis.has_value();
}

}  // namespace

/// Whole turns, which change no pose, for couplings that are off by more: on the turn with the smallest factor among
/// those that are not prescribed.
void Start::add_turns_of_couplings(Coordinates& coordinates, const PrescribedMask& prescribed) const {
  const Model& model = scaled_->equations().model();
  const Topology& topology = scaled_->equations().topology();
  for (const Coupling& coupling : model.couplings) {
    const CouplingTerm* least = nullptr;
    for (const CouplingTerm& term : coupling.terms) {
      const int column = first_u(*model.joints[term.joint].type, term.word) + term.component;
      if (prescribed[topology.joints[term.joint].first_u + column] != 0) continue;
      if (!changes_no_pose_by_turns(model.joints[term.joint].type->permits[term.word], term.component)) continue;
      if (least == nullptr || std::abs(term.factor) < std::abs(least->factor)) least = &term;
    }
    if (least == nullptr) continue;
    const double turn = 2.0 * std::numbers::pi * least->factor;
    const double turns =
        std::round(compute_position_residual(coupling, scaled_->equations().kinematics(), coordinates.q) / turn);
    const int place = first_q(*model.joints[least->joint].type, least->word) + least->component;
    coordinates.q(topology.joints[least->joint].first_q + place) -= 2.0 * std::numbers::pi * turns;
  }
}

/// Gives links without prescribed values their canonical names, and requires that the others are on the branches
/// that the start values choose.
void Start::choose_branches(Coordinates& closed, const Coordinates& said, const PrescribedMask& prescribed_q,
                            const PrescribedMask& prescribed_u) const {
  const Model& model = scaled_->equations().model();
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
    const Span& span = scaled_->equations().topology().joints[k];
    const Mobilizer& mobilizer = scaled_->equations().kinematics().mobilizer(k);
    if (!mobilizer.has_elevation()) continue;
    bool is_prescribed = false;
    for (int c = span.first_u; c < span.first_u + span.n_u; ++c)
      is_prescribed = is_prescribed || prescribed_q[c] != 0 || prescribed_u[c] != 0;
    if (!is_prescribed) {
      mobilizer.choose_canonical_chart(closed.q.data() + span.first_q);
    } else if (!mobilizer.is_on_branch_of(closed.q.data() + span.first_q, said.q.data() + span.first_q)) {
      throw InputError(model.joints[k].where,
                       fmt::format("start: joint '{}' closes on another branch than its start values say: a link's "
                                   "second turn passes a quarter turn: give other guesses or keep other coordinates",
                                   model.joints[k].name));
    }
  }
}

/// Requires that the start holds the kept values to round-off.
void Start::require_kept(const Coordinates& closed, const Coordinates& said) const {
  constexpr double kRoundOffOfKept = 1e-11;
  const Model& model = stated();
  const double rate = scaled_->size().rate_at(closed.u);
  const auto require = [&](const Joint& joint, const char* what, const VecX& found, const VecX& kept, double allowed,
                           const VecX& left_out) {
    if ((found - kept).cwiseAbs().maxCoeff() <= allowed) return;
    throw StartNotFound(joint.where, fmt::format("start: joint '{}' keeps the {} ({:.9g}), but the machine closes with "
                                                 "({:.9g}): keep others",
                                                 joint.name, what, fmt::join(VecX(kept + left_out), ", "),
                                                 fmt::join(VecX(found + left_out), ", ")));
  };
  const VecX angles = static_cast<double>(kWholeTurn) * scaled_->equations().kinematics().turns();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const Span& span = scaled_->equations().topology().joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const WordStart& start = joint.start[word];
      const int iq = span.first_q + first_q(*joint.type, static_cast<int>(word));
      const int iu = span.first_u + first_u(*joint.type, static_cast<int>(word));
      if (start.role_q == StartRole::keep && start.q.size() > 0) {
        const auto n = start.q.size();
        VecX found = closed.q.segment(iq, n);
        VecX kept = said.q.segment(iq, n);
        if (is_orientation(joint.type->permits[word])) {
          kept.normalize();
          if (found.dot(kept) < 0.0) kept = -kept;
        }
        const double unit = scaled_->size().coordinates()(iq);
        require(joint, "coordinates", found, kept, kRoundOffOfKept * std::max(unit, kept.cwiseAbs().maxCoeff()),
                angles.segment(iq, n));
      }
      if (start.role_u == StartRole::keep && start.u.size() > 0) {
        const auto n = start.u.size();
        require(joint, "speeds", closed.u.segment(iu, n), said.u.segment(iu, n),
                kRoundOffOfKept * rate * scaled_->size().speeds()(iu), VecX::Zero(n));
      }
    }
  }
}

Coordinates Start::find_as_said() const {
  scaled_->equations().count_turns(VecX::Zero(scaled_->equations().topology().n_q));
  Coordinates start = guess();
  const PrescribedMask prescribed_q = kept(&WordStart::role_q);
  const PrescribedMask prescribed_u = kept(&WordStart::role_u);
  add_turns_of_couplings(start, prescribed_q);
  scaled_->equations().count_turns(scaled_->equations().kinematics().whole_turns(start.q));
  start.q = scaled_->equations().kinematics().without_turns(start.q);
  Coordinates closed = start;
  bool kept_agree = close_positions(*scaled_, closed, prescribed_q, Modes::kept);
  has_searched_ = !kept_agree;
  if (!kept_agree) {
    const std::optional<Coordinates> found = search_closed_start(*scaled_, start, prescribed_q);
    kept_agree = found.has_value();
    closed = found.value_or(start);
  }
  const PrescribedMask& driven = scaled_->equations().driven();
  const bool closes_unkept =
      kept_agree || (prescribed_q != driven && close_positions(*scaled_, closed, driven, Modes::kept));
  if (closes_unkept) require_number_of_kept(closed, prescribed_q, ClosureRows::of_positions);
  if (!kept_agree) throw_not_closing(start, prescribed_q, closes_unkept);
  closed.u = start.u;  // closing the positions has measured the cut joints' speeds, those too that are kept
  choose_branches(closed, start, prescribed_q, prescribed_u);
  require_independent(closed, prescribed_q, ClosureRows::of_positions);
  require_number_of_kept(closed, prescribed_u, ClosureRows::of_velocities);
  require_independent(closed, prescribed_u, ClosureRows::of_velocities);
  require_inertia(closed);
  if (!close_velocities(*scaled_, closed, prescribed_u, Modes::kept)) {
    throw StartNotFound(where_kept(prescribed_u),
                        fmt::format("start: the kept joint speeds ({}) contradict each other{}",
                                    names_of_kept(prescribed_u), couplings_of_kept(prescribed_u)));
  }
  scaled_->move(closed);
  require_kept(closed, start);
  if (fewer_) require_as_written(closed);
  return closed;
}

}  // namespace concord::relative
