#include "common/joints/facts.h"

namespace concord::joints {

StatedCoordinates stated_coordinates(const Permit& word) {
  return std::visit([](const auto& one) { return one.coordinates(); }, word);
}

CoordinateKinds kinds_of(const Read& word) {
  return std::visit([](const auto& one) { return one.kinds(); }, word);
}

CoordinateKind kind_of(const PermitSpeed& word) {
  return std::visit([](const auto& one) { return one.kind(); }, word);
}

bool is_seen_from_child(const ForbidSpeed& word) {
  return std::visit([](const auto& one) { return one.is_seen_from_child(); }, word);
}

std::optional<Axis> arm_of(const Permit& word) {
  return std::visit([](const auto& one) { return one.arm(); }, word);
}

Push pushed_by(const Read& word) {
  return std::visit([](const auto& one) { return one.pushed_by(); }, word);
}

WrenchesOfPlacement stated_wrenches(const Read& word) {
  return std::visit([](const auto& one) { return one.stated_wrenches(); }, word);
}

bool is_elevation(const Read& word) {
  return std::visit([](const auto& one) { return one.is_elevation(); }, word);
}

int n_q(const Permit& word) {
  int count = 0;
  for (const StatedCoordinate& one : stated_coordinates(word)) count += n_q(one.kind);
  return count;
}

int n_u(const Permit& word) {
  int count = 0;
  for (const StatedCoordinate& one : stated_coordinates(word)) count += n_u(one.kind);
  return count;
}

int n_q(const Read& word) {
  int count = 0;
  for (const CoordinateKind kind : kinds_of(word)) count += n_q(kind);
  return count;
}

int n_u(const Read& word) {
  int count = 0;
  for (const CoordinateKind kind : kinds_of(word)) count += n_u(kind);
  return count;
}

int rows(const Forbid& word) {
  return std::visit([](const auto& one) { return one.rows(); }, word);
}

int rows(const ForbidSpeed& word) {
  return std::visit([](const auto& one) { return one.rows(); }, word);
}

bool is_orientation(const Permit& word) {
  const StatedCoordinates all = stated_coordinates(word);
  return all.size() > 0 && all[0].kind == CoordinateKind::orientation;
}

bool is_orientation(const Read& word) {
  const CoordinateKinds all = kinds_of(word);
  return all.size() > 0 && all[0] == CoordinateKind::orientation;
}

CoordinateKind kind_of(const Permit& word, int number) {
  return is_orientation(word) ? CoordinateKind::orientation : stated_coordinates(word)[number].kind;
}

CoordinateKind kind_of(const Read& word, int number) {
  return is_orientation(word) ? CoordinateKind::orientation : kinds_of(word)[number];
}

bool is_length(const Permit& word, int number) { return kind_of(word, number) == CoordinateKind::length; }

VecX home_of(const Permit& word) {
  VecX q(n_q(word));
  Eigen::Index next = 0;
  for (const StatedCoordinate& one : stated_coordinates(word)) {
    const KindFacts facts = facts_of(one.kind);
    for (int k = 0; k < facts.n_q; ++k) q(next++) = facts.home[static_cast<std::size_t>(k)];
  }
  return q;
}

}  // namespace concord::joints
