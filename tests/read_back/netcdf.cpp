#include <fmt/format.h>
#include <netcdf.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/read_back/expected.h"

namespace concord::read_back {

namespace {

/// A variable as a file has it, or as it must have it: names of its dimensions, unit, and numbers or texts.
struct Variable {
  std::vector<std::string> dimensions;
  std::string units;
  std::vector<double> numbers;
  std::vector<std::string> texts;
};
using Variables = std::map<std::string, Variable>;

/// All of a file by the C library.
class NetcdfReader {
 public:
  NetcdfReader(const std::filesystem::path& path, Complaints& complaints) : complaints_(complaints) {
    if (check(nc_open(path.c_str(), NC_NOWRITE, &id_), "cannot be opened")) is_open_ = true;
  }
  ~NetcdfReader() {
    if (is_open_) nc_close(id_);
  }
  NetcdfReader(const NetcdfReader&) = delete;
  NetcdfReader& operator=(const NetcdfReader&) = delete;

  Variables variables() {
    Variables all;
    int count = 0;
    if (!is_open_ || !check(nc_inq_nvars(id_, &count), "nc_inq_nvars")) return all;
    for (int one = 0; one < count; ++one) {
      char name[NC_MAX_NAME + 1] = "";
      check(nc_inq_varname(id_, one, name), "nc_inq_varname");
      all[name] = variable(one);
    }
    return all;
  }

  std::string attribute(int variable, const char* name) {
    std::size_t length = 0;
    if (!is_open_ || nc_inq_attlen(id_, variable, name, &length) != NC_NOERR) return "";
    std::string text(length, ' ');
    check(nc_get_att_text(id_, variable, name, text.data()), "nc_get_att_text");
    return text;
  }

 private:
  bool check(int code, const char* what) {
    if (code != NC_NOERR) complaints_.add(fmt::format("{}: {}", what, nc_strerror(code)));
    return code == NC_NOERR;
  }

  Variable variable(int one) {
    Variable found;
    int count = 0;
    int dimensions[NC_MAX_VAR_DIMS];
    nc_type type = NC_NAT;
    check(nc_inq_var(id_, one, nullptr, &type, &count, dimensions, nullptr), "nc_inq_var");
    std::size_t size = 1;
    for (int k = 0; k < count; ++k) {
      char name[NC_MAX_NAME + 1] = "";
      std::size_t length = 0;
      check(nc_inq_dim(id_, dimensions[k], name, &length), "nc_inq_dim");
      found.dimensions.emplace_back(name);
      size *= length;
    }
    found.units = attribute(one, "units");
    if (size == 0) return found;
    if (type != NC_STRING) {
      found.numbers.resize(size);
      check(nc_get_var_double(id_, one, found.numbers.data()), "nc_get_var_double");
      return found;
    }
    std::vector<char*> texts(size);
    if (!check(nc_get_var_string(id_, one, texts.data()), "nc_get_var_string")) return found;
    found.texts.assign(texts.begin(), texts.end());
    nc_free_string(size, texts.data());
    return found;
  }

  Complaints& complaints_;
  int id_ = 0;
  bool is_open_ = false;
};

/// What the file of a run must hold.
class ExpectedVariables {
 public:
  explicit ExpectedVariables(const Expected& expected) : expected_(expected), model_(expected.run().model) {
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) modes_ = std::max(modes_, model_.bodies[i].n_modes());
    for (const Joint& joint : model_.joints) {
      const JointUnits units = units_of(joint);
      coordinates_ = std::max(coordinates_, units.q.size());
      speeds_ = std::max(speeds_, units.u.size());
    }
    add_names();
    add_motion();
    add_joints();
    add_forces();
    if (expected.run().unique != nullptr && !model_.joints.empty()) add_unique();
  }

  Variables all;

 private:
  using Texts = std::vector<std::string>;

  void add_texts(const std::string& name, Texts dimensions, Texts texts) {
    all[name] = {std::move(dimensions), "", {}, std::move(texts)};
  }

  static Texts numbered(const char* letter, std::size_t count) {
    Texts names;
    for (std::size_t k = 1; k <= count; ++k) names.push_back(fmt::format("{}{}", letter, k));
    return names;
  }

