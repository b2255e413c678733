#pragma once

#include <pybind11/numpy.h>

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/model.h"
#include "common/results.h"
#include "compare/python/bindings.h"
#include "compare/quantities/agreement.h"

namespace concord::compare::python {

/// One solver's run, and the arrays that were made of it.
struct Run {
  std::shared_ptr<Model> model;
  std::string solver;
  std::string integrator;
  double rtol = 0.0;
  Trajectory trajectory;
  /// What is unique in each sample; missing where it was not asked.
  std::optional<Mask> unique;
  /// Audit and energy in words; empty where they were not asked.
  std::string check;
  std::map<std::string, py::array> arrays = {};
};

}  // namespace concord::compare::python
