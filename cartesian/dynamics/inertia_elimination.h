#pragma once

#include <map>
#include <span>
#include <vector>

#include "cartesian/dynamics/block_ldlt.h"
#include "cartesian/dynamics/equations.h"

namespace concord::cartesian {

/// Solves the equations of motion by eliminating the inertias, which couple no two bodies, and then the constraint rows
/// (C65): M = L D L^T body by body, the modes first, and J M^-1 J^T = H over the rows in use, a block for each joint
/// or coupling, in an order that is chosen when the rows change. For machines whose bodies all have inertia in every
/// direction, and whose rows are independent; others are told and left to the LU factors of the whole matrix.
class InertiaElimination {
 public:
  /// With these modal masses, by body.
  InertiaElimination(const Equations& equations, const ByBody<MatX>& modal_masses);

  /// Which constraint rows take part, by row. Factorize afterwards.
  void use_rows(const std::vector<bool>& active);

  /// Factorizes what the equations are at their last update. False where a body's inertia or the rows in use are
  /// singular, or so nearly that few digits are left.
  [[nodiscard]] bool factor(const Equations& equations);
  /// Reads what residuals are taken of at the last update of the equations, and keeps the factors.
  void read(const Equations& equations);
  /// Solves in place: [f; gamma] becomes [Ydot; lambda], zero for rows that take no part.
  void solve(VecX& x);
  /// The largest residual of an equation, in double precision, as a part of the sizes of its terms; in these no
  /// acceleration counts as less than its entry of `least`.
  [[nodiscard]] double largest_residual(const VecX& right_side, const VecX& x, const VecX& least);
  /// Improves the x that was judged last by what solves its residual.
  void correct(VecX& x);

 private:
  /// A body, whose modes are eliminated first and its velocities v and omega last.
  struct Part {
    BodyIndex body;
    int first_Y = 0;
    int n_modes = 0;
    MatX modal_mass;
    MatX L_modal;  // the same in every state
    VecX inverse_D_modal;
    bool has_regular_modes = true;
    Mat6X M;         // rows of v and omega
    Mat6X coupling;  // of L D
    Mat6 L_rigid;
    Vec6 inverse_D_rigid;
    Vec6 rigid;  // what is solved for
    VecX modal;
    VecX sizes;  // of accelerations, and of terms of the body's equations
    VecX terms;
    int first_leg = 0;
    int n_legs = 0;
    std::vector<int> places;  // in H, of each leg with those before it and with itself
  };
  /// The rows of one node on one body: J, and W = J L^-T, so that H is a sum of W D^-1 W^T.
  struct Leg {
    int node = 0;
    std::size_t block = 0;
    std::vector<int> own;  // rows among the block's
    Mat6X J;
    Mat6X W;
  };
  struct NodeOfBlock {
    int node;
    std::size_t block;
  };

  void lay_out(const std::vector<std::vector<int>>& rows, std::map<BodyIndex, std::vector<NodeOfBlock>>& on_body);
  void add_legs(Part& part, const std::vector<NodeOfBlock>& own);
  [[nodiscard]] std::span<Leg> legs_of(const Part& part) {
    return {legs_.data() + part.first_leg, static_cast<std::size_t>(part.n_legs)};
  }
  [[nodiscard]] static bool factor_inertia(const Equations& equations, Part& part);
  void read_rows(const Equations& equations, Leg& leg);
  static void divide_by_inertia(const Part& part, Leg& leg);
  void add_to_rows(const Part& part);
  void eliminate(Part& part, const VecX& x);
  void substitute(Part& part, VecX& x);
  static void subtract_modal_rows(const Part& part, const VecX& x, double* left, double* terms);
  [[nodiscard]] double residual_of(Part& part, const VecX& right_side, const VecX& x, const VecX& least);

  int n_Y_;
  const std::vector<RowBlock>& blocks_;
  std::vector<Part> parts_;
  std::vector<Leg> legs_;                // by body, nodes ascending
  std::vector<std::vector<int>> nodes_;  // in the order of elimination: rows of the machine, at most six each
  BlockLdlt H_;
  Mat6X multipliers_;  // by node
  Mat6X row_residuals_;
  Mat6X row_terms_;
  VecX residual_;
  VecX no_row_;  // zeros, as many as the largest body has columns
};

}  // namespace concord::cartesian
