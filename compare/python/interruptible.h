#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <optional>

#include "compare/python/bindings.h"
#include "compare/states/branch.h"

/// Long work that leaves Python free and ends soon after Ctrl-C.
namespace concord::compare::python {

/// Thrown in the thread that works when Python wants it to stop. No error of a model or a solver: nothing on the way
/// catches it.
struct Stopped {};

/// Python's wish that the work stops.
using StopFlag = std::atomic<bool>;

/// Throws Stopped if the flag is set.
void check(const StopFlag& stop);

/// Makers of both solvers; each call of a solver, and each step of a run, looks at the flag, which must outlive them.
SolverMakers stoppable_makers(const StopFlag& stop);

/// Raises what a signal handler of Python raises; nothing if no signal came. The caller holds the interpreter.
std::optional<py::error_already_set> pending_signal();

/// Does the work in a thread of its own while the interpreter is free for other threads. A signal that Python turns
/// into an exception, such as Ctrl-C, sets the flag; the exception is raised when the work has ended.
template <class Work>
auto interruptibly(StopFlag& stop, const Work& work) {
  constexpr std::chrono::milliseconds kPatience{50};
  auto done = std::async(std::launch::async, work);
  std::optional<py::error_already_set> signal;
  {
    const py::gil_scoped_release others_run;
    while (done.wait_for(kPatience) != std::future_status::ready) {
      if (stop) continue;
      const py::gil_scoped_acquire held;
      signal = pending_signal();
      if (signal) stop = true;
    }
  }
  if (!signal) return done.get();
  throw py::error_already_set(std::move(*signal));
}

}  // namespace concord::compare::python
