#include "cartesian/dynamics/block_ldlt.h"

#include <amd.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace concord::cartesian {

namespace {

std::vector<std::set<int>> neighbours(int n, const std::vector<BlockLdlt::Pair>& pairs) {
  std::vector<std::set<int>> of(n);
  for (const auto& [one, other] : pairs) {
    of[one].insert(other);
    of[other].insert(one);
  }
  return of;
}

}  // namespace

bool factor_block(Mat6& A, Vec6& inverse_D, const Vec6& least, int size) {
  bool is_positive = true;
  for (int c = 0; c < size; ++c) {
    is_positive = is_positive && A(c, c) > least(c);
    const Vec6 column = A.col(c);
    inverse_D(c) = 1.0 / column(c);
    A.col(c) = inverse_D(c) * column;
    for (int later = c + 1; later < size; ++later) A.col(later) -= column(later) * A.col(c);
  }
  return is_positive;
}

void solve_lower(const Mat6& L, Vec6& x) {
  for (int c = 0; c < 5; ++c) {
    for (int later = c + 1; later < 6; ++later) x(later) -= L(later, c) * x(c);
  }
}

void solve_upper(const Mat6& L, Vec6& x) {
  for (int c = 4; c >= 0; --c) {
    for (int later = c + 1; later < 6; ++later) x(c) -= L(later, c) * x(later);
  }
}

BlockLdlt::BlockLdlt(std::vector<int> sizes, const std::vector<Pair>& pairs)
    : sizes_(std::move(sizes)),
      below_(sizes_.size()),
      updates_(sizes_.size()),
      inverse_D_(sizes_.size(), Vec6::Zero()),
      least_(inverse_D_) {
  const int n = size();
  std::vector<std::set<int>> rows = neighbours(n, pairs);
  int place = n;
  for (int column = 0; column < n; ++column) {
    std::set<int>& own = rows[column];
    own.erase(own.begin(), own.upper_bound(column));
    for (const int row : own) below_[column].push_back({row, place++});
    if (own.empty()) continue;
    std::set<int>& next = rows[*own.begin()];  // where what this column fills begins
    next.insert(own.begin(), own.end());
  }
  blocks_.resize(place);
  set_zero();
  for (int column = 0; column < n; ++column) {
    const std::vector<Below>& own = below_[column];
    for (std::size_t right = 0; right < own.size(); ++right) {
      for (std::size_t left = right; left < own.size(); ++left) {
        updates_[column].push_back(
            {find(own[left].row, own[right].row), own[left].place, own[right].place, sizes_[own[right].row]});
      }
    }
  }
}

int BlockLdlt::find(int row, int column) const {
  if (row == column) return row;
  const std::vector<Below>& own = below_[column];
  const auto found =
      std::lower_bound(own.begin(), own.end(), row, [](const Below& below, int wanted) { return below.row < wanted; });
  if (found == own.end() || found->row != row) throw std::logic_error("BlockLdlt::find: block outside the pattern");
  return found->place;
}

void BlockLdlt::set_zero() {
  for (int k = 0; k < size(); ++k) {
    blocks_[k].setZero();
    for (const Below& below : below_[k]) blocks_[below.place].setZero();
  }
}

bool BlockLdlt::factor(double least) {
  for (int k = 0; k < size(); ++k) least_[k] = least * blocks_[k].diagonal();
  for (int k = 0; k < size(); ++k) {
    if (!factor_block(blocks_[k], inverse_D_[k], least_[k], sizes_[k])) return false;
    for (const Below& below : below_[k]) divide_rows(blocks_[k], blocks_[below.place], sizes_[k]);
    for (const Update& update : updates_[k]) {
      add_product<-1>(blocks_[update.left], inverse_D_[k], blocks_[update.right], blocks_[update.target],
                      update.columns, sizes_[k]);
    }
  }
  return true;
}

void BlockLdlt::solve(Mat6X& x) const {
  for (int k = 0; k < size(); ++k) {
    Vec6 own = x.col(k);
    solve_lower(blocks_[k], own);
    x.col(k) = own;
    own.array() *= inverse_D_[k].array();
    for (const Below& below : below_[k]) x.col(below.row).noalias() -= blocks_[below.place] * own;
  }
  for (int k = size() - 1; k >= 0; --k) {
    Vec6 own = x.col(k);
    for (const Below& below : below_[k]) own.noalias() -= blocks_[below.place].transpose() * x.col(below.row);
    own.array() *= inverse_D_[k].array();
    solve_upper(blocks_[k], own);
    x.col(k) = own;
  }
}

std::vector<int> elimination_order(int n, const std::vector<BlockLdlt::Pair>& pairs) {
  std::vector<int> starts{0};
  std::vector<int> indices;
  for (const std::set<int>& own : neighbours(n, pairs)) {
    indices.insert(indices.end(), own.begin(), own.end());
    starts.push_back(static_cast<int>(indices.size()));
  }
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  if (n > 0) (void)amd_order(n, starts.data(), indices.data(), order.data(), nullptr, nullptr);
  return order;
}

}  // namespace concord::cartesian
