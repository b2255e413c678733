#include "compare/random_machines/generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "common/error.h"
#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"
#include "compare/audit/referee.h"
#include "compare/random_machines/coverage.h"
#include "compare/random_machines/elements.h"
#include "compare/random_machines/placing.h"
#include "compare/random_machines/writer.h"

using namespace concord;
using namespace concord::compare::fuzz;

namespace {

constexpr std::uint64_t kTestSeed = 20260117;
constexpr int kMachines = 300;

Model read(const ModelText& text) {
  const std::filesystem::path folder = testing::TempDir();
  for (const auto& [name, content] : text.beside) std::ofstream(folder / name) << content;
  return parse_model(text.model, folder / "machine.toml");
}

/// Largest distance and turn between where the child's frame of a joint is and where its coordinates say that it is.
double gap_of(const Machine& machine, const JointPlan& joint) {
  const std::vector<Pose> poses = poses_of(machine);
  const auto frame = [&](const End& end) {
    const Pose& body = poses[end.body];
    return Pose{body.r + body.A * end.point, body.A * rotation_of(end.p)};
  };
  const Pose parent = frame(joint.ends[0]);
  const Pose child = frame(joint.ends[1]);
  const auto motion = compare::referee_permits(joint.own_type(), joint.q, joint.u);
  const Vec3 d = parent.A.transpose() * (child.r - parent.r) - motion.placement.d;
  const Mat3 R = parent.A.transpose() * child.A - motion.placement.R;
  return std::max(d.lpNorm<Eigen::Infinity>() / machine.length, R.lpNorm<Eigen::Infinity>());
}

}  // namespace

TEST(Generator, SameSeedAndNumberGiveTheSameText) {
  for (std::uint64_t number = 0; number < 40; ++number) {
    const std::string text = pack(write_machine(draw_machine(kTestSeed, number, Style::mixed)));
    EXPECT_EQ(text, pack(write_machine(draw_machine(kTestSeed, number, Style::mixed)))) << number;
    EXPECT_NE(text, pack(write_machine(draw_machine(kTestSeed + 1, number, Style::mixed)))) << number;
  }
}

TEST(Generator, EveryMachineIsReadWithoutComplaint) {
  for (std::uint64_t number = 0; number < kMachines; ++number) {
    const Machine machine = draw_machine(kTestSeed, number, Style::mixed);
    try {
      const Model model = read(write_machine(machine));
      EXPECT_EQ(model.bodies.size(), machine.bodies.size());
      EXPECT_EQ(model.joints.size(), machine.joints.size());
      EXPECT_EQ(model.elements.size(), machine.elements.size());
      EXPECT_EQ(model.couplings.size(), machine.couplings.size());
    } catch (const InputError& error) {
      ADD_FAILURE() << "machine " << number << ": " << error.what();
    }
  }
}

TEST(Generator, EveryJointIsClosedAtTheStart) {
  int loops = 0;
  for (std::uint64_t number = 0; number < kMachines; ++number) {
    const Machine machine = draw_machine(kTestSeed, number, Style::mixed);
    for (const JointPlan& joint : machine.joints) {
      EXPECT_LT(gap_of(machine, joint), 1e-13) << number << ' ' << joint.name;
      loops += joint.closes_loop ? 1 : 0;
    }
  }
  EXPECT_GT(loops, kMachines / 5);
}

TEST(Generator, WholeVocabularyAndAllElementsOccurInEveryRoleAmongThreeHundred) {
  Coverage coverage;
  for (std::uint64_t number = 0; number < kMachines; ++number) {
    coverage.add(draw_machine(kTestSeed, number, Style::mixed));
  }
  for (const joints::JointType* type : joints::catalogue()) {
    for (const char* role : {"tree", "reversed", "cut"}) {
      EXPECT_GT(coverage.count(role, type->name), 0) << type->name << ' ' << role;
    }
    const bool has_scalar = std::any_of(type->permits.begin(), type->permits.end(), [](const joints::Permit& word) {
      return n_q(word) > 0 && !std::holds_alternative<joints::Ball>(word);
    });
    if (!has_scalar) continue;
    EXPECT_GT(coverage.count("sprung", type->name), 0) << type->name;
    // With a slide of a rolling ball driven, a part of the ball's speed is left free: whole words cannot say that.
    const bool is_rolling = type->nonholonomic_rows() > 0 && type->n_q() > type->n_u();
    EXPECT_TRUE(is_rolling || coverage.count("driven", type->name) > 0) << type->name;
  }
  for (const std::string_view table : element_keys()) {
    EXPECT_GT(coverage.count("elements", std::string(table)), 0) << table;
  }
  for (const char* kind : {"rigid", "beam", "modes file"}) EXPECT_GT(coverage.count("bodies", kind), 0) << kind;
}

