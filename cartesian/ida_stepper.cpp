#include <fmt/format.h>
#include <ida/ida.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <utility>

#include "cartesian/euler_parameters.h"
#include "cartesian/stepper.h"
#include "common/error.h"
#include "common/sundials.h"

/// Stabilized index-2 equations (Gear, Gupta, Leimkuhler), over x = [q; Y; lambda; mu; nu; work]:
///   qdot = N(q) (Y + Phi_Y^T mu) + p nu,   M Ydot + Phi_Y^T lambda = Q - S - U,
///   Phi_Y Y + Phi_t = 0,   Phi = 0,   (p.p - 1)/2 = 0,   workdot = power.
/// mu stands on the rows that hold for positions; rows that hold for velocities alone have none.
namespace concord::cartesian {

namespace {

using sundials::check;
using sundials::require;
using sundials::view;

/// pdot = E(p)^T omega / 2 = Omega(omega) p / 2: the matrix Omega / 2 (C57).
Eigen::Matrix4d compute_Omega_half(const Vec3& omega) {
  Eigen::Matrix4d half;
  for (int k = 0; k < 4; ++k) half.col(k) = compute_pdot(Vec4::Unit(k), omega);
  return half;
}

/// SparseLu as a linear solver of SUNDIALS: new pivots with every Jacobian, because c changes its entries by many
/// orders of magnitude, and solutions refined, because its rows mix them.
struct RefinedLu {
  std::unique_ptr<SparseLu> lu;
  VecX x;

  static RefinedLu& of(SUNLinearSolver solver) { return *static_cast<RefinedLu*>(solver->content); }

  static SUNLinearSolver_Type type(SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; }

  static int set_up(SUNLinearSolver solver, SUNMatrix matrix) {
    SparseLu& lu = *of(solver).lu;
    std::copy_n(SUNSparseMatrix_Data(matrix), lu.row_indices().size(), lu.values());
    return lu.factor() ? 0 : 1;
  }

  static int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x_vector, N_Vector b_vector, sunrealtype) {
    RefinedLu& self = of(solver);
    self.x = view(b_vector);
    if (!self.lu->solve_refined(self.x, 1e-15)) return 1;
    view(x_vector) = self.x;
    return 0;
  }

  static int free(SUNLinearSolver solver) {
    SUNLinSolFreeEmpty(solver);
    return 0;
  }
};

/// Derivatives of an actor's generalized forces over [r; pi; a] and over Y of the moved side's body, by moved and
/// pushed side.
struct ForceSlopes {
  std::array<std::array<MatX, 2>, 2> over_q;
  std::array<std::array<MatX, 2>, 2> over_Y;
};

ForceSlopes make_slopes(const Actor& actor, const Layout& layout) {
  ForceSlopes slopes;
  for (const Side moved : {Side::parent, Side::child}) {
    for (const Side pushed : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(moved) || !actor.sits_on_moving_body(pushed)) continue;
      const MatX none =
          MatX::Zero(layout.size_Y(actor.ends[index(pushed)]->body), layout.size_Y(actor.ends[index(moved)]->body));
      slopes.over_q[index(moved)][index(pushed)] = none;
      slopes.over_Y[index(moved)][index(pushed)] = none;
    }
  }
  return slopes;
}

class IdaStepper : public Stepper {
 public:
  IdaStepper(Equations& equations, const MotionState& start, Tolerance tolerance)
      : Stepper(equations, start), layout_(equations.layout()), interpolated_(start) {
    n_rows_ = equations.constraints().n_rows();
    for (int row = 0; row < n_rows_; ++row) {
      place_of_mu_.push_back(equations.constraints().holds_positions(row) ? n_mu_++ : -1);
    }
    first_Y_ = layout_.n_q();
    first_lambda_ = first_Y_ + layout_.n_Y();
    first_mu_ = first_lambda_ + n_rows_;
    first_nu_ = first_mu_ + n_mu_;
    at_work_ = first_nu_ + layout_.n_bodies() - 1;
    size_ = at_work_ + 1;
    all_rows_ = VecX::Zero(equations.constraints().n_rows());
    quasi_ = VecX::Zero(layout_.n_Y());
    momentum_ = VecX::Zero(layout_.n_Y());
    for (const RowBlock& block : equations.constraints().blocks()) {
      rates_over_q_.emplace_back(MatX::Zero(block.n_rows, layout_.size_Y(block.body)));
    }
    for (const Actor& actor : equations.applied().actors()) slopes_.push_back(make_slopes(actor, layout_));
    lay_out_jacobian(start);
    set_up(start, tolerance);
  }

