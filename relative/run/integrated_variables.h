#pragma once

#include <vector>

#include "relative/bodies/motion.h"
#include "relative/dynamics/equations.h"

/// The numbers that an integrator of a machine integrates, and the sizes that their errors are measured by.
namespace concord::relative {

/// The integrated numbers y = [coordinates and speeds that are not driven; work]. Speeds of cut joints follow from the
/// tree and are not integrated; their coordinates are, so that turns are counted and measuring starts close by.
class IntegratedVariables {
 public:
  explicit IntegratedVariables(const Equations& equations);

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(q_.size() + u_.size()) + 1; }
  [[nodiscard]] Eigen::Index n_q() const { return static_cast<Eigen::Index>(q_.size()); }
  [[nodiscard]] Eigen::Index work() const { return size() - 1; }

  /// Places of modal coordinates and of their rates, in one order.
  [[nodiscard]] const std::vector<int>& modal_coordinates() const { return modal_coordinates_; }
  [[nodiscard]] const std::vector<int>& modal_rates() const { return modal_rates_; }

  void unpack(const Eigen::Ref<const VecX>& y, Coordinates& coordinates) const;
  /// Writes all of y but the work.
  void pack(const VecX& q, const VecX& u, Eigen::Ref<VecX> y) const;
  /// Takes whole turns off the coordinates.
  void take_off(const VecX& turns, Eigen::Ref<VecX> y) const;

 private:
  std::vector<int> q_;
  std::vector<int> u_;
  std::vector<int> modal_coordinates_;
  std::vector<int> modal_rates_;
};

/// Sizes that accuracy is measured by, one for each integrated number: the machine's length, its rate, its energy.
VecX sizes_of(const IntegratedVariables& variables, const Equations& equations, const Coordinates& start);

}  // namespace concord::relative
