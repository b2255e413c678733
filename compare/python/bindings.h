#pragma once

#include <pybind11/pybind11.h>

#include <string>

/// The parts of the module; each adds its classes and functions.
namespace concord::compare::python {

namespace py = pybind11;

void bind_errors(py::module_& module);
void bind_model(py::module_& module);
void bind_states(py::module_& module);
void bind_series(py::module_& module);
void bind_solver(py::module_& module);
void bind_compare(py::module_& module);

/// Text of any bytes: names of files need not be UTF-8.
py::str text_of(const std::string& bytes);

}  // namespace concord::compare::python