 protected:
  /// IDA steps past `stop` and interpolates: its formulas interpolate to their own order, and a stop would cost them
  /// it.
  void advance(double stop) override {
    // Only the first step after a start looks at where it leads: no nearer than a step that went well before.
    const double toward = std::max(stop, reached_ + last_step_);
    const double before = reached_;
    const int code = IDASolve(memory_.get(), toward, &reached_, x_.get(), xdot_.get(), IDA_ONE_STEP);
    if (code < 0) throw SolverError("cartesian (ida): " + messages_.last + (why_.empty() ? "" : "; " + why_));
    ++steps_;
    require_progress(before);
  }

  const MotionState& interpolate(double t) override {
    read(t, interpolated_);
    return interpolated_;
  }

  void set_motion_at(double t) override { read(t, motion_); }

  [[nodiscard]] bool remembers_multipliers() const override { return true; }

  void restart(double t) override {
    check(IDAGetLastStep(memory_.get(), &last_step_), "IDAGetLastStep", messages_);
    write_start(t, motion_);
    check(IDAReInit(memory_.get(), t, x_.get(), xdot_.get()), "IDAReInit", messages_);
  }

 private:
  void read(double t, MotionState& motion) {
    check(IDAGetDky(memory_.get(), t, 0, dense_.get()), "IDAGetDky", messages_);
    const auto x = view(dense_.get());
    motion.q = x.head(first_Y_);
    motion.Y = x.segment(first_Y_, layout_.n_Y());
    motion.work = x(at_work_);
  }

  /// IDA itself goes on for ever with steps that do not move the time, as it does before a pose where constraints lose
  /// rank. A start may need a few.
  void require_progress(double before) {
    constexpr int kMostStandingSteps = 100;
    constexpr double kRoundOff = 1e-14;
    n_standing_ = reached_ - before > kRoundOff * std::abs(reached_) ? 0 : n_standing_ + 1;
    if (n_standing_ <= kMostStandingSteps) return;
    throw SolverError(
        fmt::format("cartesian (ida): {} steps in a row at t = {:.6g} s are no longer than the round-off of the time",
                    n_standing_, reached_));
  }

  void set_up(const MotionState& start, Tolerance tolerance) {
    for (sundials::Vector* vector : {&x_, &xdot_, &dense_, &tolerances_, &id_}) {
      *vector = sundials::make_vector(size_, context_);
    }
    write_start(0.0, start);
    write_tolerances(start, tolerance);
    view(id_.get()).head(first_lambda_).setOnes();
    view(id_.get())(at_work_) = 1.0;
    memory_.reset(require(IDACreate(context_.get()), "IDACreate"));
    void* ida = memory_.get();
    check(IDASetErrHandlerFn(ida, sundials::MessageRecord::record, &messages_), "IDASetErrHandlerFn", messages_);
    check(IDAInit(ida, &IdaStepper::residual, 0.0, x_.get(), xdot_.get()), "IDAInit", messages_);
    check(IDASVtolerances(ida, tolerance.rtol, tolerances_.get()), "IDASVtolerances", messages_);
    check(IDASetUserData(ida, this), "IDASetUserData", messages_);
    check(IDASetId(ida, id_.get()), "IDASetId", messages_);
    check(IDASetSuppressAlg(ida, SUNTRUE), "IDASetSuppressAlg", messages_);
    make_linear_solver();
    check(IDASetLinearSolver(ida, linear_solver_.get(), matrix_.get()), "IDASetLinearSolver", messages_);
    // Constraint rows do not depend on c: scaling their correction by the change of c would spoil it.
    check(IDASetLinearSolutionScaling(ida, SUNFALSE), "IDASetLinearSolutionScaling", messages_);
    check(IDASetJacFn(ida, &IdaStepper::jacobian), "IDASetJacFn", messages_);
  }