  template <class Items>
  static Texts names_of(const Items& items, std::size_t first = 0) {
    Texts names;
    for (std::size_t k = first; k < items.size(); ++k) names.push_back(items[k].name);
    return names;
  }

  void add_names() {
    add_texts("body", {"body"}, names_of(model_.bodies, 1));
    add_texts("joint", {"joint"}, names_of(model_.joints));
    add_texts("side", {"side"}, {"parent", "child"});
    add_texts("component", {"component"}, {kComponents.begin(), kComponents.end()});
    add_texts("axis", {"axis"}, {"x", "y", "z"});
    add_texts("euler", {"euler"}, {"e0", "e1", "e2", "e3"});
    add_texts("component_units", {"component"}, {"N", "N", "N", "N m", "N m", "N m"});
    if (!model_.elements.empty()) add_texts("element", {"element"}, names_of(model_.elements));
    if (!model_.couplings.empty()) add_texts("coupling", {"coupling"}, names_of(model_.couplings));
    if (modes_ > 0) add_texts("mode", {"mode"}, numbered("a", static_cast<std::size_t>(modes_)));
    if (coordinates_ > 0) add_texts("coordinate", {"coordinate"}, numbered("q", coordinates_));
    if (speeds_ > 0) add_texts("speed", {"speed"}, numbered("u", speeds_));
    if (speeds_ == 0) return;
    Texts q;
    Texts u;
    Texts tau;
    for (const Joint& joint : model_.joints) {
      JointUnits units = units_of(joint);
      units.q.resize(coordinates_);
      units.u.resize(speeds_);
      units.tau.resize(speeds_);
      q.insert(q.end(), units.q.begin(), units.q.end());
      u.insert(u.end(), units.u.begin(), units.u.end());
      tau.insert(tau.end(), units.tau.begin(), units.tau.end());
    }
    add_texts("coordinate_units", {"joint", "coordinate"}, std::move(q));
    add_texts("speed_units", {"joint", "speed"}, std::move(u));
    add_texts("force_units", {"joint", "speed"}, std::move(tau));
  }

  /// `number(k, item, place)` for all samples, items and places along the last dimension.
  template <class Number>
  void add(const std::string& name, Texts dimensions, const char* units, std::size_t items, std::size_t width,
           const Number& number) {
    Variable& one = all[name];
    one.dimensions = std::move(dimensions);
    one.units = units;
    for (std::size_t k = 0; k < expected_.samples(); ++k) {
      for (std::size_t item = 0; item < items; ++item) {
        for (std::size_t place = 0; place < width; ++place) one.numbers.push_back(number(k, item, place));
      }
    }
  }

  /// Numbers of a vector, and NaN beyond its end.
  template <class Vector>
  static double at(const Vector& vector, std::size_t place) {
    if (place >= static_cast<std::size_t>(vector.size())) return std::numeric_limits<double>::quiet_NaN();
    return vector(static_cast<Eigen::Index>(place));
  }

  template <class Part>
  void add_body(const std::string& name, const char* last, const char* units, std::size_t width, const Part& part) {
    add(name, {"time", "body", last}, units, model_.bodies.size() - 1, width,
        [&](std::size_t k, std::size_t body, std::size_t place) {
          const Sample& sample = expected_.sample(k);
          return at(part(sample.state.bodies[body + 1], sample.evaluation.bodies[body + 1]), place);
        });
  }

  void add_motion() {
    add("time", {"time"}, "s", 1, 1, [&](std::size_t k, auto, auto) { return expected_.sample(k).state.t; });
    add_body("position", "axis", "m", 3, [](const auto& body, const auto&) { return body.r; });
    add_body("euler_parameters", "euler", "1", 4, [](const auto& body, const auto&) { return body.p; });
    add_body("velocity", "axis", "m/s", 3, [](const auto& body, const auto&) { return body.v; });
    add_body("angular_velocity", "axis", "rad/s", 3, [](const auto& body, const auto&) { return body.omega; });
    add_body("acceleration", "axis", "m/s2", 3, [](const auto&, const auto& rate) { return rate.vdot; });
    add_body("angular_acceleration", "axis", "rad/s2", 3, [](const auto&, const auto& rate) { return rate.omegadot; });
    if (modes_ == 0) return;
    const auto modes = static_cast<std::size_t>(modes_);
    add_body("modal_coordinates", "mode", "1", modes, [](const auto& body, const auto&) { return body.a; });
    add_body("modal_velocities", "mode", "1/s", modes, [](const auto& body, const auto&) { return body.adot; });
    add_body("modal_accelerations", "mode", "1/s2", modes, [](const auto&, const auto& rate) { return rate.addot; });
  }

