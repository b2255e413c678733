#include <pybind11/pybind11.h>

#include "common/error.h"
#include "compare/python/bindings.h"
#include "compare/quantities/observe.h"

/// What the libraries throw, as exceptions of Python.
namespace concord::compare::python {

namespace {

/// They live as long as the interpreter.
struct Raised {
  PyObject* input = nullptr;
  PyObject* solver = nullptr;
  PyObject* singular = nullptr;
  PyObject* diagnostic = nullptr;
};

Raised& raised() {
  static Raised all;
  return all;
}

PyObject* make(py::module_& module, const char* name, const char* about, PyObject* base) {
  const std::string full = std::string("concord.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full.c_str(), about, base, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module.add_object(name, type);
  return type;
}

void raise(PyObject* type, const std::string& what) { PyErr_SetObject(type, text_of(what).ptr()); }

void raise_input_error(const InputError& error) {
  const py::handle diagnostic = raised().diagnostic;
  py::list diagnostics;
  for (const Diagnostic& one : error.diagnostics()) {
    diagnostics.append(diagnostic(text_of(one.where.file), one.where.line, one.where.column, text_of(one.message)));
  }
  py::object instance = py::handle(raised().input)(text_of(error.what()));
  instance.attr("diagnostics") = diagnostics;
  PyErr_SetObject(raised().input, instance.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    raise_input_error(error);
  } catch (const SingularPose& error) {
    raise(raised().singular, error.what());
  } catch (const SolverError& error) {
    raise(raised().solver, error.what());
  } catch (const IncompleteResult& error) {
    raise(raised().solver, error.what());
  }
}

}  // namespace

py::str text_of(const std::string& bytes) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<py::ssize_t>(bytes.size()), "replace"));
}

void bind_errors(py::module_& module) {
  raised().input = make(module, "InputError",
                        "Bad input; the program would end with 2. The text has a line for each complaint,\n"
                        "`file:line:column: error: message`; `diagnostics` has the same in parts.",
                        PyExc_ValueError);
  py::handle(raised().input).attr("diagnostics") = py::tuple();  // of one that Python raises itself
  raised().solver = make(module, "SolverError",
                         "A solver could not finish; the text says which one, when, where and why. The program would\n"
                         "end with 3.",
                         PyExc_RuntimeError);
  raised().singular = make(module, "SingularPose", "A pose in which the constraints lose rank.", raised().solver);
  py::object diagnostic =
      py::module_::import("collections").attr("namedtuple")("Diagnostic", "file line column message");
  diagnostic.attr("__module__") = "concord";
  diagnostic.attr("__doc__") = "A complaint and its place; lines and columns count from 1, 0: not known.";
  module.attr("Diagnostic") = diagnostic;
  raised().diagnostic = diagnostic.release().ptr();
  py::register_exception_translator(translate);
}

}  // namespace concord::compare::python