  void make_linear_solver() {
    refined_lu_.lu = std::make_unique<SparseLu>(std::vector<int>(starts_.begin(), starts_.end()),
                                                std::vector<int>(rows_.begin(), rows_.end()));
    linear_solver_.reset(require(SUNLinSolNewEmpty(context_.get()), "SUNLinSolNewEmpty"));
    linear_solver_->content = &refined_lu_;
    linear_solver_->ops->gettype = &RefinedLu::type;
    linear_solver_->ops->setup = &RefinedLu::set_up;
    linear_solver_->ops->solve = &RefinedLu::solve;
    linear_solver_->ops->free = &RefinedLu::free;
  }

  void write_start(double t, const MotionState& start) {
    equations_.update(t, start.q, start.Y);
    equations_.solve(true);
    auto x = view(x_.get());
    auto xdot = view(xdot_.get());
    x.setZero();
    xdot.setZero();
    x.head(first_Y_) = start.q;
    x.segment(first_Y_, layout_.n_Y()) = start.Y;
    x.segment(first_lambda_, n_rows_) = equations_.lambda();
    x(at_work_) = start.work;
    layout_.write_qdot(start.q, start.Y, xdot.head(first_Y_));
    xdot.segment(first_Y_, layout_.n_Y()) = equations_.Ydot();
    xdot(at_work_) = equations_.power();
  }

  /// Multipliers are not controlled (the reactions are computed anew from q and Y): they get the size of forces and
  /// speeds themselves, so that only Newton's convergence on the motion counts. mu in particular carries round-off over
  /// the step.
  void write_tolerances(const MotionState& start, Tolerance tolerance) {
    const VecX motion = absolute_tolerances(equations_, start, tolerance);
    auto tolerances = view(tolerances_.get());
    tolerances.head(first_lambda_) = motion.head(first_lambda_);
    tolerances(at_work_) = motion(motion.size() - 1);
    double work = motion(motion.size() - 1) / tolerance.rtol;  // of a multiplier over a unit of its row
    for (int row = 0; row < n_rows_; ++row) {
      work = std::max(work, std::abs(equations_.lambda()(row)) * equations_.row_sizes()(row));
    }
    rate_ = (motion.segment(first_Y_, layout_.n_Y()).array() / equations_.units().array()).maxCoeff() / tolerance.rtol;
    for (int row = 0; row < n_rows_; ++row) {
      const double size = equations_.row_sizes()(row) > 0.0 ? equations_.row_sizes()(row) : 1.0;
      tolerances(first_lambda_ + row) = work / size;
      if (place_of_mu_[row] >= 0) tolerances(first_mu_ + place_of_mu_[row]) = rate_ / size;
    }
    tolerances.segment(first_nu_, layout_.n_bodies() - 1).setConstant(rate_);
  }

  /// mu, spread from its places over all rows.
  void spread_mu(const Eigen::Ref<const VecX>& mu) {
    for (int row = 0; row < n_rows_; ++row) all_rows_(row) = place_of_mu_[row] >= 0 ? mu(place_of_mu_[row]) : 0.0;
  }

  static int residual(sunrealtype t, N_Vector x_vector, N_Vector xdot_vector, N_Vector residual_vector, void* pointer) {
    auto& self = *static_cast<IdaStepper*>(pointer);
    try {
      ++self.evaluations_;
      self.write_residual(t, view(x_vector), view(xdot_vector), view(residual_vector));
    } catch (const SolverError& error) {
      self.why_ = error.what();
      return 1;
    }
    return 0;
  }

  void write_residual(double t, const Eigen::Map<VecX>& x, const Eigen::Map<VecX>& xdot, Eigen::Map<VecX> F) {  // (C56)
    const auto q = x.head(first_Y_);
    const auto Y = x.segment(first_Y_, layout_.n_Y());
    // With p brought to unit length no constraint depends on |p|, as the Jacobian has it.
    unit_q_ = q;
    layout_.normalize(unit_q_);
    equations_.update(t, unit_q_, Y);

    quasi_.setZero();
    spread_mu(x.segment(first_mu_, n_mu_));
    equations_.add_Phi_Y_transposed_times(all_rows_, quasi_);
    quasi_ = Y + equations_.units().cwiseAbs2().cwiseProduct(quasi_);
    layout_.write_qdot(q, quasi_, F.head(first_Y_));
    for (int i = 1; i < layout_.n_bodies(); ++i) {
      const double nu = x(first_nu_ + i - 1);
      layout_.p(F, i) += nu * layout_.p(q, i);
      F(first_nu_ + i - 1) = 0.5 * (layout_.p(q, i).squaredNorm() - 1.0);
    }
    F.head(first_Y_) = xdot.head(first_Y_) - F.head(first_Y_);

    equations_.fill_mass_matrices();
    equations_.write_mass_times(xdot.segment(first_Y_, layout_.n_Y()), momentum_);
    momentum_ -= equations_.forces();
    all_rows_ = x.segment(first_lambda_, n_rows_);
    equations_.add_Phi_Y_transposed_times(all_rows_, momentum_);
    F.segment(first_Y_, layout_.n_Y()) = momentum_;
    for (int row = 0; row < n_rows_; ++row) {
      const bool is_active = equations_.is_active(row);
      F(first_lambda_ + row) = is_active ? equations_.velocity_residual()(row) : x(first_lambda_ + row);
      if (place_of_mu_[row] < 0) continue;
      const int at_mu = first_mu_ + place_of_mu_[row];
      F(at_mu) = is_active ? equations_.residual()(row) : x(at_mu);
    }
    F(at_work_) = xdot(at_work_) - equations_.power_of(all_rows_);
  }