  /// A variable, and the solver's own numbers beside it if some are not unique.
  template <class Known, class Own>
  void add_known(const std::string& name, const Texts& dimensions, const char* units, std::size_t items,
                 std::size_t width, const Known& known, const Own& own) {
    add(name, dimensions, units, items, width, known);
    add("any_" + name, dimensions, units, items, width, own);
    const std::vector<double>& one = all[name].numbers;
    const std::vector<double>& other = all["any_" + name].numbers;
    if (std::equal(one.begin(), one.end(), other.begin(), other.end(), is_same)) all.erase("any_" + name);
  }

  void add_wrenches(const std::string& name, Which which, Axes axes) {
    add_known(
        name, {"time", "joint", "side", "component"}, "see component_units", model_.joints.size(), 12,
        [=, this](auto k, auto j, auto place) { return expected_.known(which, axes, k, j, place / 6, place % 6); },
        [=, this](auto k, auto j, auto place) { return expected_.own(which, axes, k, j, place / 6, place % 6); });
  }

  void add_joints() {
    add_wrenches("reaction", Which::reaction, Axes::joint);
    add_wrenches("reaction_global", Which::reaction, Axes::global);
    add_wrenches("total", Which::total, Axes::joint);
    add_wrenches("total_global", Which::total, Axes::global);
    if (speeds_ == 0) return;
    const std::size_t joints = model_.joints.size();
    add("joint_coordinates", {"time", "joint", "coordinate"}, "see coordinate_units", joints, coordinates_,
        [&](auto k, auto j, auto place) { return at(expected_.sample(k).state.q[j], place); });
    add("joint_speeds", {"time", "joint", "speed"}, "see speed_units", joints, speeds_,
        [&](auto k, auto j, auto place) { return at(expected_.sample(k).state.u[j], place); });
    const auto own = [&](std::size_t k, std::size_t j, std::size_t place) {
      return at(expected_.sample(k).evaluation.joints[j].tau, place);
    };
    const auto known = [&](std::size_t k, std::size_t j, std::size_t place) {
      const auto count = static_cast<std::size_t>(model_.joints[j].type->n_u());
      return place < count ? expected_.known_tau(k, j, place) : own(k, j, place);
    };
    add_known("coordinate_force", {"time", "joint", "speed"}, "see force_units", joints, speeds_, known, own);
    for (std::size_t actor = 0; actor < kActorNames.size(); ++actor) {
      const auto own_share = [&, actor](std::size_t k, std::size_t j, std::size_t place) {
        return at(expected_.sample(k).evaluation.joints[j].shares[actor], place);
      };
      const auto known_share = [&, actor](std::size_t k, std::size_t j, std::size_t place) {
        const auto count = static_cast<std::size_t>(model_.joints[j].type->n_u());
        return place < count ? expected_.known_share(k, j, place, actor) : own_share(k, j, place);
      };
      add_known(fmt::format("{}_force", kActorNames[actor]), {"time", "joint", "speed"}, "see force_units", joints,
                speeds_, known_share, own_share);
    }
  }

  void add_forces() {
    if (!model_.couplings.empty()) {
      add_known(
          "coupling_force", {"time", "coupling"}, "see force_units", model_.couplings.size(), 1,
          [&](auto k, auto c, auto) { return expected_.known_coupling(k, c); },
          [&](auto k, auto c, auto) { return expected_.sample(k).evaluation.couplings[c]; });
    }
    if (model_.elements.empty()) return;
    const auto add_wrench = [&](const std::string& name, const auto& pick) {
      add(name, {"time", "element", "side", "component"}, "see component_units", model_.elements.size(), 12,
          [&](std::size_t k, std::size_t e, std::size_t place) {
            const Wrench& wrench = pick(expected_.sample(k).evaluation.elements[e].on[place / 6]);
            return place % 6 < 3 ? at(wrench.force, place % 3) : at(wrench.torque, place % 3);
          });
    };
    add_wrench("element_wrench", [](const SideWrench& on) -> const Wrench& { return on.in_C; });
    add_wrench("element_wrench_global", [](const SideWrench& on) -> const Wrench& { return on.in_global; });
  }

