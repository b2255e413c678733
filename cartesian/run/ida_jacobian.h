#pragma once

#include <array>
#include <vector>

#include "cartesian/bodies/indices.h"
#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"

namespace concord::cartesian {

/// Where things stand among IDA's unknowns x = [q; Y; lambda; mu; nu; work] (C61). mu stands on the rows that hold for
/// positions; rows that hold for velocities alone have none.
struct IdaUnknowns {
  explicit IdaUnknowns(const Equations& equations);

  /// A body's |p|^2 = 1.
  [[nodiscard]] int at_nu(BodyIndex body) const { return first_nu + body.value - 1; }
  /// Whether a row has a mu, and where.
  [[nodiscard]] bool has_mu(RowIndex row) const { return place_of_mu[row.value] >= 0; }
  [[nodiscard]] int at_mu(RowIndex row) const { return first_mu + place_of_mu[row.value]; }
  [[nodiscard]] int at_lambda(RowIndex row) const { return first_lambda + row.value; }
  [[nodiscard]] RowRange rows() const { return {RowIndex(0), n_rows}; }

  int n_rows = 0;
  int n_mu = 0;
  int n_nu = 0;
  int first_Y = 0;
  int first_lambda = 0;
  int first_mu = 0;
  int first_nu = 0;
  int at_work = 0;
  int size = 0;
  std::vector<int> place_of_mu;  // by row; -1: it holds for velocities alone
};

/// dF/dx + c dF/dxdot of the residual (C61) without the terms that a short step makes small (how M, S and the direction
/// of the constraint forces change with position): enough for Newton's method (C62). The pattern is frozen.
class IdaJacobian {
 public:
  /// `dynamics` and `places` must outlive this object. `q`, `Y`: a motion in which the machine is defined.
  IdaJacobian(const Dynamics& dynamics, const IdaUnknowns& places, const VecX& q, const VecX& Y);

  /// Compressed columns, rows ascending.
  [[nodiscard]] const std::vector<int>& column_starts() const { return starts_; }
  [[nodiscard]] const std::vector<int>& row_indices() const { return rows_; }

  /// Writes the entries, as many as row_indices(), for the unknowns x, with turns, regimes and rows as `dynamics` has
  /// them; `rate` is that of the machine [1/s]. Throws SolverError where a force element is not defined.
  void write(double t, double c, const Eigen::Ref<const VecX>& x, double rate, double* values);

 private:
  /// Derivatives of an applied force's generalized forces over [r; pi; a] and over Y of the moved side's body, by moved
  /// and pushed side.
  struct ForceSlopes {
    std::array<std::array<MatX, 2>, 2> over_q;
    std::array<std::array<MatX, 2>, 2> over_Y;
  };

  ForceSlopes make_slopes(const AppliedForce& applied) const;
  void update(double t, const VecX& q, const Eigen::Ref<const VecX>& Y);
  void lay_out(const VecX& q, const VecX& Y);
  void differentiate_rates(const VecX& q, const Eigen::Ref<const VecX>& Y);
  void differentiate_rates(const RowBlock& block, const VecX& q, const Eigen::Ref<const VecX>& Y, MatX& rates);
  void differentiate_forces(double t, double rate, const VecX& q, const Eigen::Ref<const VecX>& Y);
  void differentiate_forces(AppliedForceIndex applied, Side moved, double t, double rate, const VecX& q,
                            const Eigen::Ref<const VecX>& Y, ForceSlopes& slopes);
  template <class Visit>
  void each_entry(double c, const Eigen::Ref<const VecX>& x, const Visit& visit) const;
  template <class Q, class V, class Visit>
  void each_body_entry(BodyIndex i, double c, const Q& q, const V& Y, const Visit& visit) const;
  template <class Q, class Visit>
  void each_row_entry(const RowBlock& block, const MatX& rates, const Q& q, const Visit& visit) const;
  template <class Q, class Visit>
  void each_force_entry(const AppliedForce& applied, const ForceSlopes& slopes, const Q& q, const Visit& visit) const;

  const Dynamics& dynamics_;
  Equations own_;  // whose joints and applied forces are displaced
  const Layout& layout_;
  const IdaUnknowns& places_;
  ByBody<MatX> mass_matrices_;
  ByAppliedForce<ForceSlopes> slopes_;
  std::vector<MatX> rates_over_q_;  // by block of rows: rows x (6 + m)
  VecX unit_q_;
  VecX displaced_q_;
  VecX displaced_Y_;
  std::vector<int> slots_;  // by visited entry: its place among the entries
  std::vector<int> starts_;
  std::vector<int> rows_;
};

}  // namespace concord::cartesian
