#include <fmt/format.h>
#include <netcdf.h>
#include <netcdf_mem.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "compare/report/files.h"
#include "compare/report/result_files.h"
#include "compare/verdict/columns.h"
#include "compare/verdict/observe.h"

namespace concord::compare {

namespace {

constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
constexpr std::array<const char*, 2> kSideNames{"parent", "child"};

const char* component_unit(int component) { return component < 3 ? "N" : "N m"; }

std::vector<std::string> numbered(const char* letter, int count) {
  std::vector<std::string> names;
  for (int k = 1; k <= count; ++k) names.push_back(fmt::format("{}{}", letter, k));
  return names;
}

std::vector<std::string> element_names(const Model& model) {
  std::vector<std::string> names;
  for (const ForceElement& element : model.elements) names.push_back(element.name);
  return names;
}

/// The NetCDF library is not safe for several threads.
std::mutex& netcdf_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// The bytes of an HDF5 file in memory without the unused room behind its end, which its superblock tells (HDF5 File
/// Format Specification, II.A: of version 0, with offsets of eight bytes).
std::string_view without_room(const NC_memio& image) {
  constexpr std::size_t kVersion = 8;
  constexpr std::size_t kOffsetSize = 13;
  constexpr std::size_t kEndOfFile = 40;
  const std::string_view bytes(static_cast<const char*>(image.memory), image.size);
  if (bytes.size() < kEndOfFile + sizeof(std::uint64_t) || bytes[kVersion] != 0 || bytes[kOffsetSize] != 8)
    return bytes;
  std::uint64_t end = 0;
  for (std::size_t k = 0; k < sizeof end; ++k) {
    end |= std::uint64_t{static_cast<unsigned char>(bytes[kEndOfFile + k])} << (8 * k);
  }
  return bytes.substr(0, end);
}

/// A NetCDF-4 file that is built in memory: on a disk that is full, HDF5 ends the program.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::filesystem::path& path) : path_(path) {
    constexpr std::size_t kFirstBytes = 1 << 16;
    // Where the library gives up, it removes the file of this name, in memory or not: no file can have it.
    const std::filesystem::path nowhere = path / "in memory";
    check(nc_create_mem(nowhere.c_str(), NC_NETCDF4, kFirstBytes, &id_), "nc_create_mem");
    open_ = true;
  }
  ~NetcdfFile() {
    if (open_) nc_abort(id_);
  }
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  int dimension(const char* name, std::size_t length) {
    int dimension = 0;
    check(nc_def_dim(id_, name, length, &dimension), "nc_def_dim");
    return dimension;
  }

  int variable(const char* name, nc_type type, const std::vector<int>& dimensions) {
    int variable = 0;
    const int count = static_cast<int>(dimensions.size());
    check(nc_def_var(id_, name, type, count, dimensions.data(), &variable), "nc_def_var");
    return variable;
  }

  void attribute(int variable, const char* name, const std::string& text) {
    check(nc_put_att_text(id_, variable, name, text.size(), text.c_str()), "nc_put_att_text");
  }

  void put(int variable, const std::vector<double>& numbers) {
    check(nc_put_var_double(id_, variable, numbers.data()), "nc_put_var_double");
  }

  void put(int variable, const std::vector<std::string>& texts) {
    std::vector<const char*> pointers;
    for (const std::string& text : texts) pointers.push_back(text.c_str());
    check(nc_put_var_string(id_, variable, pointers.data()), "nc_put_var_string");
  }

  /// Throws as write_file() does.
  void finish() {
    open_ = false;
    NC_memio image{};
    check(nc_close_memio(id_, &image), "nc_close_memio");
    const std::unique_ptr<void, decltype(&std::free)> bytes(image.memory, &std::free);
    write_file(path_, without_room(image));
  }

 private:
  void check(int code, const char* call) const {
    if (code == NC_NOERR) return;
    throw std::runtime_error(fmt::format("{}: cannot be written: {}: {}", path_.string(), call, nc_strerror(code)));
  }

  std::filesystem::path path_;
  int id_ = 0;
  bool open_ = false;
};

/// A dimension with the names along it.
struct Dimension {
  const char* name;
  std::vector<std::string> names;
};

