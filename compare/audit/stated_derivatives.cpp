#include "compare/audit/stated_derivatives.h"

#include <cmath>
#include <numbers>

#include "compare/audit/differences.h"

namespace concord::compare {

namespace {

using joints::CoordinateKind;
using joints::FunctionOfCoordinates;
using joints::FunctionOfPlacement;

constexpr double kLongestStep = 2e-3;  // rad, or of the length
constexpr double kGoodSlope = 1e-10;   // of the terms

/// The first word that is stated by a function, or nullptr.
template <class Words>
const typename Words::value_type* word_by_function(const Words& words) {
  for (const auto& word : words) {
    if (joints::function_of(word) != nullptr) return &word;
  }
  return nullptr;
}

std::vector<bool> are_angles(const joints::CoordinateKinds& kinds) {
  std::vector<bool> angles;
  for (const CoordinateKind kind : kinds) angles.push_back(kind == CoordinateKind::angle);
  return angles;
}

/// Lengths in units of `length`: all six directions of [d; rho] are then of one kind.
Vec6 weights_of(double length) { return (Vec6() << Vec3::Constant(length), Vec3::Ones()).finished(); }

/// Notes the derivatives of one function after the other.
class Notes {
 public:
  Notes(const RelativeMotion& relative, double length) : relative_(relative), length_(length) {}

  [[nodiscard]] std::vector<StatedDerivative> take() { return std::move(notes_); }

  /// Slopes of a motion over each coordinate, and Sdot u along the motion of the coordinates.
  void note(const joints::Permit& word, const VecX& q, const VecX& u) {
    const FunctionOfCoordinates& function = *joints::function_of(word);
    const FunctionOfCoordinates::Motion here = evaluate(function, q, u);
    const Vec6 weights = weights_of(length_);
    StatedDerivative slopes;
    double rate = 0.0;
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      const double unit = joints::is_length(word, static_cast<int>(k)) ? length_ : 1.0;
      rate = std::max(rate, std::abs(u(k)) / unit);
      const auto reached = [&](double h) {
        const joints::Placement at = evaluate(function, q + h * unit * VecX::Unit(q.size(), k), u).placement;
        Vec6 moved;
        moved << at.d - here.placement.d, rotation_vector_of(at.R * here.placement.R.transpose());
        return VecX(moved);
      };
      const Vec6 stated = unit * here.S.col(k);
      note_worst(reached, stated, weights, stated.cwiseQuotient(weights).norm(), slopes);
    }
    notes_.push_back(slopes);
    // Along the motion, in a time in which nothing goes farther than 1 rad or the length.
    StatedDerivative bias;
    if (rate > 0.0) {
      const VecX slow = u / rate;
      const FunctionOfCoordinates::Motion slowly = evaluate(function, q, slow);
      const auto velocity = [&](double h) {
        return VecX(evaluate(function, q + h * slow, slow).S.leftCols(q.size()) * slow);
      };
      const double size = (slowly.S.leftCols(q.size()) * slow).cwiseQuotient(weights).norm();
      note_worst(velocity, slowly.Sdot_u, weights, size + slowly.Sdot_u.cwiseQuotient(weights).norm(), bias);
    }
    notes_.push_back(bias);
  }

