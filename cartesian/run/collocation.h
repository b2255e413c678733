#pragma once

#include <array>

#include "cartesian/run/gauss_rule.h"
#include "cartesian/run/vibrations.h"

/// Collocation of y = [q; Y; work] at Gauss's points, with the vibrations of modes integrated exactly.
namespace concord::cartesian {

/// What is known at the points of one step, a column each.
struct PointRates {
  PointRates(Eigen::Index size, Eigen::Index n_modes)
      : ydot(MatX::Zero(size, kPoints)),
        a(MatX::Zero(n_modes, kPoints)),
        adot(MatX::Zero(n_modes, kPoints)),
        g(MatX::Zero(n_modes, kPoints)) {}

  MatX ydot;
  MatX a;     // modal coordinates of all bodies
  MatX adot;  // their rates
  MatX g;     // what drives their vibrations
};

/// One step of the method from y0: the solution at any time in it that follows from rates at its points, y0 plus the
/// integral of the polynomial through them (C55); for modes the response of vibrations to the polynomial through g
/// (C58).
class Collocation {
 public:
  /// `vibrations` must outlive this object; when they are renewed, begin() must be called.
  Collocation(const Equations& equations, const Vibrations& vibrations);

  [[nodiscard]] Eigen::Index size() const { return y0_.size(); }
  [[nodiscard]] PointRates make_points() const { return {size(), vibrations_.size()}; }

  /// A step of `length` [s] from y0.
  void begin(const VecX& y0, double length);

  /// Writes the solution at point m, or at the end for m = kPoints.
  void write_state(int m, const PointRates& rates, VecX& y) { write_state(rows_[m], rates, y); }
  /// At a part x of the step.
  void write_state_within(double x, const PointRates& rates, VecX& y);

  /// What was found at point m, where the solution is y.
  void keep_rates(int m, const VecX& y, const VecX& ydot, PointRates& rates) const;
  /// g at point m from ydot, a and adot, with the vibrations as they are now.
  void take_rest(int m, PointRates& rates) const;
  /// Writes, over y, the changes of rates that differences of ydot and of g stand for: those of modes by g.
  void write_change(const Eigen::Ref<const VecX>& of_ydot, const Eigen::Ref<const VecX>& of_g, VecX& change) const;

 private:
  /// Integrals from the begin of the step to a part x of it.
  struct Integrals {
    explicit Integrals(Eigen::Index n_modes)
        : of_place(n_modes, kPoints), of_rate(n_modes, kPoints), place(n_modes), rate(n_modes) {}

    PointRow plain;  // factors of ydot
    MatX of_place;   // factors of g in xi
    MatX of_rate;    // and in xi'
    VecX place;      // response to xi'(0)
    VecX rate;
  };

  void write_integrals(double x, Integrals& integrals) const;
  void write_state(const Integrals& integrals, const PointRates& rates, VecX& y);

  const Vibrations& vibrations_;
  std::vector<int> at_a_;  // in y
  std::vector<int> at_adot_;
  double length_ = 0.0;
  int version_ = -1;             // of the vibrations that rows were written with
  std::vector<Integrals> rows_;  // to the points and to the end
  Integrals within_;
  VecX y0_;
  VecX xi0_;
  VecX xidot0_;
  VecX xi_;
  VecX xidot_;
};

}  // namespace concord::cartesian
