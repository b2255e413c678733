#pragma once

#include <array>
#include <string_view>
#include <vector>

/// Which of Simbody's parts stand for which joint type.
namespace concord::compare::oracle {

enum class Mobilizer { weld, pin, slider, cylinder, ball, universal, free, planar, screw };

/// A joint speed and the generalized speed of the mobilizer that is the same number.
struct Mobility {
  int speed;   // among the speeds of the joint
  int number;  // among those of the mobilizer
  bool slides;
};

/// What a mobilizer leaves to a constraint.
enum class Beside { nothing, edge, rolling };

struct Recipe {
  std::string_view type;
  Mobilizer mobilizer;
  /// The axes of the joint's frames that are x, y and z of the mobilizer's.
  std::array<int, 3> axes;
  std::vector<Mobility> mobilities;
  /// The mobilizer carries a link without mass that points along this axis of the mobilizer, with a ball at its end;
  /// -1: no link.
  int link = -1;
  Beside beside = Beside::nothing;
};

/// The recipe of a joint type, or nullptr.
inline const Recipe* find_recipe(std::string_view type) {
  static const std::vector<Recipe> recipes{
      {"weld", Mobilizer::weld, {0, 1, 2}, {}},
      {"revolute", Mobilizer::pin, {0, 1, 2}, {{0, 0, false}}},
      {"translational", Mobilizer::slider, {2, 0, 1}, {{0, 0, true}}},
      {"cylindrical", Mobilizer::cylinder, {0, 1, 2}, {{0, 1, true}, {1, 0, false}}},
      {"spherical", Mobilizer::ball, {0, 1, 2}, {}},
      {"universal", Mobilizer::universal, {0, 1, 2}, {{0, 0, false}, {1, 1, false}}},
      {"free", Mobilizer::free, {0, 1, 2}, {{0, 3, true}, {1, 4, true}, {2, 5, true}}},
      {"distance", Mobilizer::universal, {0, 1, 2}, {{0, 0, false}, {1, 1, false}}, 2},
      {"revolute_spherical", Mobilizer::pin, {0, 1, 2}, {{0, 0, false}}, 0},
      {"universal_spherical", Mobilizer::universal, {1, 2, 0}, {{0, 0, false}, {1, 1, false}}, 2},
      {"knife_edge", Mobilizer::planar, {0, 1, 2}, {{0, 1, true}, {1, 2, true}, {2, 0, false}}, -1, Beside::edge},
      {"rolling_ball", Mobilizer::free, {0, 1, 2}, {{0, 3, true}, {1, 4, true}}, -1, Beside::rolling},
      {"screw", Mobilizer::screw, {0, 1, 2}, {{0, 0, false}}},
  };
  for (const Recipe& recipe : recipes) {
    if (recipe.type == type) return &recipe;
  }
  return nullptr;
}

}  // namespace concord::compare::oracle
