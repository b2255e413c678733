#pragma once

#include "cartesian/bodies/indices.h"
#include "common/model.h"
#include "common/results.h"

namespace concord::cartesian {

/// Where each body's numbers stand: q_i = [r; p; a] (7 + m) and Y_i = [v; omega; adot] (6 + m), moving bodies in the
/// order of the model. Ground has none.
class Layout {
 public:
  explicit Layout(const Model& model);

  [[nodiscard]] int n_bodies() const { return n_modes_.size(); }  // ground included
  /// All bodies but ground.
  [[nodiscard]] IndexRange<BodyIndex> moving_bodies() const { return {BodyIndex(kGround + 1), n_bodies() - 1}; }
  [[nodiscard]] int n_q() const { return n_q_; }
  [[nodiscard]] int n_Y() const { return n_Y_; }
  [[nodiscard]] int first_q(BodyIndex body) const { return first_q_[body]; }
  [[nodiscard]] int first_Y(BodyIndex body) const { return first_Y_[body]; }
  [[nodiscard]] int n_modes(BodyIndex body) const { return n_modes_[body]; }
  [[nodiscard]] int size_Y(BodyIndex body) const { return 6 + n_modes_[body]; }

  template <class Q>
  [[nodiscard]] auto r(Q&& q, BodyIndex body) const {
    return q.template segment<3>(first_q_[body]);
  }
  template <class Q>
  [[nodiscard]] auto p(Q&& q, BodyIndex body) const {
    return q.template segment<4>(first_q_[body] + 3);
  }
  template <class Q>
  [[nodiscard]] auto a(Q&& q, BodyIndex body) const {
    return q.segment(first_q_[body] + 7, n_modes_[body]);
  }
  template <class V>
  [[nodiscard]] auto v(V&& Y, BodyIndex body) const {
    return Y.template segment<3>(first_Y_[body]);
  }
  template <class V>
  [[nodiscard]] auto omega(V&& Y, BodyIndex body) const {
    return Y.template segment<3>(first_Y_[body] + 3);
  }
  template <class V>
  [[nodiscard]] auto adot(V&& Y, BodyIndex body) const {
    return Y.segment(first_Y_[body] + 6, n_modes_[body]);
  }

  /// Numbers of a state, and back (without joint coordinates).
  void unpack(const State& state, VecX& q, VecX& Y) const;
  [[nodiscard]] State pack(double t, const VecX& q, const VecX& Y) const;

  /// qdot of Y: rdot = v, pdot = E^T omega / 2, the modes' own rates.
  void write_qdot(const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y, Eigen::Ref<VecX> qdot) const;

  /// Moves q by a small displacement [dr; dpi; da] of every body, dpi a rotation vector in global axes; p stays unit.
  void displace(const Eigen::Ref<const VecX>& step, Eigen::Ref<VecX> q) const;  // (C4)
  /// The same for one body, by `size` along its coordinate c of Y.
  void displace_along(BodyIndex body, int c, double size, Eigen::Ref<VecX> q) const;

  /// Copies the numbers of one body.
  void copy_body(BodyIndex body, const Eigen::Ref<const VecX>& from, Eigen::Ref<VecX> to) const;

  /// Brings every p back to unit length.
  void normalize(Eigen::Ref<VecX> q) const;

 private:
  ByBody<int> first_q_;
  ByBody<int> first_Y_;
  ByBody<int> n_modes_;
  int n_q_ = 0;
  int n_Y_ = 0;
};

}  // namespace concord::cartesian