TEST(Generator, StylesGiveWhatTheyAreCalledAfter) {
  int with_loop = 0;
  int with_modes = 0;
  int redundant = 0;
  double least = 1e300;
  double greatest = 0.0;
  for (std::uint64_t number = 0; number < 60; ++number) {
    const Machine loops = draw_machine(kTestSeed, number, Style::loops);
    with_loop += loops.joints.size() >= loops.bodies.size() ? 1 : 0;
    const Machine flexible = draw_machine(kTestSeed, number, Style::flexible);
    with_modes += std::any_of(flexible.bodies.begin(), flexible.bodies.end(),
                              [](const BodyPlan& body) { return body.flexible.has_value(); })
                      ? 1
                      : 0;
    const Machine twice = draw_machine(kTestSeed, number, Style::redundant);
    redundant += twice.is_redundant && twice.joints.size() >= twice.bodies.size() ? 1 : 0;
    const Machine wide = draw_machine(kTestSeed, number, Style::wide);
    least = std::min(least, wide.length);
    greatest = std::max(greatest, wide.length);
  }
  EXPECT_GT(with_loop, 50);
  EXPECT_GT(with_modes, 40);
  EXPECT_GT(redundant, 15);
  EXPECT_GT(greatest / least, 1e4);
}

/// Principal moments of inertia, the least over the greatest.
double slenderness(const BodyPlan& body) {
  Mat3 I;
  I << body.inertia(0), body.inertia(3), body.inertia(4), body.inertia(3), body.inertia(1), body.inertia(5),
      body.inertia(4), body.inertia(5), body.inertia(2);
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(I, Eigen::EigenvaluesOnly);
  return principal.eigenvalues()(0) / principal.eigenvalues()(2);
}

TEST(Generator, StiffMachinesHaveThinRodsOrStrongDampers) {
  int rods = 0;
  double strongest = 0.0;  // damping, by the rate at which it stops the heaviest body, in runs
  double stiffest = 0.0;   // stiffness, by what brings the heaviest body to and fro in a run
  for (std::uint64_t number = 0; number < 60; ++number) {
    const Machine machine = draw_machine(kTestSeed, number, Style::stiff);
    double heaviest = 0.0;
    for (std::size_t i = 1; i < machine.bodies.size(); ++i) {
      rods += slenderness(machine.bodies[i]) < 1e-3 ? 1 : 0;
      heaviest = std::max(heaviest, machine.bodies[i].mass);
    }
    for (const ElementPlan& element : machine.elements) {
      if (element.table != "line_spring") continue;
      for (const Entry& entry : element.entries) {
        const bool is_stiffness = entry.key == "stiffness";
        if (!is_stiffness && entry.key != "damping") continue;
        const double rate = std::stod(entry.value) / heaviest * machine.until;
        if (is_stiffness) stiffest = std::max(stiffest, rate * machine.until);
        if (!is_stiffness) strongest = std::max(strongest, rate);
      }
    }
  }
  EXPECT_GT(rods, 10);
  EXPECT_GT(strongest, 10.0);
  EXPECT_GT(stiffest, 50.0);
}

TEST(Writer, FilesArePackedAndUnpackedWhole) {
  ModelText text{"one\ntwo\n", {{"a.toml", "x = 1\n"}, {"b.toml", ""}}};
  const ModelText back = unpack(pack(text));
  EXPECT_EQ(back.model, text.model);
  EXPECT_EQ(back.beside, text.beside);
}

TEST(Writer, NumbersReadBackAsTheSame) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, -2.5e17, 123456789.123456789}) {
    EXPECT_EQ(std::stod(number_text(value)), value);
  }
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(list_text(Vec3(1.0, -0.5, 0.0)), "[1, -0.5, 0]");
}

TEST(Placing, TellsDriversThatDependOnTheJoints) {
  // A crank on a hinge, whose other end is held by a second joint of the same kind: driving both turns is one law too
  // many.
  Machine machine = draw_machine(kTestSeed, 1, Style::generic);
  machine.bodies.resize(2);
  machine.joints.clear();
  machine.couplings.clear();
  machine.elements.clear();
  machine.is_redundant = true;
  JointPlan hinge;
  hinge.name = "hinge";
  hinge.type = joints::find("revolute");
  hinge.ends[1].body = 1;
  hinge.q = VecX::Constant(1, 0.3);
  hinge.u = VecX::Constant(1, 2.0);
  hinge.coordinates.resize(1);
  machine.joints = {hinge, hinge};
  machine.joints[1].closes_loop = true;
  machine.joints[1].ends[0].point = Vec3(0.0, 0.0, 0.4);
  EXPECT_EQ(place(machine, 1).trouble, "");
  EXPECT_EQ(static_cast<int>(machine.joints[0].keeps_q[0]) + static_cast<int>(machine.joints[1].keeps_q[0]), 1);
  EXPECT_DOUBLE_EQ(machine.joints[0].u(0), 2.0);
  EXPECT_NEAR(machine.joints[1].u(0), 2.0, 1e-13);
  for (JointPlan& joint : machine.joints) {
    joint.coordinates[0].drive = {{"law", "\"constant_speed\""}};
    joint.coordinates[0].law = ConstantSpeed{0.3, 1.0};
  }
  EXPECT_EQ(place(machine, 1).trouble, "laws depend on the joints");
}
