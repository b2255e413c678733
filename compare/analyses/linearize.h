#pragma once

#include <array>
#include <complex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/solver.h"
#include "compare/analyses/deviations.h"

/// Small motions about a state, from a solver's accelerations alone.
namespace concord::compare::analyses {

/// An eigenvalue of the linearized machine: of a conjugate pair the one with positive imaginary part.
struct Mode {
  std::complex<double> eigenvalue;  // 1/s
  /// By how much the eigenvalue [1/s] and the shape (see shape_difference()) move when the derivatives change by what
  /// they may be wrong by, measured; 0 of a free one, |eigenvalue| and 1 of one that no draw finds again or that does
  /// not solve its equations.
  double eigenvalue_resolution = 0.0;
  double shape_resolution = 0.0;
  /// Takes part in nothing that pulls back: its eigenvalue is zero within the round-off of differences.
  bool is_free = false;
  /// One of two real eigenvalues that may as well be a conjugate pair: the imaginary part is not resolved, and left
  /// out.
  bool is_half_of_unresolved_pair = false;
  /// Velocities [v; omega; adot] of bodies 1, 2, ... in SI units, of unit norm.
  Eigen::VectorXcd shape;
  /// The same in units of the machine, see Chart, of unit norm: what is compared.
  Eigen::VectorXcd scaled_shape;
  /// The same in the chart's coordinates, of unit norm: A x + lambda B x = lambda^2 x.
  Eigen::VectorXcd coordinates;
  std::string motion;  // the joint coordinates that take part most

  [[nodiscard]] bool oscillates() const { return eigenvalue.imag() > 0.0; }
  /// |lambda| / 2 pi [Hz].
  [[nodiscard]] double frequency() const;
  /// -Re lambda / |lambda|; 0 for a free one.
  [[nodiscard]] double damping_ratio() const;
};

struct Linearization {
  State state;
  /// deltaddot = A delta + B deltadot: deviations from the motion through the state, see Deviations.
  MatX A;
  MatX B;
  /// By how much differences leave their entries open.
  MatX A_error;
  MatX B_error;
  /// Speeds of joints and modes, in units of the machine, that the coordinates' rates are: a column for each.
  MatX directions;
  /// Ordered by |lambda|, then by its real part.
  std::vector<Mode> modes;
  /// The root of what differences resolve of the softest motion's stiffness [1/s], see StiffnessSplit.
  double resolution = 0.0;
  /// Eigenvalues are told apart from zero above this [1/s]: without damping and gyroscopic terms above `resolution`,
  /// with them where motions follow that stiffness more slowly.
  double slowest = 0.0;
  /// Fewest and most modes that are free if stiffness must exceed a thirtieth, or thirty times, of what is otherwise
  /// asked: more than one number, where the differences do not decide it.
  std::array<int, 2> free_range{};
  /// Size of that motion's speeds [1/s], and of its accelerations as a part of what its forces and speeds cause: zero
  /// if it is steady.
  double rate = 0.0;
  double unsteadiness = 0.0;
  /// In which deviations are measured.
  TurningAxes axes;
};

/// How far two modes are from moving alike: the norm of what of one's shape is not along the other's, 0 to 1.
double shape_difference(const Mode& one, const Mode& other);

/// Modes of one machine, found twice, that belong to each other, in the order of the first ones, and places of those
/// that have no partner. Nearest eigenvalues and shapes go together, whatever their places in the lists are; below
/// `resolution` [1/s] eigenvalues are not told apart.
struct ModePairs {
  std::vector<std::pair<std::size_t, std::size_t>> both;
  std::array<std::vector<std::size_t>, 2> alone;
};
ModePairs pair_modes(const std::vector<Mode>& one, const std::vector<Mode>& other, double resolution);

/// Linearizes a machine about the motion through a closed state, frozen there, in the coordinates of its joints:
/// derivatives by extrapolated central differences of evaluate() in closed neighbouring states. About a steady motion,
/// such as that of a balanced rotor, eigenvalues are those of the machine; about another one, those of the machine
/// frozen in the state (see steadiness_of()). A mode is free where it meets no
/// stiffness (see StiffnessSplit) and, as a rate, no damping above `resolution`: decided on subspaces of the matrices,
/// not on eigenvalues, which of two equal zeros stray by the root of the round-off. Throws SingularPose, as Chart and
/// stiffness_matrix() do.
Linearization linearize(const Model& model, Solver& solver, const State& state, const TurningAxes& axes = {});

/// By how much the motion of a linearization fails to be steady: 0, or why its modes are those of a frozen machine.
struct Steadiness {
  bool accelerates = false;  // some joint's speed changes
  /// The largest of three: by how much the matrices change in a radian of motion, as a part of the fastest rate and its
  /// square; by how much the permitted directions turn in it; and by how much modes that are told from zero are coupled
  /// anew within a radian of the faster of each two, which a part that is stiff or spins fast does not hide. 0 where
  /// the machine rests or accelerates; infinite where no linearization a little later is found.
  double change = 0.0;

  [[nodiscard]] bool is_steady() const { return !accelerates && change <= 1e-3; }
};
Steadiness steadiness_of(const Model& model, Solver& solver, const Linearization& found);

/// Whether the matrices stay what they are along the motion, though it may accelerate.
bool has_constant_matrices(const Model& model, Solver& solver, const Linearization& found);

/// A linearization in axes that turn, and whether the motion is steady in them; if not, its matrices are.
struct TurningLinearization {
  Linearization found;
  bool is_steady = true;
};

/// The same in axes in which a motion is steady that is not in those of the joints' sides: that of a body that spins
/// about a principal axis, of a top that precesses, of a rotor in bearings that tilt. Where there are none, in axes in
/// which the machine accelerates by a hundredth of what its forces cause at most and the matrices do not change, as
/// those of a rotor with a small unbalance; nothing where there are no such axes either.
std::optional<TurningLinearization> linearize_in_steady_axes(const Model& model, Solver& solver, const State& state);

}  // namespace concord::compare::analyses
