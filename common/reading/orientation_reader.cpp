#include "common/reading/orientation_reader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <numbers>

#include "common/reading/model_checks.h"
#include "common/rotation.h"

namespace concord {

namespace {

constexpr std::array<std::string_view, 3> kAxisNames{"x", "y", "z"};

/// The ways to say an orientation: the keys of each.
const std::array<KnownKeys, 5>& forms() {
  static const std::array<KnownKeys, 5> kForms{KnownKeys{"x", "y", "z"}, KnownKeys{"axis", "angle"},
                                               KnownKeys{"sequence", "angles"}, KnownKeys{"rotation_vector"},
                                               KnownKeys{"euler_parameters"}};
  return kForms;
}

bool has_any(const TableReader& table, const KnownKeys& keys) {
  return std::any_of(keys.begin(), keys.end(), [&](std::string_view key) { return table.has(key); });
}

Mat3 from_columns(const std::array<std::optional<Vec3>, 3>& axes) {
  // The third axis follows from the two that are given, then the less important of those is made perpendicular.
  const int missing = !axes[0] ? 0 : !axes[1] ? 1 : 2;
  const auto axis = [&](int k) {
    return k == missing ? axes[(k + 1) % 3]->cross(*axes[(k + 2) % 3]).normalized() : *axes[k];
  };
  const bool has_z = missing != 2;
  const Vec3 kept = has_z ? axis(2) : axis(0);
  const Vec3 other = has_z ? axis(0) : axis(1);
  const Vec3 squared = (other - kept * kept.dot(other)).normalized();
  if (has_z) return rotation_from_x_and_z(squared, kept);
  return rotation_from_x_and_z(kept, kept.cross(squared));
}

std::optional<Mat3> read_axes(const TableReader& table) {
  constexpr double kSlack = 1e-6;      // rad
  constexpr double kRoundOff = 1e-12;  // of expressions
  std::array<std::optional<Vec3>, 3> axes;
  KnownKeys given;
  bool readable = true;
  for (int k = 0; k < 3; ++k) {
    if (!table.has(kAxisNames[k])) continue;
    given.push_back(kAxisNames[k]);
    axes[k] = table.direction(kAxisNames[k]);
    readable = readable && axes[k].has_value();
  }
  if (given.size() != 2) {
    table.complain(given.front(), fmt::format("a frame takes two of its axes 'x', 'y', 'z', found {}", given.size()));
    return std::nullopt;
  }
  if (!readable) return std::nullopt;
  const Vec3& first = axes[given.front().front() - 'x'].value();
  const Vec3& second = axes[given.back().front() - 'x'].value();
  const double angle = angle_between(first, second);
  const double off = std::abs(angle - std::numbers::pi / 2.0);
  if (off >= kSlack) {
    table.complain(given.back(), fmt::format("axes {} and {} must be perpendicular, but they enclose {:.10g} deg",
                                             given.front(), given.back(), angle * 180.0 / std::numbers::pi));
    return std::nullopt;
  }
  if (off > kRoundOff) {
    const std::string_view turned = given.back() == "z" ? given.front() : given.back();
    table.note(given.back(), fmt::format("axes {} and {} are {:.2g} rad off square: {} is turned to be perpendicular",
                                         given.front(), given.back(), off, turned));
  }
  return from_columns(axes);
}

std::optional<Mat3> read_axis_angle(const TableReader& table) {
  if (!table.require({"axis", "angle"})) return std::nullopt;
  const auto axis = table.direction("axis");
  const auto angle = table.number("angle");
  if (!axis || !angle) return std::nullopt;
  return rotation_about(*axis, *angle);
}

std::optional<Mat3> read_sequence(const TableReader& table) {
  if (!table.require({"sequence", "angles"})) return std::nullopt;
  const auto sequence = table.text("sequence");
  const auto angles = table.vector3("angles");
  if (!sequence || !angles) return std::nullopt;
  if (sequence->size() != 3 || sequence->find_first_not_of("xyz") != std::string::npos) {
    table.complain("sequence", fmt::format("'sequence' must be three letters of x, y, z, such as \"zxz\", found \"{}\"",
                                           *sequence));
    return std::nullopt;
  }
  Mat3 reached = Mat3::Identity();
  for (int k = 0; k < 3; ++k) {
    reached = reached * rotation_about(static_cast<Axis>((*sequence)[k] - 'x'), (*angles)(k));
  }
  return reached;
}

std::optional<Mat3> read_rotation_vector(const TableReader& table) {
  const auto vector = table.vector3("rotation_vector");
  if (!vector) return std::nullopt;
  const double angle = vector->norm();
  if (angle == 0.0) return Mat3(Mat3::Identity());
  return rotation_about(Vec3(*vector / angle), angle);
}

std::optional<Mat3> read_euler_parameters(const TableReader& table) {
  const auto p = table.vector("euler_parameters", 4);
  if (!p) return std::nullopt;
  if (p->norm() == 0.0) {
    table.complain("euler_parameters", "'euler_parameters' must not all be zero");
    return std::nullopt;
  }
  return Mat3(Eigen::Quaterniond((*p)(0), (*p)(1), (*p)(2), (*p)(3)).normalized().toRotationMatrix());
}

}  // namespace

KnownKeys with_orientation(KnownKeys own) {
  for (const KnownKeys& form : forms()) own.insert(own.end(), form.begin(), form.end());
  return own;
}

bool says_orientation(const TableReader& table) {
  return std::any_of(forms().begin(), forms().end(), [&](const KnownKeys& form) { return has_any(table, form); });
}

std::optional<Mat3> read_orientation(const TableReader& table) {
  using Read = std::optional<Mat3> (*)(const TableReader&);
  constexpr std::array<Read, 5> kReaders{read_axes, read_axis_angle, read_sequence, read_rotation_vector,
                                         read_euler_parameters};
  std::optional<std::size_t> said;
  for (std::size_t k = 0; k < forms().size(); ++k) {
    if (!has_any(table, forms()[k])) continue;
    if (said) {
      table.complain(
          "an orientation is said in one way: two of x, y, z; axis and angle; sequence and angles; "
          "rotation_vector; or euler_parameters");
      return std::nullopt;
    }
    said = k;
  }
  if (!said) return Mat3(Mat3::Identity());
  return kReaders[*said](table);
}

}  // namespace concord
