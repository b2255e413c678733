#include "cartesian/bodies/marker_kinematics.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/error.h"
#include "common/rotation.h"

namespace concord::cartesian {

namespace {

constexpr int kSeriesTerms = 11;

struct SeriesCoefficients {
  std::array<double, kSeriesTerms> c1, c2, b1, b2;
};

/// c1 = sum (-1)^k t^2k / (2k + 2)!, c2 = sum (-1)^k t^2k / (2k + 3)!, and their derivatives by t over t.
constexpr SeriesCoefficients make_series() {
  SeriesCoefficients series{};
  double factorial = 2.0;  // (2k + 2)!
  double sign = 1.0;
  for (int k = 0; k < kSeriesTerms; ++k) {
    series.c1[k] = sign / factorial;
    series.c2[k] = sign / (factorial * (2 * k + 3));
    factorial *= (2 * k + 3) * (2 * k + 4);
    sign = -sign;
    // The derivative's term of the same power of t comes from k + 1.
    series.b1[k] = sign * 2 * (k + 1) / factorial;
    series.b2[k] = sign * 2 * (k + 1) / (factorial * (2 * k + 5));
  }
  return series;
}

constexpr SeriesCoefficients kSeries = make_series();

double horner(const std::array<double, kSeriesTerms>& coefficients, double x) {
  double sum = 0.0;
  for (int k = kSeriesTerms - 1; k >= 0; --k) sum = sum * x + coefficients[k];
  return sum;
}

}  // namespace

TangentCoefficients tangent_coefficients(double t_squared) {
  if (t_squared < 1.0) {
    return {horner(kSeries.c1, t_squared), horner(kSeries.c2, t_squared), horner(kSeries.b1, t_squared),
            horner(kSeries.b2, t_squared)};
  }
  const double t = std::sqrt(t_squared);
  const double sine = std::sin(t);
  const double cosine = std::cos(t);
  return {(1.0 - cosine) / t_squared, (t - sine) / (t_squared * t),
          (t * sine - 2.0 * (1.0 - cosine)) / (t_squared * t_squared),
          (3.0 * sine - 2.0 * t - t * cosine) / (t_squared * t_squared * t)};
}

Mat3 exponential_rotation(const Vec3& theta) {
  // exp(theta~) = 1 + theta~ J(theta), with theta~^3 = -t^2 theta~.
  const double t_squared = theta.squaredNorm();
  const TangentCoefficients k = tangent_coefficients(t_squared);
  const Mat3 theta_skew = skew(theta);
  return Mat3::Identity() + (1.0 - k.c2 * t_squared) * theta_skew + k.c1 * (theta_skew * theta_skew);
}

Mat3 tangent(const Vec3& theta) {
  const TangentCoefficients k = tangent_coefficients(theta.squaredNorm());
  const Mat3 theta_skew = skew(theta);
  return Mat3::Identity() + k.c1 * theta_skew + k.c2 * (theta_skew * theta_skew);
}

Vec3 tangent_rate_times_thetadot(const Vec3& theta, const Vec3& thetadot) {
  const TangentCoefficients k = tangent_coefficients(theta.squaredNorm());
  const double growth = theta.dot(thetadot);
  const Vec3 turn = theta.cross(thetadot);
  return k.b1 * growth * turn + k.b2 * growth * theta.cross(turn) + k.c2 * thetadot.cross(turn);
}

Marker make_marker(const Attachment& attachment) {
  Marker marker;
  marker.A_Psi_t.setZero(3, attachment.Psi_t_L.cols());
  marker.A_J_Psi_r.setZero(3, attachment.Psi_r_L.cols());
  return marker;
}

LargeRotation::LargeRotation(std::string_view owner, double turned, const std::string& when)
    : SolverError(fmt::format("cartesian:{} the frame of {} has turned by {:.3g} rad through deformation alone; linear "
                              "modes hold for small rotations and the exponential map below pi",
                              when, owner, turned)),
      angle(turned),
      of(owner) {}

void refuse_large_rotation(double angle) { throw LargeRotation("a joint or force element", angle); }

}  // namespace concord::cartesian
