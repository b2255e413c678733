#include "compare/oracle/plan.h"

#include <algorithm>

namespace concord::compare::oracle {

namespace {

class Planner {
 public:
  explicit Planner(const Model& model) : model_(model), reached_(model.bodies.size(), false) {
    reached_[kGround] = true;
  }

  std::vector<Step> plan() {
    grow();
    while (const int body = next_free()) {
      add({-1, body, true});
      grow();
    }
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      const int joint = static_cast<int>(k);
      const auto is_it = [&](const Step& step) { return step.joint == joint; };
      if (std::none_of(steps_.begin(), steps_.end(), is_it)) steps_.push_back({joint, child(joint), false});
    }
    return steps_;
  }

 private:
  [[nodiscard]] int parent(int k) const { return model_.joints[k].on(Side::parent).body; }
  [[nodiscard]] int child(int k) const { return model_.joints[k].on(Side::child).body; }

  void add(const Step& step) {
    steps_.push_back(step);
    reached_[step.body] = true;
  }

  /// Adds bodies through joints from what is reached, until there are none.
  void grow() {
    for (bool grows = true; grows;) {
      grows = false;
      for (int k = 0; k < static_cast<int>(model_.joints.size()); ++k) {
        if (!reached_[parent(k)] || reached_[child(k)]) continue;
        add({k, child(k), true});
        grows = true;
      }
    }
  }

  /// A body that is not reached, one that no joint carries if there is such; 0 if all are reached.
  [[nodiscard]] int next_free() const {
    int found = 0;
    for (int body = 1; body < static_cast<int>(model_.bodies.size()); ++body) {
      if (reached_[body]) continue;
      if (found == 0) found = body;
      const auto carries = [&](const Joint& joint) { return joint.on(Side::child).body == body; };
      if (std::none_of(model_.joints.begin(), model_.joints.end(), carries)) return body;
    }
    return found;
  }

  const Model& model_;
  std::vector<bool> reached_;
  std::vector<Step> steps_;
};

}  // namespace

std::vector<Step> plan_of(const Model& model) { return Planner(model).plan(); }

std::vector<int> parts_of(const Model& model, const std::vector<Step>& plan) {
  std::vector<int> parts(model.bodies.size(), 0);
  for (const Step& step : plan) ++parts[step.body];
  return parts;
}

}  // namespace concord::compare::oracle
