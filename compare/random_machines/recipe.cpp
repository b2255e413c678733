#include "compare/random_machines/recipe.h"

namespace concord::compare::fuzz {

Recipe draw_recipe(Style style, Random& random) {
  Recipe recipe;
  recipe.bodies = 1 + random.below(4);
  recipe.loops = random.chance(0.25) ? 1 : 0;
  recipe.elements = random.chance(0.4) ? 1 + random.below(2) : 0;
  recipe.flexible = random.chance(0.2) ? 0.4 : 0.0;
  recipe.driven = 0.06;
  recipe.sprung = 0.15;
  recipe.coupled = 0.15;
  if (style == Style::ordinary) {
    recipe.is_aligned = true;
    recipe.resting = 0.7;
    recipe.is_planar = random.chance(0.4);
    recipe.loops = recipe.is_planar && random.chance(0.5) ? 1 : 0;
    recipe.flexible *= 0.5;
  } else if (style == Style::loops) {
    recipe.bodies = 2 + random.below(4);
    recipe.loops = 1 + random.below(2);
  } else if (style == Style::redundant) {
    recipe.is_planar = random.chance(0.5);
    recipe.has_twin = !recipe.is_planar;
    recipe.bodies = recipe.is_planar ? 3 : 1 + random.below(3);
    recipe.loops = 1;
    recipe.flexible = 0.0;
  } else if (style == Style::flexible) {
    recipe.flexible = 0.7;
    recipe.bodies = 1 + random.below(3);
    recipe.loops = random.chance(0.3) ? 1 : 0;
  } else if (style == Style::forces) {
    recipe.elements = 2 + random.below(3);
    recipe.sprung = 0.5;
  } else if (style == Style::wide) {
    recipe.is_wide = true;
  } else if (style == Style::stiff) {
    recipe.is_slender = random.chance(0.4);
    recipe.is_stiff = !recipe.is_slender;
    recipe.elements = 1 + random.below(3);
    recipe.sprung = 0.5;
  }
  return recipe;
}

}  // namespace concord::compare::fuzz
