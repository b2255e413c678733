#include "cartesian/ida_unknowns.h"

namespace concord::cartesian {

IdaUnknowns::IdaUnknowns(const Equations& equations) {
  const Layout& layout = equations.layout();
  n_rows = equations.constraints().n_rows();
  for (const RowIndex row : rows()) {
    place_of_mu.push_back(equations.constraints().holds_positions(row) ? n_mu++ : -1);
  }
  n_nu = layout.n_bodies() - 1;
  first_Y = layout.n_q();
  first_lambda = first_Y + layout.n_Y();
  first_mu = first_lambda + n_rows;
  first_nu = first_mu + n_mu;
  at_work = first_nu + n_nu;
  size = at_work + 1;
}

}  // namespace concord::cartesian
