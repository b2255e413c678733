#include <fmt/format.h>
#include <ida/ida.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "cartesian/dynamics/state_scales.h"
#include "cartesian/run/ida_jacobian.h"
#include "cartesian/run/refined_lu.h"
#include "cartesian/run/stepper.h"
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

class IdaStepper : public Stepper {
 public:
  IdaStepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance)
      : Stepper(dynamics, start),
        layout_(equations_.layout()),
        places_(equations_),
        jacobian_(dynamics, places_, start.q, start.Y),
        linear_solver_(jacobian_.column_starts(), jacobian_.row_indices(), context_),
        mass_matrices_(make_mass_matrices(layout_)),
        interpolated_(start) {
    all_rows_ = VecX::Zero(places_.n_rows);
    quasi_ = VecX::Zero(layout_.n_Y());
    momentum_ = VecX::Zero(layout_.n_Y());
    set_up(start, tolerance);
  }

 protected:
  /// IDA steps past `limit` and interpolates: its formulas interpolate to their own order, and a stop would cost them
  /// it.
  void advance(double limit) override {
    // Only the first step after a start looks at where it leads: no nearer than a step that went well before.
    const double toward = std::max(limit, reached_ + last_step_);
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

  [[nodiscard]] int parts_of_step() const override { return 1; }
  [[nodiscard]] bool remembers_multipliers() const override { return true; }

  void restart(double t) override {
    check(IDAGetLastStep(memory_.get(), &last_step_), "IDAGetLastStep", messages_);
    write_start(t, motion_);
    check(IDAReInit(memory_.get(), t, x_.get(), xdot_.get()), "IDAReInit", messages_);
    check(IDASetInitStep(memory_.get(), 0.0), "IDASetInitStep", messages_);  // IDA's own: an event may follow at once
  }

 private:
  void read(double t, MotionState& motion) {
    check(IDAGetDky(memory_.get(), t, 0, dense_.get()), "IDAGetDky", messages_);
    const auto x = view(dense_.get());
    motion.q = x.head(places_.first_Y);
    motion.Y = x.segment(places_.first_Y, layout_.n_Y());
    motion.work = x(places_.at_work);
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
      *vector = sundials::make_vector(places_.size, context_);
    }
    write_tolerances(start, write_start(0.0, start), tolerance);
    view(id_.get()).head(places_.first_lambda).setOnes();
    view(id_.get())(places_.at_work) = 1.0;
    memory_.reset(require(IDACreate(context_.get()), "IDACreate"));
    void* ida = memory_.get();
    check(IDASetErrHandlerFn(ida, sundials::MessageRecord::record, &messages_), "IDASetErrHandlerFn", messages_);
    check(IDAInit(ida, &IdaStepper::residual, 0.0, x_.get(), xdot_.get()), "IDAInit", messages_);
    check(IDASVtolerances(ida, tolerance.rtol, tolerances_.get()), "IDASVtolerances", messages_);
    check(IDASetUserData(ida, this), "IDASetUserData", messages_);
    check(IDASetId(ida, id_.get()), "IDASetId", messages_);
    check(IDASetSuppressAlg(ida, SUNTRUE), "IDASetSuppressAlg", messages_);
    make_matrix();
    check(IDASetLinearSolver(ida, linear_solver_.get(), matrix_.get()), "IDASetLinearSolver", messages_);
    // Constraint rows do not depend on c: scaling their correction by the change of c would spoil it.
    check(IDASetLinearSolutionScaling(ida, SUNFALSE), "IDASetLinearSolutionScaling", messages_);
    check(IDASetJacFn(ida, &IdaStepper::jacobian), "IDASetJacFn", messages_);
    set_first_step(tolerance);
  }

  /// IDA itself begins with a step that moves the motion by half its tolerance. Where strong dampers act that is so
  /// short that the round-off of places over the step is larger than any speed, and Newton's method does not converge.
  /// A first step of the first order leaves half its square: it may move the motion by the root of the tolerance.
  void set_first_step(Tolerance tolerance) {
    constexpr double kOfRun = 1e-3;  // the longest
    const auto x = view(x_.get());
    const auto xdot = view(xdot_.get());
    const auto is_differential = view(id_.get()).array();
    const VecX allowed = tolerance.rtol * x.cwiseAbs() + view(tolerances_.get());
    const double rate = (is_differential * xdot.array() / allowed.array()).matrix().norm() / std::sqrt(places_.size);
    if (!(rate > 0.0) || !std::isfinite(rate)) return;
    const double step = 0.5 / (rate * std::sqrt(tolerance.rtol));
    check(IDASetInitStep(memory_.get(), std::min(step, kOfRun * tolerance.until)), "IDASetInitStep", messages_);
  }

  void make_matrix() {
    const auto size = static_cast<sunindextype>(places_.size);
    const auto entries = static_cast<sunindextype>(jacobian_.row_indices().size());
    matrix_.reset(require(SUNSparseMatrix(size, size, entries, CSC_MAT, context_.get()), "SUNSparseMatrix"));
  }

  const Solution& write_start(double t, const MotionState& start) {
    const Solution& solution = dynamics_.solve_at(t, start.q, start.Y, Pivots::fresh);
    auto x = view(x_.get());
    auto xdot = view(xdot_.get());
    x.setZero();
    xdot.setZero();
    x.head(places_.first_Y) = start.q;
    x.segment(places_.first_Y, layout_.n_Y()) = start.Y;
    x.segment(places_.first_lambda, places_.n_rows) = solution.lambda();
    x(places_.at_work) = start.work;
    layout_.write_qdot(start.q, start.Y, xdot.head(places_.first_Y));
    xdot.segment(places_.first_Y, layout_.n_Y()) = solution.Ydot();
    xdot(places_.at_work) = equations_.power_of(solution.lambda());
    return solution;
  }

  /// Multipliers are not controlled (the reactions are computed anew from q and Y): they get the size of forces and
  /// speeds themselves, so that only Newton's convergence on the motion counts. mu in particular carries round-off over
  /// the step.
  void write_tolerances(const MotionState& start, const Solution& at_start, Tolerance tolerance) {
    const VecX sizes_of_motion = motion_sizes(equations_, start.q, start.Y, tolerance.until);
    auto tolerances = view(tolerances_.get());
    tolerances.head(places_.first_lambda) = tolerance.rtol * sizes_of_motion.head(places_.first_lambda);
    double work = sizes_of_motion(sizes_of_motion.size() - 1);  // of a multiplier over a unit of its row
    tolerances(places_.at_work) = tolerance.rtol * work;
    const VecX& sizes = equations_.row_sizes();
    for (const RowIndex row : places_.rows()) {
      work = std::max(work, std::abs(at_start.lambda()(row.value)) * sizes(row.value));
    }
    rate_ = sizes_of_motion.segment(places_.first_Y, layout_.n_Y()).cwiseQuotient(equations_.units()).maxCoeff();
    for (const RowIndex row : places_.rows()) {
      const double size = sizes(row.value) > 0.0 ? sizes(row.value) : 1.0;
      tolerances(places_.at_lambda(row)) = work / size;
      if (places_.has_mu(row)) tolerances(places_.at_mu(row)) = rate_ / size;
    }
    tolerances.segment(places_.first_nu, places_.n_nu).setConstant(rate_);
  }

  /// mu, spread from its places over all rows.
  void spread_mu(const Eigen::Ref<const VecX>& mu) {
    for (const RowIndex row : places_.rows()) {
      all_rows_(row.value) = places_.has_mu(row) ? mu(places_.place_of_mu[row.value]) : 0.0;
    }
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

  void write_residual(double t, const Eigen::Map<VecX>& x, const Eigen::Map<VecX>& xdot, Eigen::Map<VecX> F) {  // (C61)
    const auto q = x.head(places_.first_Y);
    const auto Y = x.segment(places_.first_Y, layout_.n_Y());
    // With p brought to unit length no constraint depends on |p|, as the Jacobian has it.
    unit_q_ = q;
    layout_.normalize(unit_q_);
    equations_.update(t, unit_q_, Y);

    quasi_.setZero();
    spread_mu(x.segment(places_.first_mu, places_.n_mu));
    dynamics_.add_Phi_Y_transposed_times(all_rows_, quasi_);
    quasi_ = Y + equations_.units().cwiseAbs2().cwiseProduct(quasi_);
    layout_.write_qdot(q, quasi_, F.head(places_.first_Y));
    for (const BodyIndex i : layout_.moving_bodies()) {
      const double nu = x(places_.at_nu(i));
      layout_.p(F, i) += nu * layout_.p(q, i);
      F(places_.at_nu(i)) = 0.5 * (layout_.p(q, i).squaredNorm() - 1.0);
    }
    F.head(places_.first_Y) = xdot.head(places_.first_Y) - F.head(places_.first_Y);

    equations_.write_mass_matrices(mass_matrices_);
    write_mass_times(layout_, mass_matrices_, xdot.segment(places_.first_Y, layout_.n_Y()), momentum_);
    momentum_ -= equations_.forces();
    all_rows_ = x.segment(places_.first_lambda, places_.n_rows);
    dynamics_.add_Phi_Y_transposed_times(all_rows_, momentum_);
    F.segment(places_.first_Y, layout_.n_Y()) = momentum_;
    for (const RowIndex row : places_.rows()) {
      const bool is_active = dynamics_.is_active(row);
      const int at_lambda = places_.at_lambda(row);
      F(at_lambda) = is_active ? equations_.velocity_residual()(row.value) : x(at_lambda);
      if (!places_.has_mu(row)) continue;
      const int at_mu = places_.at_mu(row);
      F(at_mu) = is_active ? equations_.residual()(row.value) : x(at_mu);
    }
    F(places_.at_work) = xdot(places_.at_work) - equations_.power_of(all_rows_);
  }

  static int jacobian(sunrealtype t, sunrealtype c, N_Vector x, N_Vector, N_Vector, SUNMatrix matrix, void* pointer,
                      N_Vector, N_Vector, N_Vector) {
    auto& self = *static_cast<IdaStepper*>(pointer);
    try {
      self.jacobian_.write(t, c, view(x), self.rate_, SUNSparseMatrix_Data(matrix));
    } catch (const SolverError& error) {
      self.why_ = error.what();
      return 1;
    }
    const auto& starts = self.jacobian_.column_starts();
    const auto& rows = self.jacobian_.row_indices();
    std::copy(starts.begin(), starts.end(), SUNSparseMatrix_IndexPointers(matrix));
    std::copy(rows.begin(), rows.end(), SUNSparseMatrix_IndexValues(matrix));
    return 0;
  }

  struct FreeMemory {
    void operator()(void* memory) const { IDAFree(&memory); }
  };

  const Layout& layout_;
  IdaUnknowns places_;
  IdaJacobian jacobian_;
  sundials::MessageRecord messages_;
  sundials::Context context_;
  sundials::Vector x_, xdot_, dense_, tolerances_, id_;
  sundials::Matrix matrix_;
  RefinedLu linear_solver_;
  std::unique_ptr<void, FreeMemory> memory_;
  double rate_ = 0.0;  // of the machine [1/s]: its speeds in its units
  ByBody<MatX> mass_matrices_;
  VecX all_rows_;
  VecX unit_q_;
  VecX quasi_;
  VecX momentum_;
  sunrealtype last_step_ = 0.0;  // before the last restart
  int n_standing_ = 0;           // steps in a row that did not move the time
  MotionState interpolated_;
  std::string why_;
};

}  // namespace

std::unique_ptr<Stepper> make_ida_stepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance) {
  return std::make_unique<IdaStepper>(dynamics, start, tolerance);
}

}  // namespace concord::cartesian
