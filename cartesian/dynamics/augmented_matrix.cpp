#include "cartesian/dynamics/augmented_matrix.h"

#include <algorithm>
#include <cmath>

namespace concord::cartesian {

namespace {

/// Compressed columns, rows ascending.
struct Pattern {
  std::vector<int> starts{0};
  std::vector<int> rows;
};

Pattern lay_out(const Equations& equations) {
  const Layout& layout = equations.layout();
  const Constraints& constraints = equations.constraints();
  const auto index_of = [&](RowIndex row) { return layout.n_Y() + row.value; };
  std::vector<std::vector<int>> columns(layout.n_Y() + constraints.n_rows());
  for (const BodyIndex i : layout.moving_bodies()) {
    for (int column = 0; column < layout.size_Y(i); ++column) {
      for (int row = 0; row < layout.size_Y(i); ++row) {
        columns[layout.first_Y(i) + column].push_back(layout.first_Y(i) + row);
      }
    }
  }
  for (const RowBlock& block : constraints.blocks()) {
    for (const RowIndex row : RowRange(block.first_row, block.n_rows)) {
      for (int c = 0; c < layout.size_Y(block.body); ++c) {
        columns[layout.first_Y(block.body) + c].push_back(index_of(row));
        columns[index_of(row)].push_back(layout.first_Y(block.body) + c);
      }
    }
  }
  for (const RowIndex row : constraints.rows()) columns[index_of(row)].push_back(index_of(row));
  Pattern pattern;
  for (auto& column : columns) {
    std::sort(column.begin(), column.end());
    pattern.rows.insert(pattern.rows.end(), column.begin(), column.end());
    pattern.starts.push_back(static_cast<int>(pattern.rows.size()));
  }
  return pattern;
}

SparseLu make_lu(const Pattern& pattern) { return {pattern.starts, pattern.rows, SparseLu::Pattern::symmetric}; }

/// Inertias below this part of the machine's largest are scaled as if they were it. What round-off keeps from zero, as
/// of a thin rod about its axis, is no scale; and scaled by its own inertia, a light body between heavy ones would
/// weigh what these do to each other through its joints by the ratio of inertias, which may be less than round-off.
constexpr double kLeastInertia = 1e-6;

/// Unit of inertia that the matrix is scaled with, a power of two near the mass of all bodies [kg].
double mass_unit(double mass) { return mass > 0.0 ? std::ldexp(1.0, std::ilogb(mass)) : 1.0; }

}  // namespace

AugmentedMatrix::AugmentedMatrix(const Equations& equations)
    : n_Y_(equations.layout().n_Y()),
      n_rows_(equations.constraints().n_rows()),
      lu_(make_lu(lay_out(equations))),
      mass_matrices_(make_mass_matrices(equations.layout())),
      mass_entries_(equations.model().bodies.size()) {
  const double mass = mass_unit(equations.scales().mass);
  lu_.set_diagonal_unit(mass);
  for (const BodyIndex i : equations.layout().moving_bodies()) {
    equations.layout().v(lu_.least_diagonal(), i).setConstant(kLeastInertia * mass);
  }
  find_entries(equations);
}

void AugmentedMatrix::find_entries(const Equations& equations) {
  const Layout& layout = equations.layout();
  for (const BodyIndex i : layout.moving_bodies()) {
    for (int column = 0; column < layout.size_Y(i); ++column) {
      mass_entries_[i].push_back(lu_.find(layout.first_Y(i), layout.first_Y(i) + column));
    }
  }
  const std::vector<RowBlock>& blocks = equations.constraints().blocks();
  Phi_Y_entries_.assign(blocks.size(), {});
  transposed_entries_.assign(blocks.size(), {});
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const RowBlock& block = blocks[b];
    const int first_Y = layout.first_Y(block.body);
    for (const RowIndex row : RowRange(block.first_row, block.n_rows)) {
      transposed_entries_[b].push_back(lu_.find(first_Y, index_of(row)));
    }
    for (int c = 0; c < layout.size_Y(block.body); ++c) {
      Phi_Y_entries_[b].push_back(lu_.find(index_of(block.first_row), first_Y + c));
    }
  }
}

void AugmentedMatrix::use_rows(const std::vector<bool>& active) {
  std::vector<bool> idle(n_Y_ + n_rows_, false);
  for (const RowIndex row : RowRange(RowIndex(0), n_rows_)) idle[index_of(row)] = !active[row.value];
  lu_.set_idle(idle);
}

void AugmentedMatrix::fill(const Equations& equations) {
  const Layout& layout = equations.layout();
  equations.write_mass_matrices(mass_matrices_);
  double* values = lu_.values();
  double largest = 0.0;  // of a body's three moments of inertia together
  for (const BodyIndex i : layout.moving_bodies()) {
    const auto size = mass_entries_[i].size();
    for (std::size_t column = 0; column < size; ++column) {
      std::copy_n(mass_matrices_[i].col(static_cast<Eigen::Index>(column)).data(), size,
                  values + mass_entries_[i][column]);
    }
    largest = std::max(largest, mass_matrices_[i].diagonal().segment<3>(3).sum());
  }
  for (const BodyIndex i : layout.moving_bodies()) {
    layout.omega(lu_.least_diagonal(), i).setConstant(kLeastInertia * largest);
  }
  const MovingConstraints& constraints = equations.moving_constraints();
  for (std::size_t b = 0; b < constraints.blocks().size(); ++b) {
    const auto& entries = Phi_Y_entries_[b];
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints.columns(constraints.blocks()[b]);
    const int size = static_cast<int>(entries.size());
    for (Eigen::Index row = 0; row < Phi_Y_transposed.cols(); ++row) {
      std::copy_n(Phi_Y_transposed.col(row).data(), size, values + transposed_entries_[b][row]);
      for (int c = 0; c < size; ++c) values[entries[c] + row] = Phi_Y_transposed(c, row);
    }
  }
}

void AugmentedMatrix::add_to_modes(BodyIndex body, const MatX& K) {
  for (int k = 0; k < K.cols(); ++k) {
    double* column = lu_.values() + mass_entries_[body][6 + k] + 6;
    for (int l = 0; l < K.rows(); ++l) column[l] += K(l, k);
  }
}

}  // namespace concord::cartesian
