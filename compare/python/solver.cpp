#include "common/solver.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <mutex>

#include "cartesian/solver.h"
#include "compare/python/bindings.h"
#include "compare/python/interruptible.h"
#include "compare/python/options.h"
#include "compare/python/run.h"
#include "compare/python/states.h"
#include "relative/solver.h"

namespace concord::compare::python {

namespace {

using Times = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// One solver and the model that it is bound to. The interpreter is free while it works; one thread at a time does.
class BoundSolver {
 public:
  BoundSolver(std::shared_ptr<Model> model, const std::string& name)
      : model_(std::move(model)),
        solver_(is_cartesian(*model_, name) ? cartesian::make_solver(*model_) : relative::make_solver(*model_)) {}

  [[nodiscard]] const std::shared_ptr<Model>& model() const { return model_; }
  [[nodiscard]] const Solver& solver() const { return *solver_; }

  std::shared_ptr<State> start() {
    const py::gil_scoped_release others_run;
    const std::lock_guard one_at_a_time(in_use_);
    return std::make_shared<State>(solver_->assemble());
  }

  std::shared_ptr<State> close(const State& guess) {
    return at<std::shared_ptr<State>>(guess, [&](const State& state) {
      auto found = solver_->close(state);
      return found ? std::make_shared<State>(std::move(*found)) : nullptr;
    });
  }

  std::shared_ptr<Evaluated> evaluate(const State& state, bool uniqueness) {
    return at<std::shared_ptr<Evaluated>>(state, [&](const State& one) {
      auto found = std::make_shared<Evaluated>(Evaluated{solver_->evaluate(one), nullptr});
      if (uniqueness) found->rank = std::make_shared<RankReport>(solver_->rank(one));
      return found;
    });
  }

  std::shared_ptr<RankReport> rank(const State& state) {
    return at<std::shared_ptr<RankReport>>(
        state, [&](const State& one) { return std::make_shared<RankReport>(solver_->rank(one)); });
  }

  std::shared_ptr<Run> run(const AskedRun& asked, const std::string& integrator, const State* start) {
    RunOptions options = run_options(*model_, verify_options(*model_, asked, {}));
    options.integrator = chosen_integrator(*model_, *solver_, integrator);
    if (start != nullptr) {
      check_state(*model_, *start);
      if (start->t != 0.0) refuse(*model_, fmt::format("a run starts at time 0, the state is of {:g} s", start->t));
      options.start = *start;
    }
    StopFlag stop{false};
    Trajectory trajectory = interruptibly(stop, [&] {
      const std::lock_guard one_at_a_time(in_use_);
      return solver_->integrate(options, [&](double /*t*/) { check(stop); });
    });
    return std::make_shared<Run>(Run{model_, std::string(solver_->name()), options.integrator, options.rtol,
                                     std::move(trajectory), std::nullopt, ""});
  }

 private:
  /// Works at a copy of the state, which Python may change meanwhile.
  template <class Result, class Work>
  Result at(const State& state, const Work& work) {
    check_state(*model_, state);
    const State copy = state;
    const py::gil_scoped_release others_run;
    const std::lock_guard one_at_a_time(in_use_);
    return work(copy);
  }

  std::shared_ptr<Model> model_;
  std::mutex in_use_;
  std::unique_ptr<Solver> solver_;
};

/// Until and samples that times in equal steps from zero mean.
AskedRun asked_by(const Model& model, const Times& times, AskedRun asked) {
  constexpr double kSameTime = 1e-12;
  if (asked.until || asked.samples) refuse(model, "give either times, or until and samples");
  if (times.ndim() != 1 || times.size() < 2) refuse(model, "times must be a list of at least two numbers");
  const py::ssize_t last = times.size() - 1;
  asked.until = times.at(last);
  asked.samples = static_cast<long>(last);
  for (py::ssize_t k = 0; k <= last; ++k) {
    const double expected = *asked.until * static_cast<double>(k) / static_cast<double>(last);
    if (std::abs(times.at(k) - expected) <= kSameTime * std::abs(*asked.until)) continue;
    refuse(model, fmt::format("times must rise from 0 in equal steps: times[{}] is {:g}, expected {:g}", k, times.at(k),
                              expected));
  }
  return asked;
}

std::shared_ptr<Run> run_solver(BoundSolver& self, const std::optional<Times>& times, std::optional<double> until,
                                std::optional<long> samples, std::optional<double> rtol, const std::string& integrator,
                                const State* start) {
  AskedRun asked{until, rtol, samples};
  if (times) asked = asked_by(*self.model(), *times, asked);
  return self.run(asked, integrator, start);
}

}  // namespace

void bind_solver(py::module_& module) {
  py::class_<BoundSolver>(module, "Solver", "One solver, bound to one model.")
      .def(py::init<std::shared_ptr<Model>, const std::string&>(), py::arg("model").none(false), py::arg("name"))
      .def_property_readonly("name", [](const BoundSolver& self) { return std::string(self.solver().name()); })
      .def_property_readonly("model", &BoundSolver::model)
      .def_property_readonly("integrators", [](const BoundSolver& self) { return self.solver().integrators(); })
      .def_property_readonly("cut_joints", [](const BoundSolver& self) { return self.solver().cut_joints(); })
      .def("start", &BoundSolver::start)
      .def("close", &BoundSolver::close, py::arg("guess"))
      .def("evaluate", &BoundSolver::evaluate, py::arg("state"), py::kw_only(), py::arg("uniqueness") = false)
      .def("rank", &BoundSolver::rank, py::arg("state"))
      .def("run", &run_solver, py::arg("times") = py::none(), py::kw_only(), py::arg("until") = py::none(),
           py::arg("samples") = py::none(), py::arg("rtol") = py::none(), py::arg("integrator") = "",
           py::arg("start") = py::none())
      .def("__repr__", [](const BoundSolver& self) {
        return text_of(fmt::format("<concord.Solver {} of '{}'>", self.solver().name(), self.model()->name));
      });
}

}  // namespace concord::compare::python
