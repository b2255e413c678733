#include "compare/report/result_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netcdf.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/joints/catalogue.h"
#include "common/rotation.h"
#include "compare/quantities/observe.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare {
namespace {

namespace fs = std::filesystem;

/// Ground - spherical - flexible arm with two modes - cylindrical - rigid block; every number of the two samples
/// differs.
struct SampleRun {
  Model model;
  Trajectory trajectory;
  double last = 0.0;

  double next() { return last += 0.1234567890123; }
  VecX next(int n) {
    return VecX::NullaryExpr(n, [this] { return next(); });
  }

  SampleRun() {
    model.name = "crank";
    model.bodies.resize(3);
    model.bodies[0].name = "ground";
    model.bodies[1].name = "arm";
    model.bodies[1].modal.emplace().stiffness = MatX::Identity(2, 2);
    model.bodies[2].name = "block, left";
    model.joints.resize(2);
    model.joints[0].name = "A";
    model.joints[0].type = joints::find("spherical");
    model.joints[1].name = "B";
    model.joints[1].type = joints::find("cylindrical");
    for (const double t : {0.0, 0.25, 1.0 / 3.0}) trajectory.samples.push_back(make_sample(t));
  }

  Sample make_sample(double t) {
    Sample sample;
    sample.state.t = t;
    sample.state.bodies.resize(3);
    sample.evaluation.bodies.resize(3);
    for (int body = 1; body < 3; ++body) {
      const int n_modes = body == 1 ? 2 : 0;
      sample.state.bodies[body] = {next(3), next(4), next(3), next(3), next(n_modes), next(n_modes)};
      sample.evaluation.bodies[body] = {next(3), next(3), next(n_modes)};
    }
    sample.state.q = {next(4), next(2)};
    sample.state.u = {next(3), next(2)};
    sample.evaluation.joints.resize(2);
    for (int joint = 0; joint < 2; ++joint) {
      JointWrenches& wrenches = sample.evaluation.joints[joint];
      for (auto* sides : {&wrenches.reaction, &wrenches.total}) {
        for (SideWrench& side : *sides) side = {{next(3), next(3)}, {next(3), next(3)}};
      }
      wrenches.tau = next(joint == 0 ? 3 : 2);
      for (VecX& share : wrenches.shares) share = next(joint == 0 ? 3 : 2);
    }
    return sample;
  }
};

/// Reads with the C library and nothing of ours.
class Reader {
 public:
  explicit Reader(const fs::path& path) { EXPECT_EQ(nc_open(path.c_str(), NC_NOWRITE, &id_), NC_NOERR); }
  ~Reader() { nc_close(id_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  int variable(const char* name) const {
    int variable = -1;
    EXPECT_EQ(nc_inq_varid(id_, name, &variable), NC_NOERR) << name;
    return variable;
  }
  bool has(const char* name) const {
    int variable = -1;
    return nc_inq_varid(id_, name, &variable) == NC_NOERR;
  }
  std::vector<std::string> dimensions(const char* name) const {
    int count = 0;
    int ids[NC_MAX_VAR_DIMS];
    EXPECT_EQ(nc_inq_varndims(id_, variable(name), &count), NC_NOERR);
    EXPECT_EQ(nc_inq_vardimid(id_, variable(name), ids), NC_NOERR);
    std::vector<std::string> names;
    for (int k = 0; k < count; ++k) {
      char text[NC_MAX_NAME + 1];
      EXPECT_EQ(nc_inq_dimname(id_, ids[k], text), NC_NOERR);
      names.emplace_back(text);
    }
    return names;
  }
  std::size_t size(const char* name) const {
    std::size_t product = 1;
    for (const std::string& dimension : dimensions(name)) {
      int dimension_id = 0;
      std::size_t length = 0;
      EXPECT_EQ(nc_inq_dimid(id_, dimension.c_str(), &dimension_id), NC_NOERR);
      EXPECT_EQ(nc_inq_dimlen(id_, dimension_id, &length), NC_NOERR);
      product *= length;
    }
    return product;
  }
  std::vector<double> numbers(const char* name) const {
    std::vector<double> values(size(name));
    EXPECT_EQ(nc_get_var_double(id_, variable(name), values.data()), NC_NOERR);
    return values;
  }
  std::vector<std::string> texts(const char* name) const {
    std::vector<char*> pointers(size(name));
    EXPECT_EQ(nc_get_var_string(id_, variable(name), pointers.data()), NC_NOERR);
    std::vector<std::string> values(pointers.begin(), pointers.end());
    EXPECT_EQ(nc_free_string(pointers.size(), pointers.data()), NC_NOERR);
    return values;
  }
  std::string attribute(const char* name, const char* attribute) const {
    const int of = name == nullptr ? NC_GLOBAL : variable(name);
    std::size_t length = 0;
    EXPECT_EQ(nc_inq_attlen(id_, of, attribute, &length), NC_NOERR);
    std::string text(length, ' ');
    EXPECT_EQ(nc_get_att_text(id_, of, attribute, text.data()), NC_NOERR);
    return text;
  }

 private:
  int id_ = 0;
};

using ::testing::ElementsAre;

/// All is unique but, in the middle sample, the reaction along y on the parent of A, the total about x on the child of
/// B and, throughout, the force of B's driver on its second speed, which turns.
struct OpenRun : SampleRun {
  QuantityLayout layout;
  Mask unique;

  OpenRun() : layout(with_driver()), unique(Mask::Constant(rows(), 3, true)) {
    unique(layout.row_of({Kind::reaction, 0, Side::parent, 1}), 1) = false;
    unique(layout.row_of({Kind::total, 1, Side::child, 3}), 1) = false;
    unique.row(layout.row_of({Kind::tau, 1, Side::child, 1})) = false;
    // A cylindrical joint carries no force along its axis: a flag that says otherwise is round-off.
    unique(layout.row_of({Kind::reaction, 1, Side::child, 2}), 0) = false;
  }

 private:
  const Model& with_driver() {
    model.joints[1].drivers.push_back({.word = 1});
    // From the joint's frame to global axes: a quarter turn about y on ground's side of A, so that y is y.
    model.joints[0].sides[0] = {kGround, Vec3::Zero(), rotation_about(Vec3::UnitY(), 0.5)};
    model.joints[0].sides[1].body = model.joints[1].sides[0].body = 1;
    model.joints[1].sides[1].body = 2;
    for (Sample& sample : trajectory.samples) {
      for (int body = 1; body < 3; ++body) sample.state.bodies[body].p.normalize();
    }
    return model;
  }
  [[nodiscard]] Eigen::Index rows() const { return static_cast<Eigen::Index>(layout.quantities().size()); }
};

TEST(Netcdf, HoldsNaNWhereANumberIsNotUniqueAndTheSolversOwnBeside) {
  const OpenRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "crank.nc";
  write_netcdf(path, run.model, "relative", run.trajectory, &run.unique);
  const Reader file(path);
  const auto open_places = [&](const char* name) {
    std::vector<std::size_t> places;
    const std::vector<double> numbers = file.numbers(name);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (std::isnan(numbers[k])) places.push_back(k);
    }
    return places;
  };
  // Sample 1, joint A, parent, F_y; the joint's y is the world's.
  EXPECT_THAT(open_places("reaction"), ElementsAre(24 + 1));
  EXPECT_THAT(open_places("reaction_global"), ElementsAre(24 + 1));
  // Sample 1, joint B, child, T_x; its x lies anyhow in the world.
  EXPECT_THAT(open_places("total"), ElementsAre(24 + 18 + 3));
  EXPECT_THAT(open_places("total_global"), ElementsAre(24 + 18 + 3, 24 + 18 + 4, 24 + 18 + 5));
  // Joint B, second speed; its third is padding.
  EXPECT_THAT(open_places("coordinate_force"), ElementsAre(4, 5, 10, 11, 16, 17));
  EXPECT_THAT(open_places("any_coordinate_force"), ElementsAre(5, 11, 17));
  const std::vector<double> known = file.numbers("reaction");
  const std::vector<double> own = file.numbers("any_reaction");
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (k != 25) EXPECT_EQ(own[k], known[k]) << k;
  }
  EXPECT_EQ(own[25], run.trajectory.samples[1].evaluation.joints[0].reaction[0].in_C.force.y());
  EXPECT_THAT(file.dimensions("any_total"), ElementsAre("time", "joint", "side", "component"));
  EXPECT_THAT(file.attribute("any_reaction", "long_name"),
              ::testing::EndsWith("; the solver's own, also where it is not unique"));
}

TEST(Netcdf, HasNoVariablesOfItsOwnWhereAllIsUnique) {
  OpenRun run;
  run.unique.setConstant(true);
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "crank.nc";
  write_netcdf(path, run.model, "relative", run.trajectory, &run.unique);
  const Reader file(path);
  for (const char* name :
       {"any_reaction", "any_reaction_global", "any_total", "any_total_global", "any_coordinate_force"}) {
    EXPECT_FALSE(file.has(name)) << name;
  }
}

TEST(Netcdf, NamesItsDimensions) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "new" / "crank.nc";
  write_netcdf(path, run.model, "relative", run.trajectory);
  const Reader file(path);
  EXPECT_THAT(file.dimensions("reaction"), ElementsAre("time", "joint", "side", "component"));
  EXPECT_THAT(file.dimensions("position"), ElementsAre("time", "body", "axis"));
  EXPECT_THAT(file.dimensions("modal_coordinates"), ElementsAre("time", "body", "mode"));
  EXPECT_THAT(file.texts("body"), ElementsAre("arm", "block, left"));
  EXPECT_THAT(file.texts("joint"), ElementsAre("A", "B"));
  EXPECT_THAT(file.texts("side"), ElementsAre("parent", "child"));
  EXPECT_THAT(file.texts("component"), ElementsAre("F_x", "F_y", "F_z", "T_x", "T_y", "T_z"));
  EXPECT_THAT(file.texts("euler"), ElementsAre("e0", "e1", "e2", "e3"));
  EXPECT_THAT(file.texts("mode"), ElementsAre("a1", "a2"));
  EXPECT_THAT(file.numbers("time"), ElementsAre(0.0, 0.25, 1.0 / 3.0));
}

