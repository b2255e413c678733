#include "compare/agreement.h"

#include <algorithm>

#include "compare/digits.h"
#include "compare/joint_motion.h"

namespace concord::compare {

namespace {

/// Largest norm of `count` rows from `row` over all samples and both solvers.
double peak(const Series& series, int row, int count) {
  double largest = 0.0;
  for (const MatX& values : series.values) {
    if (values.cols() > 0) largest = std::max(largest, values.middleRows(row, count).colwise().norm().maxCoeff());
  }
  return largest;
}

/// Scale of the first three rows of a block (force, acceleration) and of the next three (torque, angular).
struct BlockScale {
  double linear = 0.0;
  double angular = 0.0;
};

double total_mass(const Model& model) {
  double mass = 0.0;
  for (const Body& body : model.bodies) mass += body.modal ? body.modal->G(0, 0) : body.mass;
  return mass;
}

class Scales {
 public:
  Scales(const Layout& layout, const Series& series)
      : layout_(layout), series_(series), length_(layout.model().length_scale()) {
    collect_wrenches();
    collect_accelerations();
  }

  void assign(const Quantity& quantity, Measured& measured) const {
    const bool is_acceleration = quantity.kind == Kind::acceleration;
    const BlockScale own = is_acceleration ? accelerations_[quantity.owner] : wrench_scale(quantity);
    const BlockScale floor = is_acceleration ? acceleration_floor_ : wrench_floor_;
    if (is_acceleration && quantity.component >= 6) {
      measured.scale = modal_[quantity.owner];
      return;
    }
    const bool angular = unit_of(layout_.model(), quantity) == (is_acceleration ? "rad/s2" : "N m");
    const double scale = angular ? own.angular : own.linear;
    const double least = angular ? floor.angular : floor.linear;
    measured.floored = scale < least;
    measured.scale = std::max(scale, least);
  }

 private:
  [[nodiscard]] BlockScale wrench_at(int row) const {
    const double force = peak(series_, row, 3);
    return {force, std::max(peak(series_, row + 3, 3), force * length_)};
  }

  static void enlarge(BlockScale& scale, const BlockScale& other) {
    scale.linear = std::max(scale.linear, other.linear);
    scale.angular = std::max(scale.angular, other.angular);
  }

  void collect_wrenches() {
    const Model& model = layout_.model();
    on_body_.resize(model.bodies.size());
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        const int joint = static_cast<int>(k);
        reactions_.push_back(wrench_at(layout_.first_row(Kind::reaction, joint, side)));
        totals_.push_back(wrench_at(layout_.first_row(Kind::total, joint, side)));
        enlarge(on_body_[model.joints[k].on(side).body], totals_.back());
        enlarge(wrench_floor_, totals_.back());
        enlarge(wrench_floor_, reactions_.back());
      }
    }
    for (std::size_t k = 0; k < model.elements.size(); ++k) {
      BlockScale& scale = elements_.emplace_back();
      for (const Side side : {Side::parent, Side::child}) {
        if (end_of(model.elements[k], side) == nullptr) continue;
        enlarge(scale, wrench_at(layout_.first_row(Kind::element, static_cast<int>(k), side)));
      }
      enlarge(wrench_floor_, scale);
    }
    hold_idle_joints_against_the_machine(wrench_floor_);
    collect_couplings();
    wrench_floor_ = {kScaleFloor * wrench_floor_.linear, kScaleFloor * wrench_floor_.angular};
  }

  /// The force that would explain all that passes through the joints of a coupling.
  void collect_couplings() {
    const Model& model = layout_.model();
    for (const Coupling& coupling : model.couplings) {
      double scale = 0.0;
      for (const CouplingTerm& term : coupling.terms) {
        const BlockScale& total = totals_[2 * term.joint + index(Side::child)];
        const bool turns = turning_speeds(*model.joints[term.joint].type)[speed_of(model, term)];
        scale = std::max(scale, (turns ? total.angular : total.linear) / std::abs(term.factor));
      }
      couplings_.push_back({scale, scale});
    }
  }

