#include "compare/quantities/motions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/audit/digits.h"
#include "compare/audit/free_body.h"
#include "compare/audit/machine_size.h"
#include "compare/audit/places.h"
#include "compare/quantities/observe.h"

namespace concord::compare {

double angle_between(const Mat3& A1, const Mat3& A2) {
  const Mat3 R = A1.transpose() * A2;
  const Vec3 twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(twice_sine.norm(), R.trace() - 1.0);
}

namespace {

/// Least part of the machine's length, and of the speed that gravity gives it, that motion is compared with.
constexpr double kAtRest = 1e-3;

constexpr double kUnitRoundOff = std::numeric_limits<double>::epsilon();
/// What round-off of a place leaves open at the end of a run, as a part of it.
constexpr double kEndOfARun = kUnitsOfARun * kUnitRoundOff;
/// The same of modal coordinates, which are no differences of places.
constexpr double kModalNoise = 20.0 * kUnitRoundOff;

/// What the motions of a run are held against.
struct MotionScales {
  double place = 0.0;  // the farthest that a body goes, m
  double speed = 0.0;
  double turning = 0.0;
  std::vector<double> modal;
  std::vector<double> modal_rate;
  /// What round-off of the coordinates is as a place, and by the machine's length as an angle.
  double place_noise = 0.0;
  double angle_noise = 0.0;
  /// What round-off of the machine's length is as a modal coordinate, and at each mode's own frequency as its rate.
  std::vector<double> modal_noise;
  std::vector<VecX> modal_rate_noise;
};

/// Frequency of each mode alone, rad/s; zero of a mode without stiffness or mass.
VecX frequencies(const ModalData& modal) {
  const VecX masses = modal_masses(modal);
  VecX squares = VecX::Zero(masses.size());
  for (Eigen::Index m = 0; m < squares.size(); ++m) {
    if (masses(m) > 0.0) squares(m) = std::max(0.0, modal.stiffness(m, m) / masses(m));
  }
  return squares.cwiseSqrt();
}

/// What round-off of the machine's length is as a modal coordinate of a body; zero where none moves it.
double modal_noise_of(const Body& body, double length) {
  const double shape = largest_displacements(body).lpNorm<Eigen::Infinity>();
  return shape > 0.0 ? kModalNoise * length / shape : 0.0;
}

/// The part of a difference that round-off does not explain.
double beyond(double difference, double noise) { return difference <= noise ? 0.0 : difference; }
double beyond(const VecX& difference, const VecX& noise) {
  double most = 0.0;
  for (Eigen::Index m = 0; m < difference.size(); ++m) {
    if (!(std::abs(difference(m)) <= noise(m))) most = std::max(most, std::abs(difference(m)));
  }
  return most;
}

MotionScales motion_scales(const Model& model, const Trajectory& trajectory) {
  const MachineSize size(model, trajectory);
  MotionScales scales;
  scales.place = size.length;
  for (const Sample& sample : trajectory.samples) {
    for (std::size_t i = 1; i < model.bodies.size(); ++i) {
      const Vec3& r = sample.state.bodies[i].r;
      scales.place_noise = std::max(scales.place_noise, kEndOfARun * r.cwiseAbs().maxCoeff());
      scales.place = std::max(scales.place, (r - trajectory.samples.front().state.bodies[i].r).norm());
    }
  }
  scales.angle_noise = scales.place_noise / size.length;
  // A machine at rest is compared with what gravity, or the time of the run, would make of it.
  scales.speed = size.speed_or(kAtRest);
  scales.turning = scales.speed / size.length;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    scales.modal.push_back(size.modal[i].lpNorm<Eigen::Infinity>());
    scales.modal_rate.push_back(size.modal_rate[i].lpNorm<Eigen::Infinity>());
    scales.modal_noise.push_back(modal_noise_of(model.bodies[i], size.length));
    scales.modal_rate_noise.emplace_back(VecX::Zero(model.bodies[i].n_modes()));
    const double shape = size.shapes[i].lpNorm<Eigen::Infinity>();
    if (shape == 0.0) continue;
    scales.modal_rate_noise[i] = scales.modal_noise[i] * frequencies(*model.bodies[i].modal);
    scales.modal[i] = std::max(scales.modal[i], kAtRest * size.length / shape);
    scales.modal_rate[i] = std::max(scales.modal_rate[i], kAtRest * scales.speed / shape);
  }
  return scales;
}

}  // namespace