  void add_unique() {
    const compare::Mask& unique = *expected_.run().unique;
    add("unique", {"time", "joint", "side", "component"}, "", model_.joints.size(), 12,
        [&](std::size_t k, std::size_t j, std::size_t place) {
          return unique(static_cast<Eigen::Index>(12 * j + place), static_cast<Eigen::Index>(k)) ? 1.0 : 0.0;
        });
  }

  const Expected& expected_;
  const Model& model_;
  int modes_ = 0;
  std::size_t coordinates_ = 0;
  std::size_t speeds_ = 0;
};

/// "slot 3, joint B, child, F_y" in words of the names along the dimensions.
std::string place_of(const Variables& names, const Variable& variable, std::size_t number) {
  std::string place;
  for (auto dimension = variable.dimensions.rbegin(); dimension != variable.dimensions.rend(); ++dimension) {
    const auto along = names.find(*dimension);
    if (along == names.end()) return "";
    const std::size_t length = std::max(along->second.texts.size(), along->second.numbers.size());
    const std::size_t at = number % length;
    number /= length;
    const std::string name =
        *dimension == "time" ? fmt::format("t = {} s", along->second.numbers[at]) : along->second.texts[at];
    place = place.empty() ? name : fmt::format("{}, {}", name, place);
  }
  return place;
}

void compare_variable(const std::string& name, const Variables& all, const Variable& found, Complaints& complaints) {
  const Variable& expected = all.at(name);
  complaints.expect(found.dimensions == expected.dimensions, fmt::format("{}: has other dimensions", name));
  complaints.expect(found.units == expected.units,
                    fmt::format("{}: in '{}', expected '{}'", name, found.units, expected.units));
  complaints.expect(found.texts == expected.texts, fmt::format("{}: other names", name));
  if (found.numbers.size() != expected.numbers.size()) {
    return complaints.add(
        fmt::format("{}: {} numbers, the run has {}", name, found.numbers.size(), expected.numbers.size()));
  }
  for (std::size_t k = 0; k < found.numbers.size(); ++k) {
    if (is_same(found.numbers[k], expected.numbers[k])) continue;
    return complaints.add(fmt::format("{}, {}: {}, the run has {}", name, place_of(all, expected, k), found.numbers[k],
                                      expected.numbers[k]));
  }
}

}  // namespace

std::vector<std::string> unlike_netcdf(const std::filesystem::path& path, const Expected& expected) {
  Complaints complaints(path.filename().string());
  NetcdfReader reader(path, complaints);
  const Variables found = reader.variables();
  const Variables all = ExpectedVariables(expected).all;
  for (const auto& [name, variable] : all) {
    const auto one = found.find(name);
    if (one == found.end()) {
      complaints.add(fmt::format("{}: is missing", name));
    } else {
      compare_variable(name, all, one->second, complaints);
    }
  }
  for (const auto& [name, variable] : found) {
    complaints.expect(all.contains(name), fmt::format("{}: is no variable of the run", name));
  }
  complaints.expect(reader.attribute(NC_GLOBAL, "title") == expected.run().model.name, "title: another model");
  complaints.expect(reader.attribute(NC_GLOBAL, "source").ends_with(", solver " + expected.run().solver),
                    "source: another solver");
  return complaints.all();
}

std::vector<std::string> unlike_run(const std::filesystem::path& folder, const Run& run) {
  const Expected expected(run);
  std::vector<std::string> all = unlike_csv_files(folder, expected);
  const auto netcdf = unlike_netcdf(folder / fmt::format("{}.{}.nc", run.model.name, run.solver), expected);
  all.insert(all.end(), netcdf.begin(), netcdf.end());
  return all;
}

}  // namespace concord::read_back
