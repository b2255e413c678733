#include "compare/quantities/agreement.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "compare/audit/digits.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/machine_size.h"
#include "compare/quantities/align.h"

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
  ScaleSource linear_source = ScaleSource::own_peak;
  ScaleSource angular_source = ScaleSource::own_peak;
};

/// Radius of gyration about the body's origin [m].
double radius_of(const Body& body) {
  if (body.modal) return std::sqrt(body.modal->G.block<3, 3>(1, 1).trace() / body.modal->G(0, 0));
  if (!(body.mass > 0.0)) return 0.0;
  return std::sqrt(0.5 * body.inertia_L.trace() / body.mass + body.center_of_mass_L.squaredNorm());
}

class Scales {
 public:
  Scales(const QuantityLayout& layout, const Series& series)
      : layout_(layout), series_(series), length_(layout.model().length_scale()) {
    collect_wrenches();
    collect_accelerations();
  }

  void assign(const Quantity& quantity, Measured& measured) const {
    const bool is_acceleration = quantity.kind == Kind::acceleration;
    if (is_acceleration && quantity.component >= 6) {
      measured.scale = measured.machine = modal_[quantity.owner];
      return;
    }
    const BlockScale own = is_acceleration ? accelerations_[quantity.owner] : wrench_scale(quantity);
    const BlockScale floor = is_acceleration ? acceleration_floor_ : wrench_floor_;
    const bool angular = unit_of(layout_.model(), quantity) == (is_acceleration ? "rad/s2" : "N m");
    const double scale = angular ? own.angular : own.linear;
    const double least = angular ? floor.angular : floor.linear;
    measured.scale = std::max(scale, least);
    measured.source = scale < least ? ScaleSource::floor : (angular ? own.angular_source : own.linear_source);
    measured.machine = std::max(measured.scale, least / kScaleFloor);
  }

 private:
  [[nodiscard]] BlockScale wrench_at(int row) const {
    const double force = peak(series_, row, 3);
    const double torque = peak(series_, row + 3, 3);
    const bool by_lever = force * length_ > torque;
    return {force, by_lever ? force * length_ : torque, ScaleSource::own_peak,
            by_lever ? ScaleSource::lever : ScaleSource::own_peak};
  }

  static void enlarge(BlockScale& scale, const BlockScale& other) {
    if (other.linear > scale.linear) {
      scale.linear = other.linear;
      scale.linear_source = other.linear_source;
    }
    if (other.angular > scale.angular) {
      scale.angular = other.angular;
      scale.angular_source = other.angular_source;
    }
  }

  /// Weight and inertia of the bodies: what joints would pass on if they passed anything. A balanced rotor counts as if
  /// its mass went round at its radius of gyration: that none of it does is known to round-off.
  [[nodiscard]] BlockScale loads() const {
    const Model& model = layout_.model();
    BlockScale largest;
    for (int i = 1; i < static_cast<int>(model.bodies.size()); ++i) {
      const int row = layout_.first_row(Kind::acceleration, i);
      const double acceleration =
          std::max(peak(series_, row, 3), turning_of(i) * radius_of(model.bodies[i])) + model.gravity.norm();
      const double force = mass_of(model.bodies[i]) * acceleration;
      enlarge(largest, {force, force * length_});
    }
    return largest;
  }

  /// Largest angular acceleration, or angular velocity squared [1/s2].
  [[nodiscard]] double turning_of(int body) const {
    const double spin = series_.spin[body];
    return std::max(peak(series_, layout_.first_row(Kind::acceleration, body) + 3, 3), spin * spin);
  }

