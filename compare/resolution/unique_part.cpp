#include "compare/resolution/unique_part.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "compare/audit/places.h"
#include "compare/quantities/observe.h"
#include "compare/resolution/uniqueness.h"

namespace concord::compare {

namespace {

constexpr double kOpen = std::numeric_limits<double>::quiet_NaN();

/// Leaves out the components of a force, or of a torque, that are open, and what has a part of them in global axes.
/// `A`: from the joint's frame to global axes.
void leave_out(const std::array<bool, 3>& open, const Mat3& A, Vec3& in_C, Vec3& in_global) {
  for (int c = 0; c < 3; ++c) {
    if (!open[static_cast<std::size_t>(c)]) continue;
    in_C(c) = kOpen;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(A(axis, c)) > kNoPart) in_global(axis) = kOpen;
    }
  }
}

/// The six components of a wrench on one side of a joint, by their places in the layout; which can be open.
struct WrenchRows {
  Kind kind = Kind::reaction;
  std::size_t joint = 0;
  Side side = Side::child;
  int first = 0;
  std::array<bool, 6> can_carry{};
};

/// The force on a joint speed, or of a coupling, by its place in the layout.
struct ForceRow {
  Quantity quantity;
  int row = 0;
};

/// A coordinate force that one actor exerts alone is that actor's share, too.
void leave_out(const Model& model, const Quantity& quantity, Evaluation& evaluation) {
  const auto owner = static_cast<std::size_t>(quantity.owner);
  if (quantity.kind == Kind::coupling) {
    evaluation.couplings[owner] = kOpen;
    return;
  }
  JointWrenches& joint = evaluation.joints[owner];
  if (quantity.kind == Kind::share) {
    joint.shares[index(quantity.actor)](quantity.component) = kOpen;
    return;
  }
  joint.tau(quantity.component) = kOpen;
  if (is_shared(model, quantity.owner, quantity.component)) return;
  for (const Actor actor : actors_on(model.joints[owner], quantity.component)) {
    joint.shares[index(actor)](quantity.component) = kOpen;
  }
}

class UniquePart {
 public:
  UniquePart(const Model& model, const Mask& unique) : model_(model), unique_(unique) {
    const QuantityLayout layout(model);
    const std::vector<Quantity>& all = layout.quantities();
    for (int row = 0; row < static_cast<int>(all.size()); ++row) {
      const Quantity& quantity = all[static_cast<std::size_t>(row)];
      const bool is_wrench = quantity.kind == Kind::reaction || quantity.kind == Kind::total;
      if (is_scalar_force(quantity.kind)) forces_.push_back({quantity, row});
      if (!is_wrench || quantity.component > 0) continue;
      WrenchRows rows{quantity.kind, static_cast<std::size_t>(quantity.owner), quantity.side, row};
      for (int c = 0; c < 6; ++c) {
        rows.can_carry[static_cast<std::size_t>(c)] = can_carry(model, all[static_cast<std::size_t>(row + c)]);
      }
      wrenches_.push_back(rows);
    }
  }

  /// Whether anything was left out.
  bool leave_out_of(Sample& sample, Eigen::Index column) const {
    bool has_open = false;
    for (const WrenchRows& rows : wrenches_) has_open = leave_out_of(sample, column, rows) || has_open;
    for (const auto& [quantity, row] : forces_) {
      if (unique_(row, column)) continue;
      has_open = true;
      leave_out(model_, quantity, sample.evaluation);
    }
    return has_open;
  }

 private:
  bool leave_out_of(Sample& sample, Eigen::Index column, const WrenchRows& rows) const {
    std::array<std::array<bool, 3>, 2> open{};  // of the force, of the torque
    bool has_open = false;
    for (std::size_t c = 0; c < 6; ++c) {
      open[c / 3][c % 3] = rows.can_carry[c] && !unique_(rows.first + static_cast<int>(c), column);
      has_open = has_open || open[c / 3][c % 3];
    }
    if (!has_open) return false;
    const Attachment& attachment = model_.joints[rows.joint].on(rows.side);
    const Mat3 A = place(attachment, sample.state.bodies[static_cast<std::size_t>(attachment.body)]).A_joint;
    JointWrenches& joint = sample.evaluation.joints[rows.joint];
    const auto side = static_cast<std::size_t>(index(rows.side));
    SideWrench& wrench = rows.kind == Kind::total ? joint.total[side] : joint.reaction[side];
    leave_out(open[0], A, wrench.in_C.force, wrench.in_global.force);
    leave_out(open[1], A, wrench.in_C.torque, wrench.in_global.torque);
    return true;
  }

  const Model& model_;
  const Mask& unique_;
  std::vector<WrenchRows> wrenches_;
  std::vector<ForceRow> forces_;
};

}  // namespace

std::optional<Trajectory> unique_part(const Model& model, const Trajectory& run, const Mask& unique) {
  const UniquePart part(model, unique);
  Trajectory known = run;
  bool has_open = false;
  for (std::size_t k = 0; k < known.samples.size(); ++k) {
    has_open = part.leave_out_of(known.samples[k], static_cast<Eigen::Index>(k)) || has_open;
  }
  if (!has_open) return std::nullopt;
  return known;
}

}  // namespace concord::compare
