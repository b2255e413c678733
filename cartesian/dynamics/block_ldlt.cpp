#include "cartesian/dynamics/block_ldlt.h"

#include <amd.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace concord::cartesian {

namespace {

std::vector<std::set<int>> neighbours(int n, const std::vector<BlockLdlt::Coupled>& pairs) {
  std::vector<std::set<int>> of(n);
  for (const auto& [one, other] : pairs) {
    of[one].insert(other);
    of[other].insert(one);
  }
  return of;
}

}  // namespace

BlockLdlt::BlockLdlt(std::vector<int> sizes, const std::vector<Coupled>& pairs)
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

/// In stores of their own: what g++ makes of setZero() here begins slowly.
void BlockLdlt::set_zero() {
  const auto clear = [this](int place) {
    double* numbers = blocks_[place].data();
#pragma GCC unroll 18
    for (int k = 0; k < 36; k += 2) store_pair(Pair{}, numbers + k);
  };
  for (int k = 0; k < size(); ++k) {
    clear(k);
    for (const Below& below : below_[k]) clear(below.place);
  }
}

bool BlockLdlt::factor(double least) {
  for (int k = 0; k < size(); ++k) least_[k] = least * blocks_[k].diagonal();
  for (int k = 0; k < size(); ++k) {
    if (!eliminate(k)) return false;
  }
  return true;
}

/// With as many rows as a constant, so that loops unroll.
bool BlockLdlt::eliminate(int column) {
  switch (sizes_[column]) {
    case 1:
      return eliminate<1>(column);
    case 2:
      return eliminate<2>(column);
    case 3:
      return eliminate<3>(column);
    case 4:
      return eliminate<4>(column);
    case 5:
      return eliminate<5>(column);
    default:
      return eliminate<6>(column);
  }
}

template <int N>
bool BlockLdlt::eliminate(int column) {
  if (!factor_block<N>(blocks_[column], inverse_D_[column], least_[column])) return false;
  for (const Below& below : below_[column]) divide_rows<N>(blocks_[column], blocks_[below.place]);
  for (const Update& update : updates_[column]) {
    add_product<-1, N>(blocks_[update.left], inverse_D_[column], blocks_[update.right], blocks_[update.target],
                       update.columns);
  }
  return true;
}

namespace {

/// sum -= A x.
template <class Sum>
void subtract_product(const Mat6& A, const Vec6& x, Sum&& sum) {
  Vec6 rest = sum;
#pragma GCC unroll 6
  for (int c = 0; c < 6; ++c) rest -= x(c) * A.col(c);
  sum = rest;
}

}  // namespace

void BlockLdlt::solve(Mat6X& x) const {
  for (int k = 0; k < size(); ++k) {
    Vec6 own = x.col(k);
    solve_lower(blocks_[k], own);
    x.col(k) = own;
    own.array() *= inverse_D_[k].array();
    for (const Below& below : below_[k]) subtract_product(blocks_[below.place], own, x.col(below.row));
  }
  for (int k = size() - 1; k >= 0; --k) {
    Vec6 own = x.col(k);
    for (const Below& below : below_[k]) own -= transpose_times(blocks_[below.place], Vec6(x.col(below.row)));
    own.array() *= inverse_D_[k].array();
    solve_upper(blocks_[k], own);
    x.col(k) = own;
  }
}

std::vector<int> elimination_order(int n, const std::vector<BlockLdlt::Coupled>& pairs) {
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
