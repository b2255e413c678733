#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "compare/python/bindings.h"
#include "compare/python/run.h"
#include "compare/python/states.h"
#include "compare/quantities/observe.h"
#include "compare/report/result_files.h"
#include "compare/report/result_folder.h"
#include "compare/resolution/unique_part.h"

/// Time series of a run: its samples, put one after another. Names are those of the NetCDF files.
namespace concord::compare::python {

namespace {

/// How many of everything a model has; modes, coordinates and speeds: the most of any body or joint.
struct Sizes {
  py::ssize_t bodies = 0;
  py::ssize_t joints = 0;
  py::ssize_t elements = 0;
  py::ssize_t couplings = 0;
  py::ssize_t modes = 0;
  py::ssize_t coordinates = 0;
  py::ssize_t speeds = 0;
};

template <class Items>
py::ssize_t count_of(const Items& items) {
  return static_cast<py::ssize_t>(items.size());
}

Sizes sizes_of(const Model& model) {
  Sizes sizes{count_of(model.bodies), count_of(model.joints), count_of(model.elements), count_of(model.couplings)};
  for (const Body& body : model.bodies) sizes.modes = std::max<py::ssize_t>(sizes.modes, body.n_modes());
  for (const Joint& joint : model.joints) {
    sizes.coordinates = std::max<py::ssize_t>(sizes.coordinates, joint.type->n_q());
    sizes.speeds = std::max<py::ssize_t>(sizes.speeds, joint.type->n_u());
  }
  return sizes;
}

using Shape = std::vector<py::ssize_t>;

/// One array: the shape of a sample's part, and what writes that part to its place, which holds NaN.
struct Series {
  const char* name;
  Shape (*shape)(const Sizes& sizes);
  void (*write)(const Sample& sample, py::ssize_t width, double* to);
  bool may_be_open = false;  // NaN where it is not unique, and another array of the solver's own values
};

/// Writes the row that `pick` finds of each item, `width` numbers apart.
template <class Item, class Pick>
void write_rows(const std::vector<Item>& items, py::ssize_t width, double* to, const Pick& pick) {
  for (const Item& item : items) {
    const auto& row = pick(item);
    std::copy(row.begin(), row.end(), to);
    to += width;
  }
}

/// Writes the wrenches on both sides that `pick` finds of each item.
template <class Item, class Pick>
void write_wrenches(const std::vector<Item>& items, double* to, const Pick& pick) {
  for (const Item& item : items) {
    for (const Side side : kSides) {
      const Vec6 wrench = pick(item, side).vector();
      to = std::copy(wrench.begin(), wrench.end(), to);
    }
  }
}

Shape of_bodies(const Sizes& sizes) { return {sizes.bodies, 3}; }
Shape of_modes(const Sizes& sizes) { return {sizes.bodies, sizes.modes}; }
Shape of_speeds(const Sizes& sizes) { return {sizes.joints, sizes.speeds}; }
Shape of_joints(const Sizes& sizes) { return {sizes.joints, 2, 6}; }
Shape of_elements(const Sizes& sizes) { return {sizes.elements, 2, 6}; }
Shape of_times(const Sizes& /*sizes*/) { return {}; }

/// Rows of bodies: of their states, or of their accelerations.
template <auto Member>
void write_state(const Sample& sample, py::ssize_t width, double* to) {
  write_rows(
      sample.state.bodies, width, to, [](const BodyState& one) -> const auto& { return one.*Member; });
}
template <auto Member>
void write_rate(const Sample& sample, py::ssize_t width, double* to) {
  write_rows(
      sample.evaluation.bodies, width, to, [](const BodyAcceleration& one) -> const auto& { return one.*Member; });
}

/// Rows of joints: of their coordinates or speeds.
template <auto Member>
void write_motion(const Sample& sample, py::ssize_t width, double* to) {
  write_rows(sample.state.*Member, width, to, [](const VecX& one) -> const VecX& { return one; });
}

template <auto Kind, auto Axes>
void write_joints(const Sample& sample, py::ssize_t /*width*/, double* to) {
  write_wrenches(sample.evaluation.joints, to, [](const JointWrenches& one, Side side) -> const Wrench& {
    return (one.*Kind)[static_cast<std::size_t>(index(side))].*Axes;
  });
}
template <auto Axes>
void write_elements(const Sample& sample, py::ssize_t /*width*/, double* to) {
  write_wrenches(sample.evaluation.elements, to,
                 [](const ElementWrenches& one, Side side) -> const Wrench& { return one.on_side(side).*Axes; });
}

template <Actor Who>
void write_shares(const Sample& sample, py::ssize_t width, double* to) {
  write_rows(sample.evaluation.joints, width, to,
             [](const JointWrenches& one) -> const VecX& { return one.share_of(Who); });
}
void write_forces(const Sample& sample, py::ssize_t width, double* to) {
  write_rows(sample.evaluation.joints, width, to, [](const JointWrenches& one) -> const VecX& { return one.tau; });
}
void write_couplings(const Sample& sample, py::ssize_t /*width*/, double* to) {
  std::copy(sample.evaluation.couplings.begin(), sample.evaluation.couplings.end(), to);
}

const Series kSeries[] = {
    {"time", of_times, [](const Sample& sample, py::ssize_t, double* to) { *to = sample.state.t; }},
    {"work", of_times, [](const Sample& sample, py::ssize_t, double* to) { *to = sample.work; }},
    {"position", of_bodies, write_state<&BodyState::r>},
    {"euler_parameters",
     [](const Sizes& sizes) {
       return Shape{sizes.bodies, 4};
     },
     write_state<&BodyState::p>},
    {"velocity", of_bodies, write_state<&BodyState::v>},
    {"angular_velocity", of_bodies, write_state<&BodyState::omega>},
    {"acceleration", of_bodies, write_rate<&BodyAcceleration::vdot>},
    {"angular_acceleration", of_bodies, write_rate<&BodyAcceleration::omegadot>},
    {"modal_coordinates", of_modes, write_state<&BodyState::a>},
    {"modal_velocities", of_modes, write_state<&BodyState::adot>},
    {"modal_accelerations", of_modes, write_rate<&BodyAcceleration::addot>},
    {"joint_coordinates",
     [](const Sizes& sizes) {
       return Shape{sizes.joints, sizes.coordinates};
     },
     write_motion<&State::q>},
    {"joint_speeds", of_speeds, write_motion<&State::u>},
    {"coordinate_force", of_speeds, write_forces, true},
    {"driver_force", of_speeds, write_shares<Actor::driver>, true},
    {"motor_force", of_speeds, write_shares<Actor::motor>},
    {"spring_force", of_speeds, write_shares<Actor::spring>},
    {"damper_force", of_speeds, write_shares<Actor::damper>},
    {"reaction", of_joints, write_joints<&JointWrenches::reaction, &SideWrench::in_C>, true},
    {"reaction_global", of_joints, write_joints<&JointWrenches::reaction, &SideWrench::in_global>, true},
    {"total", of_joints, write_joints<&JointWrenches::total, &SideWrench::in_C>, true},
    {"total_global", of_joints, write_joints<&JointWrenches::total, &SideWrench::in_global>, true},
    {"coupling_force", [](const Sizes& sizes) { return Shape{sizes.couplings}; }, write_couplings, true},
    {"element_wrench", of_elements, write_elements<&SideWrench::in_C>},
    {"element_wrench_global", of_elements, write_elements<&SideWrench::in_global>},
};

py::array make_array(const Run& run, const Series& series, const Trajectory& from) {
  Shape shape = series.shape(sizes_of(*run.model));
  const py::ssize_t width = shape.empty() ? 1 : shape.back();
  shape.insert(shape.begin(), count_of(from.samples));
  py::array_t<double> all(shape);
  double* to = all.mutable_data();
  std::fill_n(to, all.size(), std::numeric_limits<double>::quiet_NaN());
  const py::ssize_t step = shape.front() == 0 ? 0 : all.size() / shape.front();
  for (const Sample& sample : from.samples) {
    if (step > 0) series.write(sample, width, to);
    to += step;
  }
  return all;
}

/// With NaN where a number is not unique, as in the files.
py::array make_known_array(const Run& run, const Series& series) {
  const bool may_be_open = run.unique && series.may_be_open;
  const auto known = may_be_open ? unique_part(*run.model, run.trajectory, *run.unique) : std::nullopt;
  return make_array(run, series, known ? *known : run.trajectory);
}

/// Made when it is asked for first, then kept.
template <class Make>
py::array kept(Run& run, const std::string& name, const Make& make) {
  const auto found = run.arrays.find(name);
  if (found != run.arrays.end()) return found->second;
  py::array made = make();
  made.attr("setflags")(py::arg("write") = false);
  return run.arrays.emplace(name, std::move(made)).first->second;
}

/// Which components of the reactions are unique in each sample; nothing where that was not asked.
py::object unique_of(Run& run) {
  if (!run.unique) return py::none();
  return kept(run, "unique", [&] {
    const QuantityLayout layout(*run.model);
    const auto joints = static_cast<int>(run.model->joints.size());
    py::array_t<bool> flags(
        {static_cast<py::ssize_t>(run.unique->cols()), py::ssize_t{joints}, py::ssize_t{2}, py::ssize_t{6}});
    bool* to = flags.mutable_data();
    for (Eigen::Index sample = 0; sample < run.unique->cols(); ++sample) {
      for (int k = 0; k < joints; ++k) {
        for (const Side side : kSides) {
          const int first = layout.first_row(Kind::reaction, k, side);
          for (int c = 0; c < 6; ++c) *to++ = (*run.unique)(first + c, sample);
        }
      }
    }
    return py::array(std::move(flags));
  });
}

const Sample& sample_of(const Run& run, py::ssize_t k) {
  const py::ssize_t count = count_of(run.trajectory.samples);
  const py::ssize_t place = k < 0 ? k + count : k;
  if (place < 0 || place >= count) throw py::index_error(fmt::format("sample {} of {}", k, count));
  return run.trajectory.samples[static_cast<std::size_t>(place)];
}

}  // namespace

void bind_series(py::module_& module) {
  py::class_<Run, std::shared_ptr<Run>> type(module, "Run",
                                             "One solver's run as time series; its arrays are read-only.");
  for (const Series& series : kSeries) {
    type.def_property_readonly(series.name, [&series](Run& run) {
      return kept(run, series.name, [&] { return make_known_array(run, series); });
    });
    if (!series.may_be_open) continue;
    const std::string own = fmt::format("any_{}", series.name);
    type.def_property_readonly(own.c_str(), [&series, own](Run& run) {
      return kept(run, own, [&] { return make_array(run, series, run.trajectory); });
    });
  }
  type.def_property_readonly("unique", unique_of)
      .def_readonly("model", &Run::model)
      .def_readonly("solver", &Run::solver)
      .def_readonly("integrator", &Run::integrator)
      .def_readonly("rtol", &Run::rtol)
      .def_readonly("check", &Run::check)
      .def_property_readonly("steps", [](const Run& run) { return run.trajectory.statistics.steps; })
      .def_property_readonly("evaluations", [](const Run& run) { return run.trajectory.statistics.evaluations; })
      .def_property_readonly("wall_s", [](const Run& run) { return run.trajectory.statistics.wall_s; })
      .def(
          "state", [](const Run& run, py::ssize_t k) { return std::make_shared<State>(sample_of(run, k).state); },
          py::arg("sample"))
      .def(
          "evaluation",
          [](const Run& run, py::ssize_t k) {
            return std::make_shared<Evaluated>(Evaluated{sample_of(run, k).evaluation, nullptr});
          },
          py::arg("sample"))
      .def("__len__", [](const Run& run) { return run.trajectory.samples.size(); })
      .def(
          "write_netcdf",
          [](const Run& run, const std::filesystem::path& path) {
            if (!run.model->file.empty()) check_output(path, {run.model->file});
            write_netcdf(path, *run.model, run.solver, run.trajectory, run.unique ? &*run.unique : nullptr);
          },
          py::arg("path"))
      .def("__repr__", [](const Run& run) {
        return text_of(fmt::format("<concord.Run of '{}' by {}, {} samples>", run.model->name, run.solver,
                                   run.trajectory.samples.size()));
      });
}

}  // namespace concord::compare::python
