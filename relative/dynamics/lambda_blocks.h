#pragma once

#include <set>
#include <vector>

#include "common/types.h"
#include "relative/dynamics/independent_rows.h"

/// Lambda = Phi_u Mbar^-1 Phi_u^T by blocks, of which only those are stored that the loops of a machine fill, and its
/// factor (R79).
namespace concord::relative {

/// Consecutive closure rows that act along the same links: those of one cut joint or of one speed constraint.
struct RowGroup {
  int first_row = 0;
  int n_rows = 0;
};

/// Of each of n groups the others that it couples with, from the groups that meet at each of many places.
[[nodiscard]] std::vector<std::set<int>> neighbours_of(const std::vector<std::vector<int>>& meeting, std::size_t n);

/// The order in which groups of rows are eliminated, and the blocks of the factor that this fills. It depends on which
/// groups share a link, and on no pose: of the groups that are left, the one that is coupled to the fewest comes first,
/// and couples these to each other.
class EliminationOrder {
 public:
  /// `neighbours`: of each group, the others that it couples with.
  EliminationOrder(std::vector<RowGroup> groups, std::vector<std::set<int>> neighbours);

  /// A block of the lower triangle, by places in the order: row >= column.
  struct Block {
    int row = 0;
    int column = 0;
  };
  /// One step of block elimination: L_target -= L_left L_right^T; indices of blocks.
  struct Update {
    int target = 0;
    int left = 0;
    int right = 0;
  };

  [[nodiscard]] const std::vector<RowGroup>& groups() const { return groups_; }
  /// The group at a place of the order, and back.
  [[nodiscard]] int group_at(int place) const { return group_at_[place]; }
  [[nodiscard]] int place_of(int group) const { return place_of_[group]; }
  /// Column by column, in each the diagonal block first.
  [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }
  [[nodiscard]] int diagonal(int place) const { return first_of_column_[place]; }
  [[nodiscard]] int end_of_column(int place) const { return first_of_column_[place + 1]; }
  /// Those that blocks of a column need before it is divided by its diagonal block.
  [[nodiscard]] const std::vector<Update>& updates() const { return updates_; }
  [[nodiscard]] int first_update(int place) const { return first_update_[place]; }
  /// Index of the block of two groups; -1 if they do not couple.
  [[nodiscard]] int block_of(int group, int other) const;

 private:
  void choose(std::vector<std::set<int>>& neighbours);
  void list_updates();

  std::vector<RowGroup> groups_;
  std::vector<int> group_at_;
  std::vector<int> place_of_;
  std::vector<Block> blocks_;
  std::vector<int> first_of_column_;  // and the number of blocks
  std::vector<Update> updates_;
  std::vector<int> first_update_;  // of each column, and their number
};

/// The values of the blocks, each with its rows one after the other. All memory is laid out at construction.
class LambdaBlocks {
 public:
  explicit LambdaBlocks(EliminationOrder order);

  [[nodiscard]] const EliminationOrder& order() const { return order_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }
  void set_zero();
  /// Entry (0, 0) of a block; the next row follows after n_columns(block) numbers.
  [[nodiscard]] double* values(int block) { return values_.data() + first_of_block_[block]; }
  [[nodiscard]] const double* values(int block) const { return values_.data() + first_of_block_[block]; }
  [[nodiscard]] int n_rows(int block) const;
  [[nodiscard]] int n_columns(int block) const;

  /// The diagonal of Lambda (n_rows numbers), and all of it.
  void write_diagonal(VecX& diagonal) const;
  void write_dense(MatX& Lambda) const;

 private:
  EliminationOrder order_;
  std::vector<int> first_of_block_;
  std::vector<double> values_;
  int n_rows_ = 0;
};

/// Cholesky's factor of Lambda over its independent rows, scaled to unit diagonal, block by block. All memory is laid
/// out at construction.
class BlockCholesky {
 public:
  /// What it refers to must outlive this object.
  explicit BlockCholesky(const LambdaBlocks& Lambda);

  /// Returns the least pivot: the square of the sine between a row and those eliminated before it, in the metric of
  /// the inverse inertia; zero where Lambda is not positive definite over these rows.
  [[nodiscard]] double factor(const IndependentRows& rows);
  /// Solves for a right side of the scaled rows, in place (as many numbers as rows were factored, in their order).
  void solve(VecX& right) const;

 private:
  void lay_out(const std::vector<RowIndex>& rows);
  void load(const IndependentRows& rows);
  [[nodiscard]] bool factor_diagonal(int place);
  void divide_by_diagonal(int block);
  void update(const EliminationOrder::Update& update);
  [[nodiscard]] int size_at(int place) const { return first_scalar_[place + 1] - first_scalar_[place]; }
  [[nodiscard]] double* values(int block) { return values_.data() + first_of_block_[block]; }
  [[nodiscard]] const double* values(int block) const { return values_.data() + first_of_block_[block]; }

  const LambdaBlocks* Lambda_;
  const EliminationOrder* order_;
  std::vector<RowIndex> rows_;         // that it is laid out for, ascending
  std::vector<int> first_scalar_;      // of each place, and their number
  std::vector<int> local_row_;         // of each scalar, its row within its group
  std::vector<int> place_among_rows_;  // of each scalar, its index in rows_
  std::vector<int> first_of_block_;
  std::vector<double> values_;
  double least_pivot_ = 1.0;
  mutable VecX eliminated_;  // a right side in the order of elimination
};

}  // namespace concord::relative
