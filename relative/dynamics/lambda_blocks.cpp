#include "relative/dynamics/lambda_blocks.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace concord::relative {

std::vector<std::set<int>> neighbours_of(const std::vector<std::vector<int>>& meeting, std::size_t n) {
  std::vector<std::set<int>> neighbours(n);
  for (const std::vector<int>& groups : meeting) {
    for (const int group : groups) neighbours[group].insert(groups.begin(), groups.end());
  }
  for (std::size_t group = 0; group < n; ++group) neighbours[group].erase(static_cast<int>(group));
  return neighbours;
}

EliminationOrder::EliminationOrder(std::vector<RowGroup> groups, std::vector<std::set<int>> neighbours)
    : groups_(std::move(groups)), place_of_(groups_.size(), -1) {
  choose(neighbours);
  list_updates();
}

/// Takes out one group after the other; those that it was coupled to are its column of the factor.
void EliminationOrder::choose(std::vector<std::set<int>>& neighbours) {
  const auto n = static_cast<int>(groups_.size());
  std::set<std::pair<std::size_t, int>> left;
  for (int group = 0; group < n; ++group) left.insert({neighbours[group].size(), group});
  std::vector<std::vector<int>> below;  // of each place, groups
  while (!left.empty()) {
    const int group = left.begin()->second;
    left.erase(left.begin());
    place_of_[group] = static_cast<int>(group_at_.size());
    group_at_.push_back(group);
    const std::set<int>& column = neighbours[group];
    for (const int one : column) {
      left.erase({neighbours[one].size(), one});
      neighbours[one].insert(column.begin(), column.end());
      neighbours[one].erase(one);
      neighbours[one].erase(group);
      left.insert({neighbours[one].size(), one});
    }
    below.emplace_back(column.begin(), column.end());
  }
  for (int place = 0; place < n; ++place) {
    first_of_column_.push_back(static_cast<int>(blocks_.size()));
    blocks_.push_back({place, place});
    std::vector<int> rows;
    for (const int group : below[place]) rows.push_back(place_of_[group]);
    std::sort(rows.begin(), rows.end());
    for (const int row : rows) blocks_.push_back({row, place});
  }
  first_of_column_.push_back(static_cast<int>(blocks_.size()));
}

int EliminationOrder::block_of(int group, int other) const {
  const int row = std::max(place_of_[group], place_of_[other]);
  const int column = std::min(place_of_[group], place_of_[other]);
  const auto end = blocks_.begin() + end_of_column(column);
  const auto found = std::lower_bound(blocks_.begin() + diagonal(column), end, row,
                                      [](const Block& block, int wanted) { return block.row < wanted; });
  return found != end && found->row == row ? static_cast<int>(found - blocks_.begin()) : -1;
}

/// Two blocks of a column act on the block of their rows, which stands in a later column.
void EliminationOrder::list_updates() {
  const auto n = static_cast<int>(groups_.size());
  std::vector<std::vector<Update>> of_column(n);
  for (int place = 0; place < n; ++place) {
    for (int right = diagonal(place) + 1; right < end_of_column(place); ++right) {
      for (int left = right; left < end_of_column(place); ++left) {
        const int column = blocks_[right].row;
        const int target = block_of(group_at_[blocks_[left].row], group_at_[column]);
        of_column[column].push_back({target, left, right});
      }
    }
  }
  for (const std::vector<Update>& updates : of_column) {
    first_update_.push_back(static_cast<int>(updates_.size()));
    updates_.insert(updates_.end(), updates.begin(), updates.end());
  }
  first_update_.push_back(static_cast<int>(updates_.size()));
}

LambdaBlocks::LambdaBlocks(EliminationOrder order) : order_(std::move(order)) {
  int size = 0;
  for (int block = 0; block < static_cast<int>(order_.blocks().size()); ++block) {
    first_of_block_.push_back(size);
    size += n_rows(block) * n_columns(block);
  }
  values_.assign(size, 0.0);
  for (const RowGroup& group : order_.groups()) n_rows_ += group.n_rows;
}

int LambdaBlocks::n_rows(int block) const {
  return order_.groups()[order_.group_at(order_.blocks()[block].row)].n_rows;
}

