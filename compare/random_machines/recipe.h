#pragma once

#include "compare/random_machines/generator.h"
#include "compare/random_machines/random.h"

namespace concord::compare::fuzz {

/// What a machine is going to have, decided before any of its parts is drawn.
struct Recipe {
  bool is_aligned = false;
  bool is_wide = false;
  bool is_stiff = false;
  bool is_slender = false;
  bool is_planar = false;
  bool has_twin = false;
  int bodies = 2;
  int loops = 0;
  int elements = 0;
  double flexible = 0.0;  // shares
  double driven = 0.0;
  double sprung = 0.0;
  double coupled = 0.0;
  double resting = 0.0;
};

/// A recipe in a style that is not mixed.
Recipe draw_recipe(Style style, Random& random);

}  // namespace concord::compare::fuzz