TEST(Netcdf, SaysUnitsAndSource) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "crank.nc";
  write_netcdf(path, run.model, "relative", run.trajectory);
  const Reader file(path);
  EXPECT_EQ(file.attribute("time", "units"), "s");
  EXPECT_EQ(file.attribute("angular_velocity", "units"), "rad/s");
  EXPECT_EQ(file.attribute("acceleration", "units"), "m/s2");
  EXPECT_EQ(file.attribute("reaction", "long_name"), "reaction on the side, at its joint point, in its joint frame");
  EXPECT_THAT(file.texts("component_units"), ElementsAre("N", "N", "N", "N m", "N m", "N m"));
  EXPECT_THAT(file.texts("coordinate_units"), ElementsAre("1", "1", "1", "1", "m", "rad", "", ""));
  EXPECT_THAT(file.texts("speed_units"), ElementsAre("rad/s", "rad/s", "rad/s", "m/s", "rad/s", ""));
  EXPECT_THAT(file.texts("force_units"), ElementsAre("N m", "N m", "N m", "N", "N m", ""));
  EXPECT_EQ(file.attribute(nullptr, "title"), "crank");
  EXPECT_THAT(file.attribute(nullptr, "source"), ::testing::EndsWith(", solver relative"));
}

TEST(Netcdf, HoldsEveryNumberExactly) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "crank.nc";
  write_netcdf(path, run.model, "cartesian", run.trajectory);
  const Reader file(path);
  // Time 1, body "block, left".
  const Sample& sample = run.trajectory.samples[1];
  const std::size_t row = 1 * 2 + 1;
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(file.numbers("position")[3 * row + k], sample.state.bodies[2].r(k));
    EXPECT_EQ(file.numbers("velocity")[3 * row + k], sample.state.bodies[2].v(k));
    EXPECT_EQ(file.numbers("angular_velocity")[3 * row + k], sample.state.bodies[2].omega(k));
    EXPECT_EQ(file.numbers("acceleration")[3 * row + k], sample.evaluation.bodies[2].vdot(k));
    EXPECT_EQ(file.numbers("angular_acceleration")[3 * row + k], sample.evaluation.bodies[2].omegadot(k));
  }
  for (int k = 0; k < 4; ++k) EXPECT_EQ(file.numbers("euler_parameters")[4 * row + k], sample.state.bodies[2].p(k));
  // Joint B.
  const JointWrenches& wrenches = sample.evaluation.joints[1];
  for (int side = 0; side < 2; ++side) {
    for (int c = 0; c < 6; ++c) {
      const std::size_t place = (2 * row + side) * 6 + c;
      EXPECT_EQ(file.numbers("reaction")[place], wrenches.reaction[side].in_C.vector()(c));
      EXPECT_EQ(file.numbers("reaction_global")[place], wrenches.reaction[side].in_global.vector()(c));
      EXPECT_EQ(file.numbers("total")[place], wrenches.total[side].in_C.vector()(c));
      EXPECT_EQ(file.numbers("total_global")[place], wrenches.total[side].in_global.vector()(c));
    }
  }
  EXPECT_EQ(file.numbers("joint_coordinates")[4 * row + 1], sample.state.q[1](1));
  EXPECT_EQ(file.numbers("joint_speeds")[3 * row + 1], sample.state.u[1](1));
  EXPECT_EQ(file.numbers("coordinate_force")[3 * row], wrenches.tau(0));
  EXPECT_EQ(file.numbers("modal_coordinates")[2 * 2 * 1 + 1], sample.state.bodies[1].a(1));
  EXPECT_EQ(file.numbers("modal_accelerations")[2 * 2 * 1 + 1], sample.evaluation.bodies[1].addot(1));
}