int LambdaBlocks::n_columns(int block) const {
  return order_.groups()[order_.group_at(order_.blocks()[block].column)].n_rows;
}

void LambdaBlocks::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

void LambdaBlocks::write_diagonal(VecX& diagonal) const {
  for (std::size_t place = 0; place < order_.groups().size(); ++place) {
    const RowGroup& group = order_.groups()[order_.group_at(static_cast<int>(place))];
    const double* block = values(order_.diagonal(static_cast<int>(place)));
    for (int r = 0; r < group.n_rows; ++r) diagonal(group.first_row + r) = block[r * (group.n_rows + 1)];
  }
}

void LambdaBlocks::write_dense(MatX& Lambda) const {
  Lambda.setZero();
  for (std::size_t block = 0; block < order_.blocks().size(); ++block) {
    const auto [row, column] = order_.blocks()[block];
    const RowGroup& of_rows = order_.groups()[order_.group_at(row)];
    const RowGroup& of_columns = order_.groups()[order_.group_at(column)];
    const double* entry = values(static_cast<int>(block));
    for (int r = 0; r < of_rows.n_rows; ++r) {
      for (int c = 0; c < of_columns.n_rows; ++c) {
        Lambda(of_rows.first_row + r, of_columns.first_row + c) = *entry;
        Lambda(of_columns.first_row + c, of_rows.first_row + r) = *entry++;
      }
    }
  }
}

BlockCholesky::BlockCholesky(const LambdaBlocks& Lambda)
    : Lambda_(&Lambda),
      order_(&Lambda.order()),
      first_scalar_(order_->groups().size() + 1, 0),
      local_row_(Lambda.n_rows(), 0),
      place_among_rows_(Lambda.n_rows(), 0),
      first_of_block_(order_->blocks().size(), 0),
      eliminated_(VecX::Zero(Lambda.n_rows())) {
  rows_.reserve(Lambda.n_rows());
  std::size_t size = 0;
  for (int block = 0; block < static_cast<int>(order_->blocks().size()); ++block) {
    size += static_cast<std::size_t>(Lambda.n_rows(block)) * Lambda.n_columns(block);
  }
  values_.assign(size, 0.0);
}

/// Where the given rows stand. Done anew only when they change.
void BlockCholesky::lay_out(const std::vector<RowIndex>& rows) {
  rows_ = rows;
  int n = 0;
  for (int place = 0; place < static_cast<int>(order_->groups().size()); ++place) {
    first_scalar_[place] = n;
    const RowGroup& group = order_->groups()[order_->group_at(place)];
    const auto first = std::lower_bound(rows.begin(), rows.end(), RowIndex(group.first_row));
    for (auto row = first; row != rows.end() && *row < group.first_row + group.n_rows; ++row, ++n) {
      local_row_[n] = *row - group.first_row;
      place_among_rows_[n] = static_cast<int>(row - rows.begin());
    }
  }
  first_scalar_.back() = n;
  int size = 0;
  for (std::size_t block = 0; block < first_of_block_.size(); ++block) {
    first_of_block_[block] = size;
    size += size_at(order_->blocks()[block].row) * size_at(order_->blocks()[block].column);
  }
}

void BlockCholesky::load(const IndependentRows& rows) {
  const auto scale = [&](int scalar) { return rows.scale[rows.rows[place_among_rows_[scalar]]]; };
  for (std::size_t block = 0; block < first_of_block_.size(); ++block) {
    const auto [row, column] = order_->blocks()[block];
    const double* of_Lambda = Lambda_->values(static_cast<int>(block));
    const int stride = Lambda_->n_columns(static_cast<int>(block));
    double* entry = values(static_cast<int>(block));
    for (int r = first_scalar_[row]; r < first_scalar_[row + 1]; ++r) {
      for (int c = first_scalar_[column]; c < first_scalar_[column + 1]; ++c) {
        *entry++ = scale(r) * of_Lambda[local_row_[r] * stride + local_row_[c]] * scale(c);
      }
    }
  }
}