  /// How Phi_Y Y of each block's rows changes with the positions of its body, by central differences of the joints
  /// concerned alone: small entries, but Newton's method on the velocity rows needs them, since velocities follow
  /// positions at once.
  void differentiate_rates(const VecX& q, const Eigen::Ref<const VecX>& Y) {
    const auto& blocks = std::as_const(equations_).constraints().blocks();
    for (std::size_t b = 0; b < blocks.size(); ++b) differentiate_rates(blocks[b], q, Y, rates_over_q_[b]);
  }

  void differentiate_rates(const RowBlock& block, const VecX& q, const Eigen::Ref<const VecX>& Y, MatX& rates) {
    constexpr double kStep = 1e-6;  // of the machine's units
    Constraints& constraints = equations_.constraints();
    const auto units = equations_.units().segment(layout_.first_Y(block.body), layout_.size_Y(block.body));
    const auto put = [&](const VecX& at) {
      constraints.place_body(block.body, at);
      constraints.place_and_move(block, at, Y);
    };
    displaced_q_ = q;
    for (int c = 0; c < layout_.size_Y(block.body); ++c) {
      rates.col(c).setZero();
      const double step = kStep * units(c);
      for (const double sign : {1.0, -1.0}) {
        layout_.displace_along(block.body, c, sign * step, displaced_q_);
        put(displaced_q_);
        for (int row = 0; row < rates.rows(); ++row) {
          rates(row, c) += sign * constraints.row_rate(block, row) / (2.0 * step);
        }
        layout_.copy_body(block.body, q, displaced_q_);
      }
    }
    put(q);
  }

  /// How the forces of each actor change with positions and velocities of the bodies that it pushes on, by central
  /// differences of the actor alone.
  void differentiate_forces(double t, const VecX& q, const Eigen::Ref<const VecX>& Y) {
    auto& actors = equations_.applied().actors();
    for (std::size_t a = 0; a < actors.size(); ++a) {
      for (const Side moved : {Side::parent, Side::child}) {
        if (actors[a].sits_on_moving_body(moved)) differentiate_forces(actors[a], moved, t, q, Y, slopes_[a]);
      }
    }
  }

  void differentiate_forces(Actor& actor, Side moved, double t, const VecX& q, const Eigen::Ref<const VecX>& Y,
                            ForceSlopes& slopes) {
    constexpr double kStep = 1e-6;  // of the machine's units
    Constraints& constraints = equations_.constraints();
    const int body = actor.ends[index(moved)]->body;
    const auto units = equations_.units().segment(layout_.first_Y(body), layout_.size_Y(body));
    const auto put = [&](const VecX& at, const VecX& speeds) {
      constraints.place_body(body, at);
      if (actor.joint >= 0) {
        constraints.place_joint(actor.joint, at);
        constraints.move_joint(actor.joint, speeds);
      }
      equations_.applied().update(actor, t, at, speeds);
    };
    const auto add = [&](std::array<MatX, 2>& slope, int c, double over) {
      for (const Side pushed : {Side::parent, Side::child}) {
        if (!actor.sits_on_moving_body(pushed)) continue;
        slope[index(pushed)].col(c) += actor.forces[index(pushed)] / (2.0 * over);
      }
    };
    displaced_q_ = q;
    displaced_Y_ = Y;
    for (int c = 0; c < layout_.size_Y(body); ++c) {
      for (const Side pushed : {Side::parent, Side::child}) {
        if (!actor.sits_on_moving_body(pushed)) continue;
        slopes.over_q[index(moved)][index(pushed)].col(c).setZero();
        slopes.over_Y[index(moved)][index(pushed)].col(c).setZero();
      }
      for (const double step : {kStep * units(c), -kStep * units(c)}) {
        layout_.displace_along(body, c, step, displaced_q_);
        put(displaced_q_, displaced_Y_);
        add(slopes.over_q[index(moved)], c, step);
        layout_.copy_body(body, q, displaced_q_);
      }
      double& speed = displaced_Y_(layout_.first_Y(body) + c);
      const double kept = speed;
      for (const double step : {kStep * rate_ * units(c), -kStep * rate_ * units(c)}) {
        speed = kept + step;
        put(displaced_q_, displaced_Y_);
        add(slopes.over_Y[index(moved)], c, step);
      }
      speed = kept;
    }
    put(displaced_q_, displaced_Y_);
  }

