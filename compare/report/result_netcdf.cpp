#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compare/quantities/columns.h"
#include "compare/quantities/observe.h"
#include "compare/report/netcdf_file.h"
#include "compare/report/result_files.h"
#include "compare/report/told_axes.h"
#include "compare/resolution/unique_part.h"

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

/// A dimension with the names along it.
struct Dimension {
  const char* name;
  std::vector<std::string> names;
};

/// Writes one trajectory: first everything is defined, then filled.
class TrajectoryWriter {
 public:
  TrajectoryWriter(NetcdfFile& file, const Model& model, const Trajectory& trajectory, const Mask* unique,
                   std::optional<int> axes)
      : file_(file), model_(model), trajectory_(trajectory), unique_(unique), axes_(axes) {
    if (unique != nullptr) known_ = unique_part(model, trajectory, *unique);
  }

  void write(std::string_view solver) {
    file_.attribute(NC_GLOBAL, "title", model_.name);
    file_.attribute(NC_GLOBAL, "source", fmt::format("concord {}, solver {}", CONCORD_VERSION, solver));
    define_dimensions();
    define_motion();
    define_joints();
    define_couplings();
    define_elements();
    if (axes_ && *axes_ != 0) define_told();
    for (const auto& fill : fills_) fill();
  }

 private:
  /// The numbers of one body, joint, coupling or force element in a sample.
  using Row = std::function<VecX(const Sample&, std::size_t)>;