  void collect_wrenches() {
    const Model& model = layout_.model();
    on_body_.resize(model.bodies.size());
    by_couplings_ = forces_by_couplings();
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        const int joint = static_cast<int>(k);
        reactions_.push_back(wrench_at(layout_.first_row(Kind::reaction, joint, side)));
        totals_.push_back(wrench_at(layout_.first_row(Kind::total, joint, side)));
        enlarge(totals_.back(), by_couplings_[k]);
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
    enlarge(wrench_floor_, loads());
    on_speeds_ = forces_on_speeds();
    for (const BlockScale& scale : on_speeds_) enlarge(wrench_floor_, scale);
    wrench_floor_.linear = std::max(wrench_floor_.linear, wrench_floor_.angular / length_);
    wrench_floor_.linear_source = wrench_floor_.angular_source = ScaleSource::floor;
    hold_idle_joints_against_the_machine(wrench_floor_);
    for (std::size_t k = 0; k < on_speeds_.size(); ++k) {
      BlockScale passed = totals_[2 * k + index(Side::child)];
      enlarge(passed, on_speeds_[k]);
      on_speeds_[k] = passed;
    }
    collect_couplings();
    wrench_floor_ = {kScaleFloor * wrench_floor_.linear, kScaleFloor * wrench_floor_.angular};
  }

  /// Peaks of what springs and drivers exert in each joint: one that balances its own springs, as an edge does, passes
  /// nothing of them on.
  [[nodiscard]] std::vector<BlockScale> forces_on_speeds() const {
    std::vector<BlockScale> scales(layout_.model().joints.size());
    for (std::size_t row = 0; row < layout_.quantities().size(); ++row) {
      const Quantity& quantity = layout_.quantities()[row];
      if (quantity.kind != Kind::tau && quantity.kind != Kind::share) continue;
      const double largest = peak(series_, static_cast<int>(row), 1);
      const bool is_torque = unit_of(layout_.model(), quantity) == "N m";
      enlarge(scales[quantity.owner], is_torque ? BlockScale{0.0, largest} : BlockScale{largest, 0.0});
    }
    return scales;
  }

  /// Peaks of what couplings exert in each joint: a gear passes a motor's torque on to a brake, and the joint's total,
  /// in which both stand, is next to nothing.
  [[nodiscard]] std::vector<BlockScale> forces_by_couplings() const {
    const Model& model = layout_.model();
    std::vector<BlockScale> scales(model.joints.size());
    for (std::size_t c = 0; c < model.couplings.size(); ++c) {
      const double force = peak_of_coupling(c);
      for (const CouplingTerm& term : model.couplings[c].terms) {
        const double exerted = force * std::abs(term.factor);
        enlarge(scales[term.joint], is_turn(model, term) ? BlockScale{0.0, exerted} : BlockScale{exerted, 0.0});
      }
    }
    return scales;
  }

  [[nodiscard]] double peak_of_coupling(std::size_t coupling) const {
    return peak(series_, layout_.row_of({Kind::coupling, static_cast<int>(coupling), Side::child, 0}), 1);
  }

  /// Scale of a coupling's force: its own peak, or the force that would cause the whole load of one of its joints.
  void collect_couplings() {
    const Model& model = layout_.model();
    for (std::size_t c = 0; c < model.couplings.size(); ++c) {
      const Coupling& coupling = model.couplings[c];
      double scale = peak_of_coupling(c);
      for (const CouplingTerm& term : coupling.terms) {
        const BlockScale& total = totals_[2 * term.joint + index(Side::child)];
        scale = std::max(scale, (is_turn(model, term) ? total.angular : total.linear) / std::abs(term.factor));
      }
      couplings_.push_back({scale, scale});
    }
  }