  /// dF/dx + c dF/dxdot without the terms that a short step makes small (how M, S and the direction of the constraint
  /// forces change with position): enough for Newton's method. The visitor sees every entry, in the same order each
  /// time.
  template <class Visit>
  void each_entry(double c, const Eigen::Ref<const VecX>& x, const Visit& visit) const {
    const auto q = x.head(first_Y_);
    const auto Y = x.segment(first_Y_, layout_.n_Y());
    for (int i = 1; i < layout_.n_bodies(); ++i) each_body_entry(i, c, q, Y, visit);
    const auto& blocks = std::as_const(equations_).constraints().blocks();
    for (std::size_t b = 0; b < blocks.size(); ++b) each_row_entry(blocks[b], rates_over_q_[b], q, visit);
    const auto& actors = equations_.applied().actors();
    for (std::size_t a = 0; a < actors.size(); ++a) each_force_entry(actors[a], slopes_[a], q, visit);
    for (int row = 0; row < n_rows_; ++row) {
      const double own = equations_.is_active(row) ? 0.0 : 1.0;
      visit(first_lambda_ + row, first_lambda_ + row, own);
      if (place_of_mu_[row] >= 0) visit(first_mu_ + place_of_mu_[row], first_mu_ + place_of_mu_[row], own);
    }
    visit(at_work_, at_work_, c);
  }

  template <class Q, class V, class Visit>
  void each_body_entry(int i, double c, const Q& q, const V& Y, const Visit& visit) const {
    const int m = layout_.n_modes(i);
    const int at_r = layout_.first_q(i);
    const int at_p = at_r + 3;
    const int at_a = at_r + 7;
    const int at_v = first_Y_ + layout_.first_Y(i);
    const int at_omega = at_v + 3;
    const int at_adot = at_v + 6;
    const int at_nu = first_nu_ + i - 1;
    const Vec4 p = layout_.p(q, i);
    const Eigen::Matrix4d Omega_half = compute_Omega_half(layout_.omega(Y, i));
    const Mat34 E = compute_E(p);
    for (int k = 0; k < 3; ++k) {
      visit(at_r + k, at_r + k, c);
      visit(at_r + k, at_v + k, -1.0);
    }
    for (int row = 0; row < 4; ++row) {
      for (int k = 0; k < 4; ++k) visit(at_p + row, at_p + k, (row == k ? c : 0.0) - Omega_half(row, k));
      for (int k = 0; k < 3; ++k) visit(at_p + row, at_omega + k, -0.5 * E(k, row));
      visit(at_p + row, at_nu, -p(row));
      visit(at_nu, at_p + row, p(row));
    }
    const MatX& M = equations_.mass_matrix(i);
    for (int column = 0; column < 6 + m; ++column) {
      for (int row = 0; row < 6 + m; ++row) {
        double value = c * M(row, column);
        if (row >= 6 && column >= 6) value += equations_.inertia(i).damping()(row - 6, column - 6);
        visit(at_v + row, at_v + column, value);
      }
    }
    for (int k = 0; k < m; ++k) {
      visit(at_a + k, at_a + k, c);
      visit(at_a + k, at_adot + k, -1.0);
      for (int l = 0; l < m; ++l) visit(at_adot + k, at_a + l, equations_.inertia(i).stiffness()(k, l));
    }
  }

