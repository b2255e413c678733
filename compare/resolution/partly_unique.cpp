#include "compare/resolution/partly_unique.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/products.h"
#include "compare/audit/digits.h"
#include "compare/audit/places.h"
#include "compare/resolution/uniqueness.h"

namespace concord::compare {

namespace {

/// Whether a state is one of the run, and no singular one.
bool is_of_run(const WeighedStates& weighed, std::size_t state) {
  return weighed.states[state].row >= 0 && weighed.singular[state].empty();
}

/// What is open of one force or torque in a state; nullptr where that is not known, or nothing is.
const OpenDirections* open_in(const WeighedStates& weighed, std::size_t state, const Quantity& of) {
  if (!weighed.singular[state].empty() || !weighed.open[state]) return nullptr;
  const auto& all = *weighed.open[state];
  const auto found = std::find_if(all.begin(), all.end(), [&](const OpenReaction& one) { return one.of == of; });
  return found == all.end() ? nullptr : &found->open;
}

/// In the axes of the body on which it acts.
Mat3X in_body(const Model& model, const State& state, const Quantity& of, const Mat3X& directions) {
  const Attachment& side = model.joints[static_cast<std::size_t>(of.owner)].on(of.side);
  const BodyState& body = state.bodies[static_cast<std::size_t>(side.body)];
  return rotation_of(body.p).transpose() * place(side, body).A_joint * directions;
}

/// One force or torque over all states.
class OverStates {
 public:
  OverStates(const QuantityLayout& layout, const WeighedStates& weighed, const Quantity& of)
      : layout_(layout), weighed_(weighed), first_(layout.row_of(of)) {
    part_.of = of;
  }

  /// Whether the components say less than the part does.
  [[nodiscard]] bool is_wanted() {
    std::map<int, int> states;  // of the run, by the number of open directions
    int of_run = 0;
    for (std::size_t k = 0; k < weighed_.states.size(); ++k) {
      if (!is_of_run(weighed_, k)) continue;
      ++of_run;
      if (const OpenDirections* open = open_in(weighed_, k, part_.of))
        ++states[static_cast<int>(open->directions.cols())];
    }
    if (states.empty()) return false;
    const auto most = std::max_element(states.begin(), states.end(),
                                       [](const auto& one, const auto& other) { return one.second < other.second; });
    n_open_ = most->first;
    return 2 * most->second > of_run && n_open_ < open_components();
  }

  [[nodiscard]] bool has_part() const { return part_.samples > 0 && carried_ > n_open_; }

  void judge(const Measured& measured) {
    double largest = 0.0;
    double unexplained = 0.0;
    for (std::size_t k = 0; k < weighed_.states.size(); ++k) {
      const OpenDirections* open = open_in(weighed_, k, part_.of);
      if (open == nullptr || open->directions.cols() != n_open_) continue;
      if (is_of_run(weighed_, k)) look_at(k, *open);
      const Vec3 difference = values(0, k) - values(1, k);
      const Vec3 judged = open->projector() * difference;
      const double leaked = open->doubt * (open->directions.transpose() * difference).norm();
      const double within = kWithinResolution * (resolution_in(k) + leaked);
      if (measured.machine > 0.0 && within > kCoarsest * measured.machine) continue;
      ++part_.samples;
      largest = std::max(largest, judged.norm());
      if (!(judged.norm() <= within)) unexplained = std::max(unexplained, judged.norm());
    }
    part_.digits = matching_digits(largest, measured.scale);
    part_.unexplained_digits = matching_digits(unexplained, measured.scale);
    find_peak();
  }

  [[nodiscard]] const PartlyUnique& result() const { return part_; }

 private:
  /// Components that are not unique in any state.
  [[nodiscard]] int open_components() const {
    int count = 0;
    for (int c = 0; c < 3; ++c) {
      Quantity one = part_.of;
      one.component += c;
      count += can_carry(layout_.model(), one) && !weighed_.mask.row(first_ + c).any() ? 1 : 0;
    }
    return count;
  }

  [[nodiscard]] Vec3 values(std::size_t who, std::size_t state) const {
    return weighed_.series.values[who].block<3, 1>(first_, static_cast<Eigen::Index>(state));
  }

  [[nodiscard]] double resolution_in(std::size_t state) const {
    return weighed_.resolution.both.block<3, 1>(first_, static_cast<Eigen::Index>(state)).norm();
  }

  void look_at(std::size_t k, const OpenDirections& open) {
    constexpr double kFixed = 1e-6;
    const State& state = weighed_.states[k].state;
    const Mat3X directions = in_body(layout_.model(), state, part_.of, open.directions);
    if (sizes_.empty()) {
      part_.left_out = directions;
      part_.t = state.t;
      carried_ = open.carried;
    }
    const Mat3X moved = outside_span(part_.left_out, directions);
    part_.is_fixed = part_.is_fixed && moved.norm() < kFixed;
    carried_ = std::min(carried_, open.carried);
    sizes_.emplace_back(state.t, (open.projector() * values(0, k)).norm());
  }

  void find_peak() {
    constexpr double kAsLarge = 1e-6;
    std::sort(sizes_.begin(), sizes_.end());
    for (const auto& [t, size] : sizes_) part_.peak = std::max(part_.peak, size);
    const auto first = std::find_if(sizes_.begin(), sizes_.end(),
                                    [&](const auto& one) { return one.second >= (1.0 - kAsLarge) * part_.peak; });
    if (first != sizes_.end()) part_.t_peak = first->first;
  }

  const QuantityLayout& layout_;
  const WeighedStates& weighed_;
  int first_;
  int n_open_ = 0;
  int carried_ = 0;
  std::vector<std::pair<double, double>> sizes_;  // of the part, by time
  PartlyUnique part_;
};

}  // namespace

std::vector<PartlyUnique> partly_unique(const QuantityLayout& layout, const WeighedStates& weighed,
                                        const std::vector<Measured>& measured) {
  std::vector<PartlyUnique> all;
  for (const Quantity& quantity : layout.quantities()) {
    if (quantity.kind != Kind::reaction || quantity.component % 3 != 0) continue;
    OverStates one(layout, weighed, quantity);
    if (!one.is_wanted()) continue;
    one.judge(measured[static_cast<std::size_t>(layout.row_of(quantity))]);
    if (one.has_part()) all.push_back(one.result());
  }
  return all;
}

std::optional<PlanarLoops> planar_loops(const Model& model, const WeighedStates& weighed) {
  std::optional<PlanarLoops> found;
  for (std::size_t k = 0; k < weighed.states.size(); ++k) {
    if (!is_of_run(weighed, k) || !weighed.open[k]) continue;
    std::optional<PlanarLoops> here = planar_loops(model, weighed.states[k].state, *weighed.open[k]);
    if (!here || (found && found->joints != here->joints)) return std::nullopt;
    if (!found) found = std::move(here);
  }
  return found;
}

}  // namespace concord::compare