  /// A joint that can carry nothing has no scale of its own, and neither has a body that only such joints hold. They
  /// get the machine's scale, because their round-off comes from the loads around them.
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
      const double own = peak(series_, row, 3);
      const double by_turning = turning_of(i) * length_;
      const double gravity = model.gravity.norm();
      const double linear = std::max({own, by_turning, gravity});
      const ScaleSource source = linear == own          ? ScaleSource::own_peak
                                 : linear == by_turning ? ScaleSource::lever
                                                        : ScaleSource::gravity;
      accelerations_[i] = {linear, linear / length_, source, source};
      enlarge(acceleration_floor_, accelerations_[i]);
      modal_[i] = peak(series_, row + 6, model.bodies[i].n_modes());
    }
    // A coupling may hold a body at rest against a motor. The scale is then the acceleration that the coupling alone
    // would give the body.
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Attachment& side : model.joints[k].sides) {
        const Body& body = model.bodies[side.body];
        if (side.body == kGround || !(mass_of(body) > 0.0)) continue;
        const double radius = radius_of(body);
        const double turning = radius > 0.0 ? by_couplings_[k].angular / (mass_of(body) * radius * radius) : 0.0;
        const double linear = std::max(by_couplings_[k].linear / mass_of(body), turning * length_);
        if (linear > 0.0) enlarge(accelerations_[side.body], {linear, linear / length_});
      }
    }
    // A body that nothing but its modes moves still has the loads of the machine to be compared with.
    const double by_loads = wrench_floor_.linear / MachineSize(model).mass;
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
      case Kind::tau:
      case Kind::share:
        return on_speeds_[quantity.owner];
      case Kind::total:
        return totals_[block];
      default:
        return reactions_[block];
    }
  }

  const QuantityLayout& layout_;
  const Series& series_;
  double length_;
  std::vector<BlockScale> reactions_;  // joint-major, parent then child
  std::vector<BlockScale> totals_;
  std::vector<BlockScale> on_speeds_;  // of joints, by the larger of the total and of what springs and drivers exert
  std::vector<BlockScale> elements_;
  std::vector<BlockScale> couplings_;
  std::vector<BlockScale> by_couplings_;  // of joints
  std::vector<BlockScale> on_body_;
  std::vector<BlockScale> accelerations_;
  std::vector<double> modal_;
  BlockScale wrench_floor_;
  BlockScale acceleration_floor_;
};

}  // namespace

const char* name_of(ScaleSource source) {
  switch (source) {
    case ScaleSource::own_peak:
      return "peak";
    case ScaleSource::lever:
      return "F l";
    case ScaleSource::gravity:
      return "g";
    default:
      return "floor";
  }
}

namespace {

/// Goes over the samples of one quantity.
void measure_row(const Series& series, const Budget& budget, Eigen::Index row, Measured& measured) {
  std::optional<Eigen::Index> worst;
  for (Eigen::Index sample = 0; sample < series.values[0].cols(); ++sample) {
    if (budget.judged != nullptr && !(*budget.judged)(row, sample)) {
      ++measured.not_unique;
      continue;
    }
    const double resolution =
        budget.resolution != nullptr ? (*budget.resolution)(row, sample) : std::numeric_limits<double>::quiet_NaN();
    const double within = kWithinResolution * resolution;
    if (within > kCoarsest * measured.machine && measured.machine > 0.0) {
      ++measured.too_coarse;
      continue;
    }
    ++measured.samples;
    measured.unresolved = measured.unresolved || within > kCoarsest * measured.scale;
    const double difference = std::abs(series.values[0](row, sample) - series.values[1](row, sample));
    const bool is_explained = difference <= within;
    if (resolution > 0.0) {
      measured.resolution = std::fmax(measured.resolution, resolution);
      measured.ratio = std::max(measured.ratio, difference / resolution);
    }
    const bool is_worse = !is_explained && difference > measured.unexplained;
    if (is_worse || !worst || (measured.unexplained == 0.0 && difference > measured.difference)) worst = sample;
    if (!is_explained) measured.unexplained = std::max(measured.unexplained, difference);
    measured.difference = std::max(measured.difference, difference);
  }
  if (!worst) return;
  measured.worst = static_cast<std::size_t>(*worst);
  measured.t = series.times[measured.worst];
  measured.values = {series.values[0](row, *worst), series.values[1](row, *worst)};
}

}  // namespace

std::vector<Measured> measure(const QuantityLayout& layout, const Series& series, const Budget& budget) {
  const Scales scales(layout, series);
  std::vector<Measured> all(layout.quantities().size());
  for (std::size_t row = 0; row < all.size(); ++row) {
    Measured& measured = all[row];
    scales.assign(layout.quantities()[row], measured);
    measure_row(series, budget, static_cast<Eigen::Index>(row), measured);
    measured.digits = matching_digits(measured.difference, measured.scale);
    measured.unexplained_digits = matching_digits(measured.unexplained, measured.scale);
  }
  return all;
}

}  // namespace concord::compare
