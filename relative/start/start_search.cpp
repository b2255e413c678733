#include "relative/start/start_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/error.h"

namespace concord::relative {

namespace {

constexpr int kStarts = 12;
constexpr double kPartOfGuesses = 0.1;  // of how far a coordinate without a guess is moved

/// Calls use(word of the start, its type, first entry of q, first entry of u) for every word that has coordinates.
template <class Use>
void for_each_word(const Equations& equations, const Use& use) {
  const Model& model = equations.model();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const Span& span = equations.topology().joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const int place = static_cast<int>(word);
      if (joint.start[word].q.size() == 0) continue;  // an arm
      use(joint.start[word], joint.type->permits[word], span.first_q + first_q(*joint.type, place),
          span.first_u + first_u(*joint.type, place));
    }
  }
}

double whole_turns_off(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// How far each speed of the tree (SI) is moved at most; prescribed ones and modes not at all.
VecX reach_of_moves(const ScaledClosure& scaled, const PrescribedMask& prescribed) {
  const Equations& equations = scaled.equations();
  VecX reach = VecX::Zero(equations.topology().n_u);
  for_each_word(equations, [&](const WordStart& said, const joints::Permit& word, int /*first_q*/, int first_u) {
    const double part = said.role_q == StartRole::guess ? kPartOfGuesses : 1.0;
    for (int c = 0; c < n_u(word); ++c) {
      const bool slides = !joints::is_orientation(word) && joints::is_length(word, c);
      const int at = first_u + c;
      if (prescribed[at] == 0) reach(at) = part * (slides ? 1.0 : std::numbers::pi) * scaled.size().speeds()(at);
    }
  });
  return reach.head(equations.topology().n_tree_u);
}

/// Whether a word's only coordinate turns about an axis, so that whole turns change no pose.
bool is_turn(const joints::Permit& word) {
  const joints::StatedCoordinates stated = joints::stated_coordinates(word);
  return stated.size() == 1 && stated[0].axis && stated[0].kind == joints::CoordinateKind::angle;
}

/// Takes whole turns that Newton's steps have made back, where no coupling counts them: angles lie within half a turn
/// of their guesses, of zero where there is none.
void unwind(const ScaledClosure& scaled, const Coordinates& from, const PrescribedMask& prescribed,
            Coordinates& closed) {
  if (!scaled.equations().model().couplings.empty()) return;
  for_each_word(scaled.equations(), [&](const WordStart& said, const joints::Permit& word, int first_q, int first_u) {
    if (!is_turn(word) || prescribed[first_u] != 0) return;
    const double middle = said.role_q == StartRole::guess ? from.q(first_q) : 0.0;
    closed.q(first_q) = middle + whole_turns_off(closed.q(first_q) - middle);
  });
}

/// Square of the distance from `from` in the machine's units; what the model does not say counts little.
double departure(const ScaledClosure& scaled, const Coordinates& from, const Coordinates& closed) {
  constexpr double kUnsaid = 1e-3;
  double sum = 0.0;
  for_each_word(scaled.equations(), [&](const WordStart& said, const joints::Permit& word, int first_q, int) {
    const auto n = said.q.size();
    const double weight = said.role_q == StartRole::guess ? 1.0 : kUnsaid;
    const auto now = closed.q.segment(first_q, n);
    const auto then = from.q.segment(first_q, n);
    if (joints::is_orientation(word)) {
      sum += weight * (1.0 - std::abs(now.normalized().dot(then.normalized())));
    } else {
      VecX apart = now - then;
      if (is_turn(word)) apart(0) = whole_turns_off(apart(0));
      sum += weight * apart.cwiseQuotient(scaled.size().coordinates().segment(first_q, n)).squaredNorm();
    }
  });
  return sum;
}

}  // namespace

std::optional<Coordinates> search_closed_start(const ScaledClosure& scaled, const Coordinates& from,
                                               const PrescribedMask& prescribed) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> spread(-1.0, 1.0);
  const VecX reach = reach_of_moves(scaled, prescribed);
  std::optional<Coordinates> nearest;
  double least = HUGE_VAL;
  for (int k = 0; k < kStarts; ++k) {
    Coordinates trial = from;
    VecX move = reach;
    for (double& entry : move) entry *= spread(engine);
    scaled.advance(trial.q, move);
    try {
      if (!close_positions(scaled, trial, prescribed, Modes::kept)) continue;
    } catch (const SolverError&) {
      continue;  // the machine has no such pose
    }
    unwind(scaled, from, prescribed, trial);
    const double distance = departure(scaled, from, trial);
    if (distance >= least) continue;
    least = distance;
    nearest = std::move(trial);
  }
  return nearest;
}

}  // namespace concord::relative
