#pragma once

#include <vector>

#include "cartesian/equations.h"
#include "cartesian/indices.h"

namespace concord::cartesian {

/// Where things stand among IDA's unknowns x = [q; Y; lambda; mu; nu; work] (C56). mu stands on the rows that hold for
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

}  // namespace concord::cartesian