double BlockCholesky::factor(const IndependentRows& rows) {  // (R79)
  if (rows_ != rows.rows) lay_out(rows.rows);
  load(rows);
  least_pivot_ = 1.0;
  for (int place = 0; place < static_cast<int>(order_->groups().size()); ++place) {
    for (int u = order_->first_update(place); u < order_->first_update(place + 1); ++u) update(order_->updates()[u]);
    if (!factor_diagonal(place)) return 0.0;
    for (int block = order_->diagonal(place) + 1; block < order_->end_of_column(place); ++block) {
      divide_by_diagonal(block);
    }
  }
  return least_pivot_;
}

void BlockCholesky::update(const EliminationOrder::Update& update) {
  const int n_rows = size_at(order_->blocks()[update.left].row);
  const int n_columns = size_at(order_->blocks()[update.right].row);
  const int depth = size_at(order_->blocks()[update.left].column);
  double* target = values(update.target);
  const double* left = values(update.left);
  for (int r = 0; r < n_rows; ++r, left += depth) {
    const double* right = values(update.right);
    for (int c = 0; c < n_columns; ++c, right += depth) {
      double sum = 0.0;
      for (int k = 0; k < depth; ++k) sum += left[k] * right[k];
      *target++ -= sum;
    }
  }
}

/// The lower triangle of a diagonal block; ones over the pivots on its diagonal.
bool BlockCholesky::factor_diagonal(int place) {
  const int n = size_at(place);
  double* L = values(order_->diagonal(place));
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c <= r; ++c) {
      double rest = L[r * n + c];
      for (int k = 0; k < c; ++k) rest -= L[r * n + k] * L[c * n + k];
      if (c < r) {
        L[r * n + c] = rest * L[c * n + c];
        continue;
      }
      if (!(rest > 0.0)) return false;
      least_pivot_ = std::min(least_pivot_, rest);
      L[r * n + r] = 1.0 / std::sqrt(rest);
    }
  }
  return true;
}

void BlockCholesky::divide_by_diagonal(int block) {
  const auto [row, column] = order_->blocks()[block];
  const int n = size_at(column);
  const double* L = values(order_->diagonal(column));
  double* entries = values(block);
  for (int r = 0; r < size_at(row); ++r, entries += n) {
    for (int c = 0; c < n; ++c) {
      double rest = entries[c];
      for (int k = 0; k < c; ++k) rest -= entries[k] * L[c * n + k];
      entries[c] = rest * L[c * n + c];
    }
  }
}

void BlockCholesky::solve(VecX& right) const {
  const auto n_places = static_cast<int>(order_->groups().size());
  for (int scalar = 0; scalar < first_scalar_.back(); ++scalar) eliminated_(scalar) = right(place_among_rows_[scalar]);
  for (int place = 0; place < n_places; ++place) {
    const int n = size_at(place);
    double* x = eliminated_.data() + first_scalar_[place];
    const double* L = values(order_->diagonal(place));
    for (int r = 0; r < n; ++r) {
      for (int k = 0; k < r; ++k) x[r] -= L[r * n + k] * x[k];
      x[r] *= L[r * n + r];
    }
    for (int block = order_->diagonal(place) + 1; block < order_->end_of_column(place); ++block) {
      const int row = order_->blocks()[block].row;
      const double* entry = values(block);
      for (int r = first_scalar_[row]; r < first_scalar_[row + 1]; ++r) {
        for (int k = 0; k < n; ++k) eliminated_(r) -= *entry++ * x[k];
      }
    }
  }
  for (int place = n_places - 1; place >= 0; --place) {
    const int n = size_at(place);
    double* x = eliminated_.data() + first_scalar_[place];
    for (int block = order_->diagonal(place) + 1; block < order_->end_of_column(place); ++block) {
      const int row = order_->blocks()[block].row;
      const double* entry = values(block);
      for (int r = first_scalar_[row]; r < first_scalar_[row + 1]; ++r) {
        for (int k = 0; k < n; ++k) x[k] -= *entry++ * eliminated_(r);
      }
    }
    const double* L = values(order_->diagonal(place));
    for (int r = n - 1; r >= 0; --r) {
      x[r] *= L[r * n + r];
      for (int k = 0; k < r; ++k) x[k] -= L[r * n + k] * x[r];
    }
  }
  for (int scalar = 0; scalar < first_scalar_.back(); ++scalar) right(place_among_rows_[scalar]) = eliminated_(scalar);
}

}  // namespace concord::relative
