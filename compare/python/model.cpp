#include "common/model.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <map>

#include "common/reading/model_file.h"
#include "compare/python/bindings.h"
#include "compare/python/views.h"

namespace concord::compare::python {

namespace {

template <class Item>
py::tuple names_of(const std::vector<Item>& items) {
  py::tuple names(items.size());
  for (std::size_t k = 0; k < items.size(); ++k) names[k] = text_of(items[k].name);
  return names;
}

/// Names of parent and child of each joint.
py::tuple ends_of_joints(const Model& model) {
  py::tuple all(model.joints.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    all[k] = py::make_tuple(text_of(model.bodies[joint.on(Side::parent).body].name),
                            text_of(model.bodies[joint.on(Side::child).body].name));
  }
  return all;
}

py::tuple types_of_joints(const Model& model) {
  py::tuple all(model.joints.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) all[k] = text_of(model.joints[k].type->name);
  return all;
}

py::tuple modes_of_bodies(const Model& model) {
  py::tuple all(model.bodies.size());
  for (std::size_t k = 0; k < model.bodies.size(); ++k) all[k] = py::int_(model.bodies[k].n_modes());
  return all;
}

std::shared_ptr<Model> load(const std::filesystem::path& path, const std::map<std::string, double>& parameters) {
  const py::gil_scoped_release others_run;
  return std::make_shared<Model>(read_model(path, parameters));
}

}  // namespace

void bind_model(py::module_& module) {
  py::class_<Model, std::shared_ptr<Model>>(module, "Model", "The statement of a machine, as read from a file.")
      .def_property_readonly("name", [](const Model& model) { return text_of(model.name); })
      .def_property_readonly("file", [](const Model& model) { return text_of(model.file); })
      .def_property_readonly("bodies", [](const Model& model) { return names_of(model.bodies); })
      .def_property_readonly("modes", modes_of_bodies)
      .def_property_readonly("joints", [](const Model& model) { return names_of(model.joints); })
      .def_property_readonly("joint_types", types_of_joints)
      .def_property_readonly("joint_ends", ends_of_joints)
      .def_property_readonly("couplings", [](const Model& model) { return names_of(model.couplings); })
      .def_property_readonly("elements", [](const Model& model) { return names_of(model.elements); })
      .def_property_readonly("gravity",
                             [](const py::object& self) {
                               const auto& model = self.cast<const Model&>();
                               return view<double>(self, model.gravity.data(), {3}, {sizeof(double)}, Access::read);
                             })
      .def_property_readonly("until", [](const Model& model) { return model.run.until; })
      .def_property_readonly("is_flexible", &Model::is_flexible)
      .def("__repr__", [](const Model& model) {
        return text_of(fmt::format("<concord.Model '{}': {} bodies, {} joints, {} elements>", model.name,
                                   model.bodies.size() - 1, model.joints.size(), model.elements.size()));
      });
  module.def("load", load, py::arg("path"), py::kw_only(), py::arg("parameters") = std::map<std::string, double>{});
}

}  // namespace concord::compare::python