TEST(Netcdf, PadsWithNaN) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "crank.nc";
  write_netcdf(path, run.model, "cartesian", run.trajectory);
  const Reader file(path);
  EXPECT_TRUE(std::isnan(file.numbers("modal_coordinates")[2]));
  EXPECT_TRUE(std::isnan(file.numbers("joint_coordinates")[4 + 2]));
  EXPECT_FALSE(std::isnan(file.numbers("joint_coordinates")[4 + 1]));
  EXPECT_TRUE(std::isnan(file.numbers("coordinate_force")[3 + 2]));
}

TEST(Netcdf, LeavesOutWhatAModelHasNot) {
  SampleRun run;
  run.model.bodies[1].modal.reset();
  for (Joint& joint : run.model.joints) joint.type = joints::find("weld");
  for (Sample& sample : run.trajectory.samples) {
    sample.state.bodies[1].a = sample.state.bodies[1].adot = sample.evaluation.bodies[1].addot = VecX(0);
    sample.state.q = sample.state.u = {VecX(0), VecX(0)};
    for (JointWrenches& wrenches : sample.evaluation.joints) {
      wrenches.tau = VecX(0);
      wrenches.shares.fill(VecX(0));
    }
  }
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "crank.nc";
  write_netcdf(path, run.model, "cartesian", run.trajectory);
  const Reader file(path);
  EXPECT_FALSE(file.has("modal_coordinates"));
  EXPECT_FALSE(file.has("joint_coordinates"));
  EXPECT_TRUE(file.has("reaction"));
}