  template <class Q, class Visit>
  void each_row_entry(const RowBlock& block, const MatX& rates, const Q& q, const Visit& visit) const {  // (C57)
    const Eigen::Ref<const MatX> Phi_Y_transposed = std::as_const(equations_).constraints().columns(block);
    const int body = block.body;
    const int at_q = layout_.first_q(body);
    const int at_Y = first_Y_ + layout_.first_Y(body);
    const int m = layout_.n_modes(body);
    const Mat34 E = compute_E(layout_.p(q, body));
    const auto squared_units = equations_.units().segment(layout_.first_Y(body), 6 + m).cwiseAbs2();
    for (int row = 0; row < block.n_rows; ++row) {
      const int place = block.first_row + row;
      const double share = equations_.is_active(place) ? 1.0 : 0.0;
      const VecX Phi_Y = share * Phi_Y_transposed.col(row);
      for (int k = 0; k < 6 + m; ++k) {
        visit(at_Y + k, first_lambda_ + place, Phi_Y(k));
        visit(first_lambda_ + place, at_Y + k, Phi_Y(k));
      }
      const Vec4 over_p = 2.0 * E.transpose() * Phi_Y.segment<3>(3);  // dpi = 2 E dp
      const VecX rate = share * rates.row(row);
      const Vec4 rate_over_p = 2.0 * E.transpose() * rate.segment<3>(3);
      for (int k = 0; k < 3; ++k) visit(first_lambda_ + place, at_q + k, rate(k));
      for (int k = 0; k < 4; ++k) visit(first_lambda_ + place, at_q + 3 + k, rate_over_p(k));
      for (int k = 0; k < m; ++k) visit(first_lambda_ + place, at_q + 7 + k, rate(6 + k));
      if (place_of_mu_[block.first_row + row] < 0) continue;
      const int at_mu = first_mu_ + place_of_mu_[block.first_row + row];
      for (int k = 0; k < 3; ++k) visit(at_mu, at_q + k, Phi_Y(k));
      for (int k = 0; k < 4; ++k) visit(at_mu, at_q + 3 + k, over_p(k));
      for (int k = 0; k < m; ++k) visit(at_mu, at_q + 7 + k, Phi_Y(6 + k));
      for (int k = 0; k < 3; ++k) visit(at_q + k, at_mu, -squared_units(k) * Phi_Y(k));
      for (int k = 0; k < 4; ++k) visit(at_q + 3 + k, at_mu, -0.25 * over_p(k));
      for (int k = 0; k < m; ++k) visit(at_q + 7 + k, at_mu, -squared_units(6 + k) * Phi_Y(6 + k));
    }
  }

