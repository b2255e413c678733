#include "compare/python/states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/python/bindings.h"
#include "compare/python/views.h"

namespace concord::compare::python {

namespace {

/// At rest in its frames' place, undeformed: closed by no means.
std::shared_ptr<State> state_of_size(const Model& model) {
  auto state = std::make_shared<State>();
  for (const Body& body : model.bodies) {
    BodyState& one = state->bodies.emplace_back();
    one.a = VecX::Zero(body.n_modes());
    one.adot = one.a;
  }
  for (const Joint& joint : model.joints) {
    state->q.emplace_back(VecX::Zero(joint.type->n_q()));
    state->u.emplace_back(VecX::Zero(joint.type->n_u()));
  }
  state->spring_angles.assign(model.elements.size(), kUnwound);
  return state;
}

InputError misfit(const Model& model, const std::string& what) { return {{model.file, 0, 0}, what}; }

void require_size(const Model& model, std::size_t found, std::size_t expected, const std::string& what) {
  if (found == expected) return;
  throw misfit(model, fmt::format("the state has {} {}, the model '{}' has {}", found, what, model.name, expected));
}

void require_finite(const Model& model, bool is_finite, const std::string& owner) {
  if (is_finite) return;
  throw misfit(model, fmt::format("the state of {} holds a number that is not finite", owner));
}

/// A property that shows a row of `width` numbers of each body of a state.
template <class First>
auto rows_of_bodies(py::ssize_t width, First first) {
  return [=](const py::object& self) {
    return rows_view(self, self.cast<const State&>().bodies, width, Access::write, first);
  };
}

/// A property that shows one vector of each body of a state.
template <class Pick>
auto vectors_of_bodies(Pick pick) {
  return
      [=](const py::object& self) { return vectors_view(self, self.cast<const State&>().bodies, Access::write, pick); };
}

auto vectors_of_joints(std::vector<VecX> State::*vectors) {
  return [=](const py::object& self) {
    const auto itself = [](const VecX& vector) -> const VecX& { return vector; };
    return vectors_view(self, self.cast<const State&>().*vectors, Access::write, itself);
  };
}

void bind_state(py::module_& module) {
  const auto copy = [](const State& state) { return std::make_shared<State>(state); };
  py::class_<State, std::shared_ptr<State>>(module, "State",
                                            "A complete state of a machine; its arrays can be written.")
      .def(py::init(&state_of_size), py::arg("model"))
      .def_readwrite("time", &State::t)
      .def_property_readonly("position", rows_of_bodies(3, [](const BodyState& body) { return body.r.data(); }))
      .def_property_readonly("euler_parameters", rows_of_bodies(4, [](const BodyState& body) { return body.p.data(); }))
      .def_property_readonly("velocity", rows_of_bodies(3, [](const BodyState& body) { return body.v.data(); }))
      .def_property_readonly("angular_velocity",
                             rows_of_bodies(3, [](const BodyState& body) { return body.omega.data(); }))
      .def_property_readonly("modal_coordinates",
                             vectors_of_bodies([](const BodyState& body) -> const VecX& { return body.a; }))
      .def_property_readonly("modal_velocities",
                             vectors_of_bodies([](const BodyState& body) -> const VecX& { return body.adot; }))
      .def_property_readonly("joint_coordinates", vectors_of_joints(&State::q))
      .def_property_readonly("joint_speeds", vectors_of_joints(&State::u))
      .def_property_readonly("spring_angles",
                             [](const py::object& self) {
                               auto& angles = self.cast<State&>().spring_angles;
                               return py::array_t<double>(static_cast<py::ssize_t>(angles.size()), angles.data(), self);
                             })
      .def("copy", copy)
      .def("__copy__", copy)
      .def("__deepcopy__", [=](const State& state, const py::dict& /*memo*/) { return copy(state); })
      .def("__repr__", [](const State& state) {
        return fmt::format("<concord.State at {:.6g} s, {} bodies>", state.t, state.bodies.size() - 1);
      });
}

/// A property that shows the wrenches of all joints.
template <class First>
auto wrenches_of_joints(First first) {
  return [=](const py::object& self) {
    return wrenches_view(self, self.cast<const Evaluated&>().evaluation.joints, first);
  };
}

/// A property that shows a number for each speed of all joints.
template <class Of>
auto forces_on_speeds(Of of) {
  return [=](const py::object& self) {
    return vectors_view(self, self.cast<const Evaluated&>().evaluation.joints, Access::read, of);
  };
}

template <Actor Who>
const VecX& share(const JointWrenches& one) {
  return one.share_of(Who);
}

template <class First>
auto wrenches_of_elements(First first) {
  return [=](const py::object& self) {
    return wrenches_view(self, self.cast<const Evaluated&>().evaluation.elements, first);
  };
}

/// A property that shows accelerations of all bodies.
template <class First>
auto rates_of_bodies(First first) {
  return [=](const py::object& self) {
    return rows_view(self, self.cast<const Evaluated&>().evaluation.bodies, 3, Access::read, first);
  };
}

void bind_evaluation(py::module_& module) {
  py::class_<Evaluated, std::shared_ptr<Evaluated>>(module, "Evaluation",
                                                    "What a solver says of one state; its arrays are read-only views.")
      .def_property_readonly("acceleration",
                             rates_of_bodies([](const BodyAcceleration& one) { return one.vdot.data(); }))
      .def_property_readonly("angular_acceleration",
                             rates_of_bodies([](const BodyAcceleration& one) { return one.omegadot.data(); }))
      .def_property_readonly("modal_accelerations",
                             [](const py::object& self) {
                               return vectors_view(
                                   self, self.cast<const Evaluated&>().evaluation.bodies, Access::read,
                                   [](const BodyAcceleration& one) -> const VecX& { return one.addot; });
                             })
      .def_property_readonly("reaction", wrenches_of_joints([](const JointWrenches& one) -> const Wrench& {
                               return one.reaction[0].in_C;
                             }))
      .def_property_readonly("reaction_global", wrenches_of_joints([](const JointWrenches& one) -> const Wrench& {
                               return one.reaction[0].in_global;
                             }))
      .def_property_readonly(
          "total", wrenches_of_joints([](const JointWrenches& one) -> const Wrench& { return one.total[0].in_C; }))
      .def_property_readonly("total_global", wrenches_of_joints([](const JointWrenches& one) -> const Wrench& {
                               return one.total[0].in_global;
                             }))
      .def_property_readonly("coordinate_force",
                             forces_on_speeds([](const JointWrenches& one) -> const VecX& { return one.tau; }))
      .def_property_readonly("driver_force", forces_on_speeds(share<Actor::driver>))
      .def_property_readonly("motor_force", forces_on_speeds(share<Actor::motor>))
      .def_property_readonly("spring_force", forces_on_speeds(share<Actor::spring>))
      .def_property_readonly("damper_force", forces_on_speeds(share<Actor::damper>))
      .def_property_readonly("element_wrench", wrenches_of_elements([](const ElementWrenches& one) -> const Wrench& {
                               return one.on[0].in_C;
                             }))
      .def_property_readonly(
          "element_wrench_global",
          wrenches_of_elements([](const ElementWrenches& one) -> const Wrench& { return one.on[0].in_global; }))
      .def_property_readonly("coupling_force",
                             [](const py::object& self) {
                               const std::vector<double>& all = self.cast<const Evaluated&>().evaluation.couplings;
                               return view<double>(self, all.data(), {static_cast<py::ssize_t>(all.size())},
                                                   {sizeof(double)}, Access::read);
                             })
      .def_readonly("rank", &Evaluated::rank)
      .def("__repr__", [](const Evaluated& one) {
        return fmt::format("<concord.Evaluation of {} bodies, {} joints>", one.evaluation.bodies.size() - 1,
                           one.evaluation.joints.size());
      });
}

using Joints = std::vector<JointUniqueness> RankReport::*;

/// A report that says nothing of what is decided says that all is: an array of that many trues.
py::array all_true(std::vector<py::ssize_t> shape) {
  py::array_t<bool> all(std::move(shape));
  std::fill_n(all.mutable_data(), all.size(), true);
  return all;
}

/// Flags of all joints, six for each of both sides.
auto flags_of_sides(Joints joints, std::array<std::array<bool, 6>, 2> JointUniqueness::*flags) {
  return [=](const py::object& self) {
    const auto& report = self.cast<const RankReport&>();
    const auto& all = report.*joints;
    const auto count = static_cast<py::ssize_t>(report.joints.size());
    if (all.empty()) return all_true({count, 2, 6});
    return view<bool>(self, (all.front().*flags)[0].data(), {count, 2, 6},
                      {sizeof(JointUniqueness), 6 * sizeof(bool), sizeof(bool)}, Access::read);
  };
}

/// Flags of all joints, one for each of the up to six speeds.
auto flags_of_speeds(Joints joints, std::array<bool, 6> JointUniqueness::*flags) {
  return [=](const py::object& self) {
    const auto& report = self.cast<const RankReport&>();
    const auto& all = report.*joints;
    const auto count = static_cast<py::ssize_t>(report.joints.size());
    if (all.empty()) return all_true({count, 6});
    return view<bool>(self, (all.front().*flags).data(), {count, 6}, {sizeof(JointUniqueness), sizeof(bool)},
                      Access::read);
  };
}

/// Flags of all couplings, a copy; empty where the report says nothing: then all are true.
auto flags_of_couplings(std::vector<bool> RankReport::*couplings) {
  return [=](const py::object& self) {
    const std::vector<bool>& all = self.cast<const RankReport&>().*couplings;
    py::array_t<bool> copy(static_cast<py::ssize_t>(all.size()));
    std::copy(all.begin(), all.end(), copy.mutable_data());
    return copy;
  };
}

void bind_rank(py::module_& module) {
  py::class_<RankReport, std::shared_ptr<RankReport>>(
      module, "Rank", "Rank of the constraints in one state, and what is unique there; its arrays are read-only views.")
      .def_readonly("constraints", &RankReport::constraints)
      .def_readonly("rank", &RankReport::rank)
      .def_readonly("degrees_of_freedom", &RankReport::degrees_of_freedom)
      .def_readonly("undecided", &RankReport::undecided)
      .def_readonly("smallest_kept", &RankReport::smallest_kept)
      .def_readonly("largest_dropped", &RankReport::largest_dropped)
      .def_property_readonly("unique", flags_of_sides(&RankReport::joints, &JointUniqueness::unique))
      .def_property_readonly("unique_total", flags_of_sides(&RankReport::joints, &JointUniqueness::unique_total))
      .def_property_readonly("unique_coordinate_force",
                             flags_of_speeds(&RankReport::joints, &JointUniqueness::unique_tau))
      .def_property_readonly("unique_driver_force",
                             flags_of_speeds(&RankReport::joints, &JointUniqueness::unique_driver))
      .def_property_readonly("unique_coupling_force", flags_of_couplings(&RankReport::unique_coupling))
      .def_property_readonly("decided", flags_of_sides(&RankReport::decided, &JointUniqueness::unique))
      .def_property_readonly("decided_total", flags_of_sides(&RankReport::decided, &JointUniqueness::unique_total))
      .def_property_readonly("decided_coordinate_force",
                             flags_of_speeds(&RankReport::decided, &JointUniqueness::unique_tau))
      .def_property_readonly("decided_driver_force",
                             flags_of_speeds(&RankReport::decided, &JointUniqueness::unique_driver))
      .def_property_readonly("decided_coupling_force", flags_of_couplings(&RankReport::decided_coupling))
      .def("__repr__", [](const RankReport& report) {
        return fmt::format("<concord.Rank {} of {} constraints, {} degrees of freedom>", report.rank,
                           report.constraints, report.degrees_of_freedom);
      });
}

void require_ground_at_rest(const Model& model, const BodyState& ground) {
  const BodyState still;
  if (ground.r == still.r && ground.p == still.p && ground.v == still.v && ground.omega == still.omega) return;
  throw misfit(model, "the ground, body 0 of a state, was moved: it is the frame of all others");
}

}  // namespace

void check_state(const Model& model, const State& state) {
  require_size(model, state.bodies.size(), model.bodies.size(), "bodies (ground included)");
  require_size(model, state.q.size(), model.joints.size(), "joints");
  require_finite(model, std::isfinite(state.t), "the clock");
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    const BodyState& one = state.bodies[k];
    const std::string owner = fmt::format("body '{}'", model.bodies[k].name);
    require_size(model, static_cast<std::size_t>(one.a.size()), static_cast<std::size_t>(model.bodies[k].n_modes()),
                 "modal coordinates of " + owner);
    require_finite(model,
                   one.r.allFinite() && one.p.allFinite() && one.v.allFinite() && one.omega.allFinite() &&
                       one.a.allFinite() && one.adot.allFinite(),
                   owner);
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const std::string owner = fmt::format("joint '{}'", model.joints[k].name);
    require_size(model, static_cast<std::size_t>(state.q[k].size()),
                 static_cast<std::size_t>(model.joints[k].type->n_q()), "coordinates of " + owner);
    require_finite(model, state.q[k].allFinite() && state.u[k].allFinite(), owner);
  }
  require_size(model, state.spring_angles.size(), model.elements.size(), "spring angles (one for each force element)");
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    require_finite(model, std::isfinite(state.spring_angles[e]),
                   fmt::format("force element '{}'", model.elements[e].name));
  }
  require_ground_at_rest(model, state.bodies[0]);
}

void bind_states(py::module_& module) {
  bind_state(module);
  bind_evaluation(module);
  bind_rank(module);
}

}  // namespace concord::compare::python
