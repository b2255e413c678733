#include "compare/nightly/case_model.h"

#include <fmt/format.h>

#include <array>
#include <set>

#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"
#include "compare/random_machines/random.h"

namespace concord::compare::nightly {

namespace {

void name_cuts(const Case& one, Model& model) {
  std::set<std::string> asked(one.cut->begin(), one.cut->end());
  for (Joint& joint : model.joints) joint.named_as_cut = asked.erase(joint.name) > 0;
  if (!asked.empty()) throw refusal(one, fmt::format("no joint is called '{}', which the case cuts", *asked.begin()));
}

/// Sizes by which a coordinate and its speeds are moved.
std::array<double, 2> sizes_of(const StartDraw& draw, joints::CoordinateKind kind) {
  switch (kind) {
    case joints::CoordinateKind::angle:
      return {draw.turn, draw.turn_speed};
    case joints::CoordinateKind::length:
      return {draw.slide, draw.slide_speed};
    case joints::CoordinateKind::orientation:
      return {0.0, draw.turn_speed};
  }
  return {};
}

void move_start(const Case& one, Model& model) {
  fuzz::Random random(one.start->seed, one.start->number);
  bool moves = false;
  const auto move = [&](StartRole role, double size, Eigen::Ref<VecX> values) {
    if (role != StartRole::keep || size == 0.0) return;
    values += random.vector(values.size(), size);
    moves = true;
  };
  for (Joint& joint : model.joints) {
    for (std::size_t k = 0; k < joint.start.size(); ++k) {
      WordStart& start = joint.start[k];
      const joints::StatedCoordinates coordinates = stated_coordinates(joint.type->permits.at(k));
      Eigen::Index next = 0;
      for (const joints::StatedCoordinate& coordinate : coordinates) {
        move(start.role_q, sizes_of(*one.start, coordinate.kind)[0],
             start.q.segment(next, joints::n_q(coordinate.kind)));
        next += joints::n_q(coordinate.kind);
      }
      next = 0;
      for (const joints::StatedCoordinate& coordinate : coordinates) {
        move(start.role_u, sizes_of(*one.start, coordinate.kind)[1],
             start.u.segment(next, joints::n_u(coordinate.kind)));
        next += joints::n_u(coordinate.kind);
      }
    }
  }
  if (!moves) throw refusal(one, "the case draws starts, but the model keeps no coordinate or speed that they move");
}

}  // namespace

InputError refusal(const Case& one, const std::string& reason) {
  return {one.where, fmt::format("{}: {}", one.model.generic_string(), reason)};
}

Model model_of(const Case& one) {
  Model model = read_model(one.model, {one.parameters.begin(), one.parameters.end()});
  model.needs.insert(model.needs.end(), one.needs.begin(), one.needs.end());
  if (one.cut) name_cuts(one, model);
  if (one.start) move_start(one, model);
  return model;
}

}  // namespace concord::compare::nightly