/// Writes one trajectory: first everything is defined, then filled.
class TrajectoryWriter {
 public:
  TrajectoryWriter(NetcdfFile& file, const Model& model, const Trajectory& trajectory, const Mask* unique)
      : file_(file), model_(model), trajectory_(trajectory), unique_(unique) {}

  void write(std::string_view solver) {
    file_.attribute(NC_GLOBAL, "title", model_.name);
    file_.attribute(NC_GLOBAL, "source", fmt::format("concord {}, solver {}", CONCORD_VERSION, solver));
    define_dimensions();
    define_motion();
    define_joints();
    define_couplings();
    define_elements();
    for (const auto& fill : fills_) fill();
  }

 private:
  using BodyRow = std::function<VecX(const Sample&, std::size_t body)>;
  using JointRow = std::function<VecX(const Sample&, std::size_t joint)>;

  void define_dimensions() {
    time_ = file_.dimension("time", trajectory_.samples.size());
    const int variable = file_.variable("time", NC_DOUBLE, {time_});
    file_.attribute(variable, "units", "s");
    std::vector<double> times;
    for (const Sample& sample : trajectory_.samples) times.push_back(sample.state.t);
    fills_.emplace_back([this, variable, times] { file_.put(variable, times); });

    std::vector<std::string> body_names;
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
      body_names.push_back(model_.bodies[i].name);
      n_modes_ = std::max(n_modes_, model_.bodies[i].n_modes());
    }
    std::vector<std::string> joint_names;
    for (const Joint& joint : model_.joints) {
      joint_names.push_back(joint.name);
      n_q_ = std::max(n_q_, joint.type->n_q());
      n_u_ = std::max(n_u_, joint.type->n_u());
    }
    body_ = named({"body", body_names});
    joint_ = named({"joint", joint_names});
    side_ = named({"side", {kSideNames.begin(), kSideNames.end()}});
    component_ = named({"component", {component_names().begin(), component_names().end()}});
    axis_ = named({"axis", {kAxes.begin(), kAxes.end()}});
    euler_ = named({"euler", {"e0", "e1", "e2", "e3"}});
    if (!model_.elements.empty()) element_ = named({"element", element_names(model_)});
    if (n_modes_ > 0) mode_ = named({"mode", numbered("a", n_modes_)});
    if (n_q_ > 0) coordinate_ = named({"coordinate", numbered("q", n_q_)});
    if (n_u_ > 0) speed_ = named({"speed", numbered("u", n_u_)});
  }

  void define_motion() {
    const auto state = [](const Sample& sample, std::size_t i) -> const BodyState& { return sample.state.bodies[i]; };
    const auto rate = [](const Sample& sample, std::size_t i) -> const BodyAcceleration& {
      return sample.evaluation.bodies[i];
    };
    body("position", "m", "origin of the body frame, global axes", axis_, 3,
         [=](const Sample& sample, std::size_t i) { return state(sample, i).r; });
    body("euler_parameters", "1", "Euler parameters of the rotation from body to global axes, scalar first", euler_, 4,
         [=](const Sample& sample, std::size_t i) { return state(sample, i).p; });
    body("velocity", "m/s", "velocity of the origin of the body frame, global axes", axis_, 3,
         [=](const Sample& sample, std::size_t i) { return state(sample, i).v; });
    body("angular_velocity", "rad/s", "angular velocity, global axes", axis_, 3,
         [=](const Sample& sample, std::size_t i) { return state(sample, i).omega; });
    body("acceleration", "m/s2", "acceleration of the origin of the body frame, global axes", axis_, 3,
         [=](const Sample& sample, std::size_t i) { return rate(sample, i).vdot; });
    body("angular_acceleration", "rad/s2", "angular acceleration, global axes", axis_, 3,
         [=](const Sample& sample, std::size_t i) { return rate(sample, i).omegadot; });
    if (n_modes_ == 0) return;
    body("modal_coordinates", "1", "modal coordinates, in the scaling of the mode shapes", mode_, n_modes_,
         [=](const Sample& sample, std::size_t i) { return state(sample, i).a; });
    body("modal_velocities", "1/s", "rates of the modal coordinates", mode_, n_modes_,
         [=](const Sample& sample, std::size_t i) { return state(sample, i).adot; });
    body("modal_accelerations", "1/s2", "second rates of the modal coordinates", mode_, n_modes_,
         [=](const Sample& sample, std::size_t i) { return rate(sample, i).addot; });
  }

  void define_joints() {
    std::vector<std::string> units;
    for (int c = 0; c < 6; ++c) units.emplace_back(component_unit(c));
    texts("component_units", "units of the components of wrenches", {component_}, units);
    wrench("reaction", "reaction on the side, at its joint point, in its joint frame",
           [](const JointWrenches& wrenches, int side) { return wrenches.reaction[side].in_C; });
    wrench("reaction_global", "reaction on the side, at its joint point, global axes",
           [](const JointWrenches& wrenches, int side) { return wrenches.reaction[side].in_global; });
    wrench("total", "total wrench on the side, drivers included, at its joint point, in its joint frame",
           [](const JointWrenches& wrenches, int side) { return wrenches.total[side].in_C; });
    wrench("total_global", "total wrench on the side, drivers included, at its joint point, global axes",
           [](const JointWrenches& wrenches, int side) { return wrenches.total[side].in_global; });
    define_uniqueness();
    if (n_u_ == 0) return;
    texts("coordinate_units", "units of the joint coordinates", {joint_, coordinate_},
          padded_units(coordinate_units, n_q_));
    texts("speed_units", "units of the joint speeds", {joint_, speed_}, padded_units(speed_units, n_u_));
    texts("driver_force_units", "units of the driver forces", {joint_, speed_}, padded_units(speed_force_units, n_u_));
    joint("joint_coordinates", "see coordinate_units", "joint coordinates, turns counted", coordinate_, n_q_,
          [](const Sample& sample, std::size_t k) { return sample.state.q[k]; });
    joint("joint_speeds", "see speed_units", "joint speeds", speed_, n_u_,
          [](const Sample& sample, std::size_t k) { return sample.state.u[k]; });
    joint("driver_force", "see driver_force_units",
          "force of driver, spring, actuator and couplings on the joint speed", speed_, n_u_,
          [](const Sample& sample, std::size_t k) { return sample.evaluation.joints[k].tau; });
  }

  /// 1 where a reaction component is unique, 0 where it is not: constraints then leave it open.
  void define_uniqueness() {
    if (unique_ == nullptr || model_.joints.empty()) return;
    const int variable = file_.variable("unique", NC_BYTE, {time_, joint_, side_, component_});
    file_.attribute(variable, "long_name", "1 where the component of the reaction is unique, 0 where it is not");
    std::vector<double> flags;
    const QuantityLayout layout(model_);
    for (Eigen::Index sample = 0; sample < unique_->cols(); ++sample) {
      for (int k = 0; k < static_cast<int>(model_.joints.size()); ++k) {
        for (const Side side : kSides) {
          const int first = layout.first_row(Kind::reaction, k, side);
          for (int c = 0; c < 6; ++c) flags.push_back((*unique_)(first + c, sample) ? 1.0 : 0.0);
        }
      }
    }
    fills_.emplace_back([this, variable, flags] { file_.put(variable, flags); });
  }

  void define_couplings() {
    if (model_.couplings.empty()) return;
    std::vector<std::string> names;
    for (const Coupling& coupling : model_.couplings) names.push_back(coupling.name);
    const int variable =
        numbers("coupling_force", "see driver_force_units",
                "force of the coupling; times a term's factor it is its part of the driver force there",
                {time_, named({"coupling", names})});
    const auto one = [](const Sample& sample, std::size_t k) {
      return VecX(VecX::Constant(1, sample.evaluation.couplings[k]));
    };
    fills_.emplace_back([this, variable, one] { fill(variable, 0, model_.couplings.size(), 1, one); });
  }

  void define_elements() {
    if (model_.elements.empty()) return;
    element_wrench("element_wrench", "wrench of the force element on the side, at its end's point, in its end's frame",
                   [](const SideWrench& on) { return on.in_C; });
    element_wrench("element_wrench_global", "wrench of the force element on the side, at its end's point, global axes",
                   [](const SideWrench& on) { return on.in_global; });
  }

  std::vector<std::string> padded_units(std::vector<std::string> (*units_of_type)(const joints::JointType&),
                                        int width) {
    std::vector<std::string> units;
    for (const Joint& one : model_.joints) {
      std::vector<std::string> of_joint = units_of_type(*one.type);
      of_joint.resize(static_cast<std::size_t>(width));
      units.insert(units.end(), of_joint.begin(), of_joint.end());
    }
    return units;
  }

  /// A dimension and its coordinate variable of names.
  int named(const Dimension& dimension) {
    const int id = file_.dimension(dimension.name, dimension.names.size());
    const int variable = file_.variable(dimension.name, NC_STRING, {id});
    fills_.emplace_back([this, variable, names = dimension.names] { file_.put(variable, names); });
    return id;
  }

  void texts(const char* name, const char* long_name, const std::vector<int>& dimensions,
             const std::vector<std::string>& values) {
    const int variable = file_.variable(name, NC_STRING, dimensions);
    file_.attribute(variable, "long_name", long_name);
    fills_.emplace_back([this, variable, values] { file_.put(variable, values); });
  }

  int numbers(const char* name, const char* units, const char* long_name, const std::vector<int>& dimensions) {
    const int variable = file_.variable(name, NC_DOUBLE, dimensions);
    file_.attribute(variable, "units", units);
    file_.attribute(variable, "long_name", long_name);
    return variable;
  }

  void body(const char* name, const char* units, const char* long_name, int last, int width, const BodyRow& row) {
    const int variable = numbers(name, units, long_name, {time_, body_, last});
    fills_.emplace_back([this, variable, width, row] { fill(variable, 1, model_.bodies.size(), width, row); });
  }

  void joint(const char* name, const char* units, const char* long_name, int last, int width, const JointRow& row) {
    const int variable = numbers(name, units, long_name, {time_, joint_, last});
    fills_.emplace_back([this, variable, width, row] { fill(variable, 0, model_.joints.size(), width, row); });
  }

  void wrench(const char* name, const char* long_name, Wrench (*pick)(const JointWrenches&, int)) {
    const int variable = numbers(name, "see component_units", long_name, {time_, joint_, side_, component_});
    const auto both_sides = [pick](const Sample& sample, std::size_t k) {
      VecX sides(12);
      sides << pick(sample.evaluation.joints[k], 0).vector(), pick(sample.evaluation.joints[k], 1).vector();
      return sides;
    };
    fills_.emplace_back([this, variable, both_sides] { fill(variable, 0, model_.joints.size(), 12, both_sides); });
  }

  void element_wrench(const char* name, const char* long_name, Wrench (*pick)(const SideWrench&)) {
    const int variable = numbers(name, "see component_units", long_name, {time_, element_, side_, component_});
    const auto both_sides = [pick](const Sample& sample, std::size_t k) {
      VecX sides(12);
      sides << pick(sample.evaluation.elements[k].on[0]).vector(), pick(sample.evaluation.elements[k].on[1]).vector();
      return sides;
    };
    fills_.emplace_back([this, variable, both_sides] { fill(variable, 0, model_.elements.size(), 12, both_sides); });
  }

  /// Rows of `width` numbers for each time and each body, joint or element, NaN where a row is shorter.
  void fill(int variable, std::size_t first, std::size_t end, int width,
            const std::function<VecX(const Sample&, std::size_t)>& row) {
    std::vector<double> values;
    for (const Sample& sample : trajectory_.samples) {
      for (std::size_t k = first; k < end; ++k) {
        const VecX short_row = row(sample, k);
        values.insert(values.end(), short_row.begin(), short_row.end());
        values.insert(values.end(), static_cast<std::size_t>(width - short_row.size()),
                      std::numeric_limits<double>::quiet_NaN());
      }
    }
    file_.put(variable, values);
  }

  NetcdfFile& file_;
  const Model& model_;
  const Trajectory& trajectory_;
  const Mask* unique_;
  std::vector<std::function<void()>> fills_;
  int n_modes_ = 0;
  int n_q_ = 0;
  int n_u_ = 0;
  int time_ = 0;
  int body_ = 0;
  int joint_ = 0;
  int element_ = 0;
  int side_ = 0;
  int component_ = 0;
  int axis_ = 0;
  int euler_ = 0;
  int mode_ = 0;
  int coordinate_ = 0;
  int speed_ = 0;
};

}  // namespace

void write_netcdf(const std::filesystem::path& path, const Model& model, std::string_view solver,
                  const Trajectory& trajectory, const Mask* unique) {
  const std::lock_guard lock(netcdf_mutex());
  NetcdfFile file(path);
  TrajectoryWriter(file, model, trajectory, unique).write(solver);
  file.finish();
}

}  // namespace concord::compare