  /// A joint that can carry nothing has no scale of its own, nor has a body that only such joints hold: their round-off
  /// is that of the loads around them.
  void hold_idle_joints_against_the_machine(const BlockScale& machine) {
    const Model& model = layout_.model();
    std::vector<bool> is_held(model.bodies.size(), false);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const bool idle = model.carries_nothing(static_cast<int>(k));
      for (const Side side : {Side::parent, Side::child}) {
        if (!idle) {
          is_held[model.joints[k].on(side).body] = true;
          continue;
        }
        reactions_[2 * k + index(side)] = machine;
        totals_[2 * k + index(side)] = machine;
      }
    }
    for (std::size_t i = 0; i < is_held.size(); ++i) {
      if (!is_held[i]) on_body_[i] = machine;
    }
  }

  void collect_accelerations() {
    const Model& model = layout_.model();
    accelerations_.resize(model.bodies.size());
    modal_.resize(model.bodies.size());
    for (int i = 1; i < static_cast<int>(model.bodies.size()); ++i) {
      const int row = layout_.first_row(Kind::acceleration, i);
      const double spin = series_.spin[i];
      const double linear = std::max(
          {peak(series_, row, 3), peak(series_, row + 3, 3) * length_, spin * spin * length_, model.gravity.norm()});
      accelerations_[i] = {linear, linear / length_};
      enlarge(acceleration_floor_, accelerations_[i]);
      modal_[i] = peak(series_, row + 6, model.bodies[i].n_modes());
    }
    // A body that nothing but its modes moves still has the loads of the machine to be held against.
    const double by_loads = wrench_floor_.linear / total_mass(model);
    acceleration_floor_ = {std::max(kScaleFloor * acceleration_floor_.linear, by_loads),
                           std::max(kScaleFloor * acceleration_floor_.angular, by_loads / length_)};
  }

  [[nodiscard]] BlockScale wrench_scale(const Quantity& quantity) const {
    const int block = 2 * quantity.owner + index(quantity.side);
    switch (quantity.kind) {
      case Kind::body_sum:
        return on_body_[quantity.owner];
      case Kind::element:
        return elements_[quantity.owner];
      case Kind::coupling:
        return couplings_[quantity.owner];
      case Kind::total:
      case Kind::driver:
        return totals_[block];
      default:
        return reactions_[block];
    }
  }

  const Layout& layout_;
  const Series& series_;
  double length_;
  std::vector<BlockScale> reactions_;  // joint-major, parent then child
  std::vector<BlockScale> totals_;
  std::vector<BlockScale> elements_;
  std::vector<BlockScale> couplings_;
  std::vector<BlockScale> on_body_;
  std::vector<BlockScale> accelerations_;
  std::vector<double> modal_;
  BlockScale wrench_floor_;
  BlockScale acceleration_floor_;
};

}  // namespace

std::vector<Measured> measure(const Layout& layout, const Series& series) {
  const Scales scales(layout, series);
  std::vector<Measured> all(layout.quantities().size());
  for (std::size_t row = 0; row < all.size(); ++row) {
    Measured& measured = all[row];
    scales.assign(layout.quantities()[row], measured);
    if (series.times.empty()) continue;
    const auto line = static_cast<Eigen::Index>(row);
    Eigen::Index worst = 0;
    measured.difference = (series.values[0].row(line) - series.values[1].row(line)).cwiseAbs().maxCoeff(&worst);
    measured.worst = static_cast<std::size_t>(worst);
    measured.t = series.times[measured.worst];
    measured.values = {series.values[0](line, worst), series.values[1](line, worst)};
    measured.digits = matching_digits(measured.difference, measured.scale);
  }
  return all;
}

}  // namespace concord::compare