  template <class Q, class Visit>
  void each_force_entry(const Actor& actor, const ForceSlopes& slopes, const Q& q, const Visit& visit) const {
    for (const Side moved : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(moved)) continue;
      const int body = actor.ends[index(moved)]->body;
      const int at_q = layout_.first_q(body);
      const int at_Y = first_Y_ + layout_.first_Y(body);
      const Mat34 E = compute_E(layout_.p(q, body));
      for (const Side pushed : {Side::parent, Side::child}) {
        if (!actor.sits_on_moving_body(pushed)) continue;
        const int at_row = first_Y_ + layout_.first_Y(actor.ends[index(pushed)]->body);
        const MatX& over_q = slopes.over_q[index(moved)][index(pushed)];
        const MatX& over_Y = slopes.over_Y[index(moved)][index(pushed)];
        for (Eigen::Index row = 0; row < over_q.rows(); ++row) {
          const Vec4 over_p = 2.0 * E.transpose() * over_q.row(row).template segment<3>(3).transpose();  // dpi = 2 E dp
          for (int k = 0; k < 3; ++k) visit(at_row + row, at_q + k, -over_q(row, k));
          for (int k = 0; k < 4; ++k) visit(at_row + row, at_q + 3 + k, -over_p(k));
          for (int k = 6; k < over_q.cols(); ++k) visit(at_row + row, at_q + 1 + k, -over_q(row, k));
          for (int k = 0; k < over_Y.cols(); ++k) visit(at_row + row, at_Y + k, -over_Y(row, k));
        }
      }
    }
  }

  /// Freezes the pattern: every entry that each_entry() ever visits, in compressed columns.
  void lay_out_jacobian(const MotionState& start) {
    equations_.update(0.0, start.q, start.Y);
    equations_.fill_mass_matrices();
    VecX x = VecX::Zero(size_);
    x.head(first_Y_) = start.q;
    std::vector<std::pair<int, int>> visited;  // (column, row)
    each_entry(1.0, x, [&](int row, int column, double) { visited.emplace_back(column, row); });
    std::vector<std::pair<int, int>> pattern = visited;
    std::sort(pattern.begin(), pattern.end());
    pattern.erase(std::unique(pattern.begin(), pattern.end()), pattern.end());
    for (const auto& entry : visited) {
      const auto found = std::lower_bound(pattern.begin(), pattern.end(), entry);
      slots_.push_back(static_cast<int>(found - pattern.begin()));
    }
    starts_.assign(size_ + 1, 0);
    for (const auto& [column, row] : pattern) {
      ++starts_[column + 1];
      rows_.push_back(row);
    }
    for (int column = 0; column < size_; ++column) starts_[column + 1] += starts_[column];
    matrix_.reset(
        require(SUNSparseMatrix(size_, size_, static_cast<sunindextype>(rows_.size()), CSC_MAT, context_.get()),
                "SUNSparseMatrix"));
  }

  static int jacobian(sunrealtype t, sunrealtype c, N_Vector x_vector, N_Vector, N_Vector, SUNMatrix matrix,
                      void* pointer, N_Vector, N_Vector, N_Vector) {
    auto& self = *static_cast<IdaStepper*>(pointer);
    const auto x = view(x_vector);
    const auto Y = x.segment(self.first_Y_, self.layout_.n_Y());
    try {
      self.unit_q_ = x.head(self.first_Y_);
      self.layout_.normalize(self.unit_q_);
      self.equations_.update(t, self.unit_q_, Y);
      self.equations_.fill_mass_matrices();
      self.differentiate_rates(self.unit_q_, Y);
      self.differentiate_forces(t, self.unit_q_, Y);
    } catch (const SolverError& error) {
      self.why_ = error.what();
      return 1;
    }
    std::copy(self.starts_.begin(), self.starts_.end(), SUNSparseMatrix_IndexPointers(matrix));
    std::copy(self.rows_.begin(), self.rows_.end(), SUNSparseMatrix_IndexValues(matrix));
    double* values = SUNSparseMatrix_Data(matrix);
    std::fill_n(values, self.rows_.size(), 0.0);
    std::size_t next = 0;
    self.each_entry(c, x, [&](int, int, double value) { values[self.slots_[next++]] += value; });
    return 0;
  }

  struct FreeMemory {
    void operator()(void* memory) const { IDAFree(&memory); }
  };

  const Layout& layout_;
  std::vector<int> place_of_mu_;  // by row; -1: it holds for velocities alone
  int n_rows_ = 0;
  double rate_ = 0.0;  // of the machine [1/s]: its speeds in its units
  int n_mu_ = 0;
  int first_Y_ = 0;
  int first_lambda_ = 0;
  int first_mu_ = 0;
  int first_nu_ = 0;
  int at_work_ = 0;
  int size_ = 0;
  VecX all_rows_;
  VecX unit_q_;
  VecX displaced_q_;
  VecX displaced_Y_;
  std::vector<ForceSlopes> slopes_;  // by actor
  std::vector<MatX> rates_over_q_;   // by block of rows: rows x (6 + m)
  VecX quasi_;
  VecX momentum_;
  std::vector<int> slots_;
  std::vector<sunindextype> starts_;
  std::vector<sunindextype> rows_;
  sunrealtype last_step_ = 0.0;  // before the last restart
  int n_standing_ = 0;           // steps in a row that did not move the time
  MotionState interpolated_;
  std::string why_;
  sundials::MessageRecord messages_;
  sundials::Context context_;
  sundials::Vector x_, xdot_, dense_, tolerances_, id_;
  sundials::Matrix matrix_;
  RefinedLu refined_lu_;
  sundials::LinearSolver linear_solver_;
  std::unique_ptr<void, FreeMemory> memory_;
};

}  // namespace

std::unique_ptr<Stepper> make_ida_stepper(Equations& equations, const MotionState& start, Tolerance tolerance) {
  return std::make_unique<IdaStepper>(equations, start, tolerance);
}

}  // namespace concord::cartesian