TEST(Netcdf, IsTheSameBytesAtAnyTime) {
  const SampleRun run;
  const TemporaryFolder folder;
  write_netcdf(folder.path() / "one.nc", run.model, "cartesian", run.trajectory);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_netcdf(folder.path() / "two.nc", run.model, "cartesian", run.trajectory);
  EXPECT_EQ(bytes_of(folder.path() / "one.nc"), bytes_of(folder.path() / "two.nc"));
  EXPECT_GT(fs::file_size(folder.path() / "one.nc"), 1000U);
}

TEST(Netcdf, LeavesNothingUnfinished) {
  const SampleRun run;
  const TemporaryFolder folder;
  write_netcdf(folder.path() / "crank.nc", run.model, "cartesian", run.trajectory);
  EXPECT_EQ(folder.count(), 1);
}

TEST(Netcdf, SaysThatThePlaceCannotBeWritten) {
  const SampleRun run;
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "crank.nc");
  std::ofstream(folder.path() / "crank.nc" / "in the way") << "x";
  try {
    write_netcdf(folder.path() / "crank.nc", run.model, "cartesian", run.trajectory);
    FAIL() << "no complaint";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("crank.nc: error: cannot be written"));
  }
  EXPECT_EQ(folder.count(), 1);
}

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::vector<double> numbers_of(const std::string& line) {
  std::istringstream text(line);
  std::vector<double> numbers;
  for (std::string field; std::getline(text, field, ',');) numbers.push_back(std::stod(field));
  return numbers;
}

