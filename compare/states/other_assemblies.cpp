#include "compare/states/other_assemblies.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include "common/error.h"
#include "common/joints/facts.h"
#include "compare/audit/places.h"
#include "compare/states/branch.h"
#include "compare/states/draws.h"

namespace concord::compare {

namespace {

constexpr int kDrawnGuesses = 16;
constexpr int kDrawnOfLoop = 2;
constexpr std::size_t kMostLoops = 16;

/// Bodies above each other in the tree of joints that was built so far.
class JointTree {
 public:
  explicit JointTree(const Model& model) : group_(model.bodies.size()), ways_(model.bodies.size()) {
    for (std::size_t i = 0; i < group_.size(); ++i) group_[i] = static_cast<int>(i);
  }

  /// The way of joints between two bodies; nothing where no joint has connected them yet.
  [[nodiscard]] std::optional<std::vector<int>> way(int from, int to) const {
    if (group_[from] != group_[to]) return std::nullopt;
    std::vector<int> joints;
    return search(from, to, -1, joints) ? std::optional(joints) : std::nullopt;
  }

  void connect(int one, int other, int joint) {
    ways_[one].push_back({other, joint});
    ways_[other].push_back({one, joint});
    const int joined = group_[one];
    const int with = group_[other];
    std::replace(group_.begin(), group_.end(), joined, with);
  }

 private:
  struct Step {
    int body;
    int joint;
  };

  bool search(int from, int to, int came_by, std::vector<int>& joints) const {
    if (from == to) return true;
    for (const Step& step : ways_[from]) {
      if (step.joint == came_by) continue;
      joints.push_back(step.joint);
      if (search(step.body, to, step.joint, joints)) return true;
      joints.pop_back();
    }
    return false;
  }

  std::vector<int> group_;
  std::vector<std::vector<Step>> ways_;
};

/// Guesses of the coordinates that are neither kept nor driven.
class Guesses {
 public:
  /// `start`: a model whose start is the pose that is known.
  explicit Guesses(Model start) : known_(std::move(start)), length_(known_.length_scale()) {
    for (Body& body : known_.bodies) body.pose_guess.reset();  // the coordinates say where bodies are
  }

  [[nodiscard]] Model mirrored(const std::vector<int>& joints) {
    return changed(joints, [](double value, double) { return -value; });
  }
  [[nodiscard]] Model drawn(const std::vector<int>& joints) {
    return changed(joints, [this](double value, double reach) { return value + reach * draws_.next(); });
  }

 private:
  template <class Change>
  Model changed(const std::vector<int>& joints, const Change& change) {
    Model guess = known_;
    for (const int k : joints) {
      Joint& joint = guess.joints[static_cast<std::size_t>(k)];
      for (std::size_t word = 0; word < joint.start.size(); ++word) {
        if (joint.start[word].role_q == StartRole::keep) continue;
        move(joint, static_cast<int>(word), change);
      }
    }
    return guess;
  }

  template <class Change>
  void move(Joint& joint, int word, const Change& change) {
    VecX& q = joint.start[static_cast<std::size_t>(word)].q;
    const joints::Permit& permitted = joint.type->permits[static_cast<std::size_t>(word)];
    if (joints::is_orientation(permitted)) {
      Vec3 turn = rotation_vector_of(rotation_of(Vec4(q).normalized()));
      for (double& entry : turn) entry = change(entry, std::numbers::pi);
      q = turned(Vec4::Unit(0), turn);
      return;
    }
    for (int n = 0; n < static_cast<int>(q.size()); ++n) {
      if (driver_of(joint, word, n) != nullptr) continue;
      q(n) = change(q(n), joints::is_length(permitted, n) ? length_ : std::numbers::pi);
    }
  }

  Model known_;
  double length_;
  Draws draws_{kSeed};
};

bool stand_alike(const Model& model, const State& one, const State& other) {
  constexpr double kOnePose = 1e-6;  // of the machine's length, rad: as far as a start may be known
  const double length = model.length_scale();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyState& a = one.bodies[i];
    const BodyState& b = other.bodies[i];
    if (!((a.r - b.r).norm() <= kOnePose * length)) return false;
    if (!(rotation_vector_of(rotation_of(a.p) * rotation_of(b.p).transpose()).norm() <= kOnePose)) return false;
  }
  return true;
}

/// The start from a guess; nothing where there is none, as on a branch that the model excludes.
std::optional<State> assembled(const Model& guess, const std::function<std::unique_ptr<Solver>(const Model&)>& make) {
  try {
    return make(guess)->assemble();
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const SolverError&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<std::vector<int>> loops_of(const Model& model) {
  std::vector<std::vector<int>> loops;
  JointTree tree(model);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const int parent = model.joints[k].on(Side::parent).body;
    const int child = model.joints[k].on(Side::child).body;
    if (auto way = tree.way(parent, child)) {
      way->push_back(static_cast<int>(k));
      loops.push_back(std::move(*way));
    } else {
      tree.connect(parent, child, static_cast<int>(k));
    }
  }
  return loops;
}

OtherAssemblies find_other_assemblies(const Model& model, const State& start,
                                      const std::function<std::unique_ptr<Solver>(const Model&)>& make,
                                      const std::function<bool(const State&)>& accepts) {
  OtherAssemblies found;
  std::vector<std::vector<int>> loops = loops_of(model);
  if (loops.empty()) return found;
  loops.resize(std::min(loops.size(), kMostLoops));
  Guesses guesses(started_at(model, start));
  const auto try_from = [&](const Model& guess) {
    ++found.guesses;
    const std::optional<State> other = assembled(guess, make);
    if (!other || stand_alike(model, start, *other)) return;
    const auto is_it = [&](const State& known) { return stand_alike(model, known, *other); };
    if (std::any_of(found.states.begin(), found.states.end(), is_it) || !accepts(*other)) return;
    found.states.push_back(*other);
  };
  for (const std::vector<int>& loop : loops) {
    try_from(guesses.mirrored(loop));
    for (int k = 0; k < kDrawnOfLoop; ++k) try_from(guesses.drawn(loop));
  }
  std::vector<int> all(model.joints.size());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
  for (int k = 0; k < kDrawnGuesses; ++k) try_from(guesses.drawn(all));
  return found;
}

}  // namespace concord::compare