  /// Gradients of functions of the placement, and what the velocities add to their second rates. `turns`: which are
  /// angles, that may jump by whole turns.
  void note(const FunctionOfPlacement& function, const std::vector<bool>& turns) {
    const FunctionOfPlacement::Rows here = evaluate(function, {relative_.d, relative_.R}, Vec6::Zero());
    const Vec6 weights = weights_of(length_);
    const Mat6X weighted = weights.asDiagonal() * here.gradient.leftCols(here.n);
    VecX scales(here.n);
    for (int k = 0; k < here.n; ++k) scales(k) = std::max(weighted.col(k).norm(), kSmallest);
    StatedDerivative slopes;
    for (int direction = 0; direction < 6; ++direction) {
      const Vec6 way = weights(direction) * Vec6::Unit(direction);
      const auto value = [&](double h) {
        VecX change = evaluate(function, moved_by(h * way), Vec6::Zero()).value.head(here.n) - here.value.head(here.n);
        for (int k = 0; k < here.n; ++k) {
          if (turns[static_cast<std::size_t>(k)]) change(k) = std::remainder(change(k), 2.0 * std::numbers::pi);
        }
        return change;
      };
      note_worst(value, weighted.row(direction).transpose(), scales, 1.0, slopes);
    }
    notes_.push_back(slopes);
    StatedDerivative bias;
    const double rate = relative_.v_rel.cwiseQuotient(weights).norm();
    if (rate > 0.0) {
      const Vec6 slow = relative_.v_rel / rate;
      const FunctionOfPlacement::Rows slowly = evaluate(function, {relative_.d, relative_.R}, slow);
      const auto speed = [&](double h) {
        const FunctionOfPlacement::Rows at = evaluate(function, moved_by(h * slow), slow);
        return VecX(at.gradient.leftCols(here.n).transpose() * slow);
      };
      const VecX stated = slowly.bias.head(here.n);
      note_worst(speed, stated, scales + stated.cwiseAbs(), 1.0, bias);
    }
    notes_.push_back(bias);
  }

 private:
  static constexpr double kSmallest = 1e-100;  // where a function does not depend on the placement at all

  static FunctionOfCoordinates::Motion evaluate(const FunctionOfCoordinates& function, const VecX& q, const VecX& u) {
    FunctionOfCoordinates::Motion motion;
    function.evaluate(q.data(), u.data(), motion);
    return motion;
  }

  static FunctionOfPlacement::Rows evaluate(const FunctionOfPlacement& function, const joints::Placement& at,
                                            const Vec6& v_rel) {
    FunctionOfPlacement::Rows rows;
    function.evaluate(at, v_rel, rows);
    return rows;
  }

  [[nodiscard]] joints::Placement moved_by(const Vec6& way) const {
    return {relative_.d + way.head<3>(), exponential_of(way.tail<3>()) * relative_.R};
  }

  /// Keeps the worst misfit of a derivative; entries of the function count over `units`, their size is `size`.
  template <class Function>
  static void note_worst(const Function& f, const VecX& stated, const VecX& units, double size,
                         StatedDerivative& worst) {
    const double scale = std::max(size, kSmallest);
    const SlopeMisfit found = slope_misfit(f, stated, scale * units, kLongestStep, kGoodSlope);
    if (!(found.size * scale <= worst.misfit)) worst.misfit = found.size * scale;
    worst.scale = std::max(worst.scale, scale);
  }

  const RelativeMotion& relative_;
  double length_;
  std::vector<StatedDerivative> notes_;
};

}  // namespace

std::vector<std::string> stated_derivatives(const joints::JointType& type) {
  std::vector<std::string> names;
  const auto add = [&](const char* what, const char* of) {
    names.push_back(std::string("slopes of the ") + of);
    names.push_back(std::string(what) + " of the " + of);
  };
  if (word_by_function(type.permits) != nullptr) add("Sdot u", "motion");
  if (word_by_function(type.forbids) != nullptr) add("bias", "residuals");
  if (word_by_function(type.reads) != nullptr) add("bias", "reading");
  return names;
}

std::vector<StatedDerivative> compute_stated_derivatives(const joints::JointType& type, const RelativeMotion& relative,
                                                         const JointMotion& motion, double length) {
  Notes notes(relative, length);
  if (const joints::Permit* word = word_by_function(type.permits)) notes.note(*word, motion.q, motion.u);
  if (const joints::Forbid* word = word_by_function(type.forbids)) {
    notes.note(*joints::function_of(*word), std::vector<bool>(static_cast<std::size_t>(joints::rows(*word)), false));
  }
  if (const joints::Read* word = word_by_function(type.reads)) {
    notes.note(*joints::function_of(*word), are_angles(joints::kinds_of(*word)));
  }
  return notes.take();
}

}  // namespace concord::compare
