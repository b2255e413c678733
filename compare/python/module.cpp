#include "compare/nightly/history.h"
#include "compare/python/bindings.h"

/// concord._native: what the package `concord` shows to Python.
PYBIND11_MODULE(_native, module) {
  namespace python = concord::compare::python;
  module.doc() = "The compiled part of the package concord.";
  python::bind_errors(module);
  python::bind_model(module);
  python::bind_states(module);
  python::bind_series(module);
  python::bind_solver(module);
  python::bind_compare(module);
  module.attr("version") = CONCORD_VERSION;
  module.attr("history_format") = concord::compare::nightly::kHistoryFormat;
}
