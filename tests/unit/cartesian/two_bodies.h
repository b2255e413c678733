#pragma once

#include <string>

#include "cartesian/dynamics/dynamics.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian::testing {

/// Two bodies on a joint, somewhere and in motion.
struct TwoBodies {
  Model model;
  Equations equations;
  Dynamics dynamics;
  VecX q;
  VecX Y;

  TwoBodies(unsigned seed, const std::string& type, int m_parent, int m_child)
      : model(make_pair(seed, *joints::find(type), m_parent, m_child)), equations(model), dynamics(equations) {
    Numbers numbers(seed);
    q = numbers.matrix(equations.layout().n_q(), 1, 0.4);
    equations.layout().normalize(q);
    Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
  }
};

}  // namespace concord::cartesian::testing