MatX noise_of_speeds(const QuantityLayout& layout, const MatX& resolution, const Trajectory& run) {
  const double length = layout.model().length_scale();
  const auto bodies = static_cast<Eigen::Index>(layout.model().bodies.size());
  Eigen::ArrayXd places(resolution.cols());
  for (Eigen::Index k = 0; k < places.size(); ++k)
    places(k) = size_of_places(run.samples[static_cast<std::size_t>(k)].state, length);
  // What a run leaves open of a place or an angle, times the square of a frequency, is the resolution; the root of both
  // is the former times the frequency.
  const auto noise_of = [&](Eigen::Index row, const Eigen::ArrayXd& round_off) -> VecX {
    const Eigen::Array3Xd known = resolution.middleRows<3>(row).array();
    const Eigen::ArrayXd largest = known.isNaN().select(0.0, known).colwise().maxCoeff().transpose();
    return (largest * round_off).sqrt().matrix();
  };
  Eigen::Index modes = 0;
  for (const Body& body : layout.model().bodies) modes += body.n_modes();
  MatX noise = MatX::Zero(2 * bodies + modes, resolution.cols());
  Eigen::Index of_mode = 2 * bodies;
  for (Eigen::Index i = 1; i < bodies; ++i) {
    const int row = layout.first_row(Kind::acceleration, static_cast<int>(i));
    noise.row(2 * i) = noise_of(row, kEndOfARun * places).transpose();
    noise.row(2 * i + 1) = noise_of(row + 3, kEndOfARun * places / length).transpose();
    const double modal = modal_noise_of(layout.model().bodies[static_cast<std::size_t>(i)], length);
    for (int m = 0; m < layout.model().bodies[static_cast<std::size_t>(i)].n_modes(); ++m) {
      const Eigen::ArrayXd known = resolution.row(row + 6 + m).array();
      noise.row(of_mode++) = (known.isNaN().select(0.0, known) * modal).sqrt().matrix().transpose();
    }
  }
  return noise;
}

MotionAgreement compare_motions(const Model& model, const std::array<const Trajectory*, 2>& trajectories,
                                const MatX& noise) {
  MotionAgreement worst;
  const MotionScales scales = motion_scales(model, *trajectories[0]);
  const std::size_t samples = std::min(trajectories[0]->samples.size(), trajectories[1]->samples.size());
  for (std::size_t k = 0; k < samples; ++k) {
    const State& one = trajectories[0]->samples[k].state;
    const State& other = trajectories[1]->samples[k].state;
    const auto note = [&](double difference, double scale, const char* what, std::size_t body) {
      const double digits = matching_digits(difference, scale);
      if (digits < worst.digits) worst = {digits, one.t, fmt::format("{} of {}", what, model.bodies[body].name)};
    };
    auto of_mode = static_cast<Eigen::Index>(2 * model.bodies.size());
    for (std::size_t i = 1; i < model.bodies.size(); ++i) {
      const BodyState& a = one.bodies[i];
      const BodyState& b = other.bodies[i];
      const double of_velocity = noise.cols() > 0 ? noise(2 * i, k) : 0.0;
      const double of_turning = noise.cols() > 0 ? noise(2 * i + 1, k) : 0.0;
      note(beyond((a.r - b.r).norm(), scales.place_noise), scales.place, "origin", i);
      note(beyond(angle_between(rotation_of(a.p), rotation_of(b.p)), scales.angle_noise), 1.0, "orientation", i);
      note(beyond((a.v - b.v).norm(), of_velocity), scales.speed, "velocity", i);
      note(beyond((a.omega - b.omega).norm(), of_turning), scales.turning, "angular velocity", i);
      if (a.a.size() == 0) continue;
      note(beyond(a.a - b.a, VecX::Constant(a.a.size(), scales.modal_noise[i])), scales.modal[i], "modal coordinates",
           i);
      VecX of_rates = scales.modal_rate_noise[i];
      if (noise.cols() > 0) of_rates = of_rates.cwiseMax(noise.col(k).segment(of_mode, a.a.size()));
      of_mode += a.a.size();
      note(beyond(a.adot - b.adot, of_rates), scales.modal_rate[i], "modal rates", i);
    }
  }
  return worst;
}

}  // namespace concord::compare
