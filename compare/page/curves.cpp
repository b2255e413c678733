#include "compare/page/curves.h"

#include <fmt/format.h>
#include <netcdf.h>

#include <algorithm>
#include <limits>

#include "common/error.h"

namespace concord::compare::page {

namespace {

/// Six numbers for each side of each joint or element.
constexpr std::size_t kWrenches = 12;

template <class Vector>
void append(Samples& samples, const Vector& vector) {
  samples.values.insert(samples.values.end(), vector.begin(), vector.end());
}

void append_both_sides(Samples& in_C, Samples& global, const std::array<SideWrench, 2>& sides) {
  for (const SideWrench& side : sides) append(in_C, side.in_C.vector());
  for (const SideWrench& side : sides) append(global, side.in_global.vector());
}

void append_sample(Curves& curves, const Sample& sample) {
  curves.t.push_back(sample.state.t);
  for (std::size_t body = 1; body <= curves.bodies; ++body) {
    const BodyState& state = sample.state.bodies[body];
    append(curves.position, state.r);
    append(curves.euler, state.p);
    append(curves.modal, state.a);
    curves.modal.values.resize(curves.modal.values.size() + curves.modes - static_cast<std::size_t>(state.a.size()),
                               std::numeric_limits<double>::quiet_NaN());
  }
  for (const JointWrenches& joint : sample.evaluation.joints) {
    append_both_sides(curves.reaction, curves.reaction_global, joint.reaction);
  }
  for (const ElementWrenches& element : sample.evaluation.elements) {
    append_both_sides(curves.element, curves.element_global, element.on);
  }
}

void set_widths(Curves& curves) {
  curves.position.width = 3 * curves.bodies;
  curves.euler.width = 4 * curves.bodies;
  curves.modal.width = curves.modes * curves.bodies;
  curves.reaction.width = curves.reaction_global.width = kWrenches * curves.joints;
  curves.element.width = curves.element_global.width = kWrenches * curves.elements;
}

/// A NetCDF file that is only read.
class CurveFile {
 public:
  explicit CurveFile(const std::filesystem::path& path) : path_(path) {
    const int code = nc_open(path.c_str(), NC_NOWRITE, &id_);
    if (code != NC_NOERR) refuse(nc_strerror(code));
  }
  ~CurveFile() { nc_close(id_); }
  CurveFile(const CurveFile&) = delete;
  CurveFile& operator=(const CurveFile&) = delete;

  /// Length of a dimension, zero if the file has none of this name.
  [[nodiscard]] std::size_t length(const char* name) const {
    int dimension = 0;
    std::size_t found = 0;
    if (nc_inq_dimid(id_, name, &dimension) != NC_NOERR) return 0;
    if (nc_inq_dimlen(id_, dimension, &found) != NC_NOERR) return 0;
    return found;
  }

  [[nodiscard]] bool has(const std::string& name) const {
    int variable = 0;
    return nc_inq_varid(id_, name.c_str(), &variable) == NC_NOERR;
  }

  /// All numbers of a variable, whose dimensions must have these lengths.
  [[nodiscard]] std::vector<double> numbers(const std::string& name, const std::vector<std::size_t>& lengths) const {
    int variable = 0;
    if (nc_inq_varid(id_, name.c_str(), &variable) != NC_NOERR) refuse(fmt::format("has no variable '{}'", name));
    std::size_t count = 1;
    for (const std::size_t length : lengths) count *= length;
    if (lengths_of(variable) != lengths) refuse(fmt::format("the variable '{}' has another shape", name));
    std::vector<double> values(count);
    const int code = nc_get_var_double(id_, variable, values.data());
    if (code != NC_NOERR) refuse(fmt::format("the variable '{}' cannot be read: {}", name, nc_strerror(code)));
    return values;
  }

 private:
  [[nodiscard]] std::vector<std::size_t> lengths_of(int variable) const {
    int count = 0;
    if (nc_inq_varndims(id_, variable, &count) != NC_NOERR) refuse("is damaged");
    std::vector<int> dimensions(static_cast<std::size_t>(count));
    if (nc_inq_vardimid(id_, variable, dimensions.data()) != NC_NOERR) refuse("is damaged");
    std::vector<std::size_t> lengths;
    for (const int dimension : dimensions) {
      std::size_t length = 0;
      if (nc_inq_dimlen(id_, dimension, &length) != NC_NOERR) refuse("is damaged");
      lengths.push_back(length);
    }
    return lengths;
  }

  [[noreturn]] void refuse(const std::string& reason) const {
    throw InputError({path_.string(), 0, 0}, fmt::format("is no run that `concord compare --out` wrote: {}", reason));
  }

  std::filesystem::path path_;
  int id_ = 0;
};

}  // namespace

Curves curves_of(const Model& model, const std::string& solver, const Trajectory& trajectory) {
  Curves curves;
  curves.solver = solver;
  curves.bodies = model.bodies.size() - 1;
  curves.joints = model.joints.size();
  curves.elements = model.elements.size();
  for (const Body& body : model.bodies) curves.modes = std::max(curves.modes, static_cast<std::size_t>(body.n_modes()));
  set_widths(curves);
  for (const Sample& sample : trajectory.samples) append_sample(curves, sample);
  return curves;
}

Curves read_curves(const std::filesystem::path& path, const std::string& solver) {
  const CurveFile file(path);
  Curves curves;
  curves.solver = solver;
  const std::size_t n = file.length("time");
  curves.bodies = file.length("body");
  curves.joints = file.length("joint");
  curves.elements = file.length("element");
  curves.modes = file.length("mode");
  set_widths(curves);
  curves.t = file.numbers("time", {n});
  curves.position.values = file.numbers("position", {n, curves.bodies, 3});
  curves.euler.values = file.numbers("euler_parameters", {n, curves.bodies, 4});
  if (curves.modes > 0) curves.modal.values = file.numbers("modal_coordinates", {n, curves.bodies, curves.modes});
  // The solver's own values, as a run in memory has them: the page says what of them is not judged.
  const auto wrenches = [&](const std::string& name, std::size_t count) {
    return file.numbers(file.has("any_" + name) ? "any_" + name : name, {n, count, 2, 6});
  };
  if (curves.joints > 0) {
    curves.reaction.values = wrenches("reaction", curves.joints);
    curves.reaction_global.values = wrenches("reaction_global", curves.joints);
  }
  if (curves.elements > 0) {
    curves.element.values = wrenches("element_wrench", curves.elements);
    curves.element_global.values = wrenches("element_wrench_global", curves.elements);
  }
  return curves;
}

}  // namespace concord::compare::page
