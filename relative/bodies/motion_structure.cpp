#include "relative/bodies/motion_structure.h"

#include <optional>
#include <stdexcept>
#include <utility>

namespace concord::relative {

namespace {

/// Whether the words read so far stand in an order that has a meaning: slides, then turns, then at most one ball, with
/// arms anywhere before it, each turn before a ball with an arm; functions alone.
class OrderOfWords {
 public:
  explicit OrderOfWords(std::size_t n_words) : n_words_(n_words) {}

  [[nodiscard]] bool is_right() const { return is_right_; }

  void operator()(const joints::Slide&) { require(reached_ == Reached::slides); }
  void operator()(const joints::Turn&) {
    require(reached_ != Reached::ball);
    reached_ = Reached::turns;
    turn_waits_for_arm_ = true;
  }
  void operator()(const joints::Arm&) {
    require(reached_ != Reached::ball);
    turn_waits_for_arm_ = false;
  }
  void operator()(const joints::Ball&) {
    require(reached_ != Reached::ball && !turn_waits_for_arm_);
    reached_ = Reached::ball;
  }
  void operator()(const joints::ByMotion&) { require(n_words_ == 1); }

 private:
  enum class Reached { slides, turns, ball };

  void require(bool holds) { is_right_ = is_right_ && holds; }

  std::size_t n_words_;
  Reached reached_ = Reached::slides;
  bool turn_waits_for_arm_ = false;
  bool is_right_ = true;
};

bool stand_in_order(const std::vector<joints::Permit>& words) {
  OrderOfWords order(words.size());
  for (const joints::Permit& word : words) std::visit(order, word);
  return order.is_right();
}

/// Turn{a}, Turn{b}, Arm{c}, Ball{} with a, b and c at right angles: (q_a, q_b) and (q_a + pi, pi - q_b) are one pose.
/// Told word by word.
class LinkOnTwoTurns {
 public:
  void turn(Axis axis) {
    first_ = second_;
    second_ = axis;
    at_right_angles_ = false;
  }
  void arm(Axis axis) {
    at_right_angles_ = first_ && second_ && *first_ != *second_ && *first_ != axis && *second_ != axis;
    first_ = second_ = std::nullopt;
  }
  void other() { *this = {}; }
  /// Whether a ball that follows now ends such a link.
  [[nodiscard]] bool is_complete() const { return at_right_angles_; }

 private:
  std::optional<Axis> first_;
  std::optional<Axis> second_;
  bool at_right_angles_ = false;
};

void require_kinds_of(const joints::ByMotion& by) {
  if (static_cast<int>(by.turns.size()) == by.motion->n()) return;
  throw std::invalid_argument("a motion by functions has " + std::to_string(by.motion->n()) +
                              " coordinates, but says of " + std::to_string(by.turns.size()) +
                              " whether they are turns");
}

/// Classifies the columns of words that stand in order.
class Classifier {
 public:
  void operator()(const joints::Slide& slide) {
    found_.rank_is_certain = found_.rank_is_certain && !slides_[index(slide.axis)];
    slides_[index(slide.axis)] = true;
    found_.has_place = true;
    add({.displaces = true, .rotates = false, .is_length = true, .is_fixed = true, .axis = index(slide.axis)});
    link_.other();
  }

  void operator()(const joints::Turn& turn) {
    ++n_turns_;
    const bool is_another = n_turns_ == 1 || (n_turns_ == 2 && turn.axis != last_turn_);
    found_.rank_is_certain = found_.rank_is_certain && is_another;
    last_turn_ = turn.axis;
    const bool is_first = n_turns_ == 1;
    add({.displaces = false, .rotates = true, .is_length = false, .is_fixed = is_first, .axis = index(turn.axis)});
    link_.turn(turn.axis);
  }

  /// The turns so far swing the arm.
  void operator()(const joints::Arm& arm) {
    for (int c = 0; c < found_.n_u; ++c) {
      if (!found_.kinds[c].rotates) continue;
      found_.kinds[c].displaces = true;
      found_.kinds[c].is_fixed = false;
    }
    found_.is_curved = found_.is_curved || n_turns_ > 0;
    found_.has_place = true;
    link_.arm(arm.axis);
  }

  void operator()(const joints::Ball&) {
    found_.has_ball = true;
    if (link_.is_complete()) found_.elevation = found_.n_u - 1;
    found_.n_scalars = found_.n_u;
    for (int c = 0; c < found_.n_u; ++c) found_.kinds[c].rotates = false;
    for (int axis = 0; axis < 3; ++axis) {
      add({.displaces = false, .rotates = true, .is_length = false, .is_fixed = true, .axis = axis});
    }
  }

  void operator()(const joints::ByMotion& by) {
    require_kinds_of(by);
    found_.by_functions = found_.is_curved = found_.has_place = true;
    found_.ranges = by.ranges;
    for (const bool turns : by.turns) {
      add({.displaces = true, .rotates = true, .is_length = !turns, .is_fixed = false});
    }
  }

  [[nodiscard]] MotionStructure take() {
    if (!found_.has_ball) found_.n_scalars = found_.n_u;
    found_.rank_is_certain = found_.rank_is_certain && !found_.is_curved;
    return std::move(found_);
  }

 private:
  void add(const ColumnKind& kind) { found_.kinds[found_.n_u++] = kind; }

  MotionStructure found_;
  LinkOnTwoTurns link_;
  std::array<bool, 3> slides_{};
  Axis last_turn_ = Axis::x;
  int n_turns_ = 0;
};

}  // namespace

MotionStructure structure_of(const joints::JointType& type) {
  if (!stand_in_order(type.permits) || type.n_u() > 6) {
    throw std::invalid_argument("joint type '" + type.name +
                                "': a motion is slides, then turns, then at most one ball, with arms anywhere before "
                                "it (each turn before a ball "
                                "must carry one), or functions alone; at most six speeds");
  }
  Classifier classifier;
  for (const joints::Permit& word : type.permits) std::visit(classifier, word);
  return classifier.take();
}

}  // namespace concord::relative