TEST(Csv, OfMotionNamesItsColumnsWithUnits) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "motion.csv";
  write_motion_csv(path, run.model, run.trajectory);
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_THAT(lines[0],
              ::testing::StartsWith("t [s],arm.x [m],arm.y [m],arm.z [m],arm.e0 [1],arm.e1 [1],arm.e2 [1],"
                                    "arm.e3 [1],arm.v_x [m/s],arm.v_y [m/s],arm.v_z [m/s],arm.omega_x [rad/s]"));
  EXPECT_THAT(lines[0], ::testing::HasSubstr(",arm.a_1 [1],arm.a_2 [1],arm.adot_1 [1/s],"));
  EXPECT_THAT(lines[0], ::testing::HasSubstr(",\"block, left.x [m]\","));
  EXPECT_THAT(lines[0], ::testing::EndsWith(",A.q_1 [1],A.q_2 [1],A.q_3 [1],A.q_4 [1],B.q_1 [m],B.q_2 [rad]"));
}

TEST(Csv, OfMotionReadsBackExactly) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "motion.csv";
  write_motion_csv(path, run.model, run.trajectory);
  const auto row = numbers_of(lines_of(path)[3]);
  ASSERT_EQ(row.size(), 1U + (19 + 6) + 19 + 6);
  const Sample& sample = run.trajectory.samples[2];
  EXPECT_EQ(row[0], 1.0 / 3.0);
  EXPECT_EQ(row[1], sample.state.bodies[1].r.x());
  EXPECT_EQ(row[4], sample.state.bodies[1].p(0));
  EXPECT_EQ(row[26], sample.state.bodies[2].r.x());
  EXPECT_EQ(row.back(), sample.state.q[1](1));
}

TEST(Csv, OfReactionsNamesSideAndComponent) {
  const SampleRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "reactions.csv";
  write_reaction_csv(path, run.model, run.trajectory);
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_THAT(lines[0], ::testing::StartsWith("t [s],A.parent.F_x [N],A.parent.F_y [N]"));
  EXPECT_THAT(lines[0], ::testing::HasSubstr(",A.child.T_z [N m],A.tau_1 [N m],"));
  EXPECT_THAT(lines[0], ::testing::EndsWith(",B.tau_1 [N],B.tau_2 [N m]"));
  const auto row = numbers_of(lines[2]);
  const auto& joints = run.trajectory.samples[1].evaluation.joints;
  ASSERT_EQ(row.size(), 1U + 15 + 14);
  EXPECT_EQ(row[7], joints[0].reaction[1].in_C.force.x());
  EXPECT_EQ(row[16 + 5], joints[1].reaction[0].in_C.torque.z());
  EXPECT_EQ(row[13], joints[0].tau(0));
}

TEST(Csv, OfReactionsHoldsNaNWhereANumberIsNotUniqueAndTheSolversOwnBehindAllOthers) {
  const OpenRun run;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "reactions.csv";
  write_reaction_csv(path, run.model, run.trajectory, &run.unique);
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 7U);
  EXPECT_EQ(lines[0], "# not unique in 1 of 3 samples: A.parent.F_y");
  EXPECT_EQ(lines[1], "# not unique in 3 of 3 samples: B.tau_2, B.driver_2");
  EXPECT_EQ(lines[2], "# there nan stands, and in the column any_... the solver's own value, one of many");
  EXPECT_THAT(lines[3], ::testing::EndsWith(",B.tau_2 [N m],B.driver_2 [N m],any_A.parent.F_y [N],any_B.tau_2 [N m],"
                                            "any_B.driver_2 [N m]"));
  for (int k = 0; k < 3; ++k) {
    const auto row = numbers_of(lines[static_cast<std::size_t>(4 + k)]);
    const auto& joints = run.trajectory.samples[static_cast<std::size_t>(k)].evaluation.joints;
    ASSERT_EQ(row.size(), 1U + 15 + 15 + 3);
    EXPECT_EQ(std::isnan(row[2]), k == 1);
    EXPECT_EQ(row[31], joints[0].reaction[0].in_C.force.y());
    EXPECT_TRUE(std::isnan(row[29]));
    EXPECT_TRUE(std::isnan(row[30]));
    EXPECT_EQ(row[32], joints[1].tau(1));
    EXPECT_EQ(row[33], joints[1].share_of(Actor::driver)(1));
    EXPECT_EQ(std::count_if(row.begin(), row.end(), [](double number) { return std::isnan(number); }), k == 1 ? 3 : 2);
  }
}

}  // namespace
}  // namespace concord::compare