  /// What a variable holds: rows of `width` numbers for each time and each item from `first` to before `end`.
  struct Rows {
    std::size_t first;
    std::size_t end;
    int width;
    Row of;
  };

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
    texts("force_units", "units of the forces on joint speeds", {joint_, speed_},
          padded_units(speed_force_units, n_u_));
    joint("joint_coordinates", "see coordinate_units", "joint coordinates, turns counted", coordinate_, n_q_,
          [](const Sample& sample, std::size_t k) { return sample.state.q[k]; });
    joint("joint_speeds", "see speed_units", "joint speeds", speed_, n_u_,
          [](const Sample& sample, std::size_t k) { return sample.state.u[k]; });
    joint("coordinate_force", "see force_units",
          "force on the joint speed, of driver, motor, spring, damper and couplings together", speed_, n_u_,
          [](const Sample& sample, std::size_t k) { return sample.evaluation.joints[k].tau; });
    for (const Actor actor : kActors) {
      joint(fmt::format("{}_force", compare::name_of(actor)).c_str(), "see force_units",
            fmt::format("force of the {} on the joint speed", compare::name_of(actor)).c_str(), speed_, n_u_,
            [actor](const Sample& sample, std::size_t k) { return sample.evaluation.joints[k].share_of(actor); });
    }
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
    const auto one = [](const Sample& sample, std::size_t k) {
      return VecX(VecX::Constant(1, sample.evaluation.couplings[k]));
    };
    numbers("coupling_force", "see force_units",
            "force of the coupling; times a term's factor it is its part of the coordinate force there",
            {time_, named({"coupling", names})}, {0, model_.couplings.size(), 1, one});
  }

  void define_elements() {
    if (model_.elements.empty()) return;
    element_wrench("element_wrench", "wrench of the force element on the side, at its end's point, in its end's frame",
                   [](const SideWrench& on) { return on.in_C; });
    element_wrench("element_wrench_global", "wrench of the force element on the side, at its end's point, global axes",
                   [](const SideWrench& on) { return on.in_global; });
  }

  /// Wrenches in the axes of a body.
  void define_told() {
    const std::string where = "in " + words_of(model_, axes_);
    numbers("reaction_told", "see component_units", "reaction on the side, at its joint point, " + where,
            {time_, joint_, side_, component_},
            {0, model_.joints.size(), 12, [this](const Sample& sample, std::size_t k) {
               VecX sides(12);
               for (const Side side : kSides) {
                 const Wrench& in_C = sample.evaluation.joints[k].reaction_on(side).in_C;
                 sides.segment<6>(6 * index(side)) =
                     told_wrench(model_.joints[k].on(side), sample.state, in_C, *axes_).vector();
               }
               return sides;
             }});
    if (model_.elements.empty()) return;
    numbers("element_wrench_told", "see component_units",
            "wrench of the force element on the side, at its end's point, " + where,
            {time_, element_, side_, component_},
            {0, model_.elements.size(), 12, [this](const Sample& sample, std::size_t k) {
               VecX sides = VecX::Zero(12);
               for (const Side side : kSides) {
                 const Attachment* end = end_of(model_.elements[k], side);
                 if (end == nullptr) continue;
                 const Wrench& in_C = sample.evaluation.elements[k].on_side(side).in_C;
                 sides.segment<6>(6 * index(side)) = told_wrench(*end, sample.state, in_C, *axes_).vector();
               }
               return sides;
             }});
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

  /// A variable of the run, NaN where it is not unique, and any_NAME of the solver's own values if that is anywhere.
  void numbers(const std::string& name, const char* units, const std::string& long_name,
               const std::vector<int>& dimensions, const Rows& rows) {
    const Trajectory& known = known_ ? *known_ : trajectory_;
    add_numbers(name, units, long_name, dimensions, rows, known);
    if (!known_ || !has_open(rows)) return;
    add_numbers("any_" + name, units, long_name + "; the solver's own, also where it is not unique", dimensions, rows,
                trajectory_);
  }

  void add_numbers(const std::string& name, const char* units, const std::string& long_name,
                   const std::vector<int>& dimensions, const Rows& rows, const Trajectory& from) {
    const int variable = file_.variable(name.c_str(), NC_DOUBLE, dimensions);
    file_.attribute(variable, "units", units);
    file_.attribute(variable, "long_name", long_name);
    fills_.emplace_back([this, variable, rows, &from] { file_.put(variable, values_of(rows, from)); });
  }

  void body(const char* name, const char* units, const char* long_name, int last, int width, const Row& row) {
    numbers(name, units, long_name, {time_, body_, last}, {1, model_.bodies.size(), width, row});
  }

  void joint(const char* name, const char* units, const char* long_name, int last, int width, const Row& row) {
    numbers(name, units, long_name, {time_, joint_, last}, {0, model_.joints.size(), width, row});
  }

  void wrench(const char* name, const char* long_name, Wrench (*pick)(const JointWrenches&, int)) {
    const auto both_sides = [pick](const Sample& sample, std::size_t k) {
      VecX sides(12);
      sides << pick(sample.evaluation.joints[k], 0).vector(), pick(sample.evaluation.joints[k], 1).vector();
      return sides;
    };
    numbers(name, "see component_units", long_name, {time_, joint_, side_, component_},
            {0, model_.joints.size(), 12, both_sides});
  }

  void element_wrench(const char* name, const char* long_name, Wrench (*pick)(const SideWrench&)) {
    const auto both_sides = [pick](const Sample& sample, std::size_t k) {
      VecX sides(12);
      sides << pick(sample.evaluation.elements[k].on[0]).vector(), pick(sample.evaluation.elements[k].on[1]).vector();
      return sides;
    };
    numbers(name, "see component_units", long_name, {time_, element_, side_, component_},
            {0, model_.elements.size(), 12, both_sides});
  }

  /// NaN where a row is shorter than others.
  [[nodiscard]] static std::vector<double> values_of(const Rows& rows, const Trajectory& from) {
    std::vector<double> values;
    for (const Sample& sample : from.samples) {
      for (std::size_t k = rows.first; k < rows.end; ++k) {
        const VecX short_row = rows.of(sample, k);
        values.insert(values.end(), short_row.begin(), short_row.end());
        values.insert(values.end(), static_cast<std::size_t>(rows.width - short_row.size()),
                      std::numeric_limits<double>::quiet_NaN());
      }
    }
    return values;
  }

  /// Whether any of the numbers is not unique.
  [[nodiscard]] bool has_open(const Rows& rows) const {
    const auto count = [&](const Trajectory& run) {
      const std::vector<double> values = values_of(rows, run);
      return std::count_if(values.begin(), values.end(), [](double value) { return std::isnan(value); });
    };
    return count(*known_) > count(trajectory_);
  }

  NetcdfFile& file_;
  const Model& model_;
  const Trajectory& trajectory_;
  const Mask* unique_;
  std::optional<int> axes_;
  std::optional<Trajectory> known_;  // where something is not unique
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
                  const Trajectory& trajectory, const Mask* unique, std::optional<int> axes) {
  const std::lock_guard lock(netcdf_mutex());
  NetcdfFile file(path);
  TrajectoryWriter(file, model, trajectory, unique, axes).write(solver);
  file.finish();
}

}  // namespace concord::compare
