#include <gmock/gmock.h>

#include <functional>

#include "common/flexible/beam.h"
#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"
#include "tests/second_reading/second_reading.h"
#include "tests/unit/second_reading/stated_machine.h"
#include "tests/unit/temporary_folder.h"

namespace concord::second_reading {
namespace {

using compare::TemporaryFolder;

struct Spoil {
  std::string where;
  std::string key;
  std::function<void(Model&)> spoil;
};

Body& body(Model& model, const std::string& name) {
  return *std::find_if(model.bodies.begin(), model.bodies.end(), [&](const Body& one) { return one.name == name; });
}
Joint& joint(Model& model, const std::string& name) {
  return *std::find_if(model.joints.begin(), model.joints.end(), [&](const Joint& one) { return one.name == name; });
}
template <class Kind>
Kind& element(Model& model, const std::string& name) {
  return std::get<Kind>(std::find_if(model.elements.begin(), model.elements.end(), [&](const auto& one) {
                          return one.name == name;
                        })->what);
}
void change_beam(Model& model, const std::string& name, const std::function<void(BeamSpecification&)>& change) {
  auto beam = std::make_shared<BeamSpecification>(*body(model, name).modal->beam);
  change(*beam);
  body(model, name).modal->beam = beam;
}
void change_road(Model& model, const std::string& name, const std::function<void(Road&)>& change) {
  auto road = std::make_shared<Road>(*element<Tire>(model, name).road);
  change(*road);
  element<Tire>(model, name).road = road;
}
void change_type(Model& model, const std::string& name, double number) {
  Joint& of = joint(model, name);
  of.own_type = std::make_shared<joints::JointType>(joints::find(of.type->name)->with_parameters({number}));
  of.type = of.own_type.get();
}
ForceLaw& law_of_cross(Model& model) { return joint(model, "cross").springs[0].law; }

std::vector<Spoil> of_bodies() {
  return {
      {"body rod", "mass", [](Model& m) { body(m, "rod").mass *= 1.0 + 1e-10; }},
      {"body rod", "inertia", [](Model& m) { body(m, "rod").inertia_L(0, 1) *= -1.0; }},
      {"body rod", "inertia", [](Model& m) { body(m, "rod").inertia_L.row(0).swap(body(m, "rod").inertia_L.row(1)); }},
      {"body rod", "center_of_mass", [](Model& m) { body(m, "rod").center_of_mass_L.y() *= -1.0; }},
      {"body plate", "center_of_mass", [](Model& m) { body(m, "plate").center_of_mass_L.z() = 1e-3; }},
      {"body rod", "start.pose.origin", [](Model& m) { body(m, "rod").pose_guess->r.x() = 0.0; }},
      {"body rod", "start.pose.frame", [](Model& m) { body(m, "rod").pose_guess->A.transposeInPlace(); }},
      {"body rod", "start.pose", [](Model& m) { body(m, "rod").pose_guess.reset(); }},
      {"body blade", "start.a", [](Model& m) { body(m, "blade").a_start(2) = 0.0; }},
      {"body blade", "start.adot", [](Model& m) { body(m, "blade").adot_start *= 0.5; }},
      {"body tube", "start.a", [](Model& m) { body(m, "tube").a_start(0) = 1e-3; }},
      {"model", "body", [](Model& m) { m.bodies.push_back(m.bodies.back()); }},
  };
}

std::vector<Spoil> of_beams() {
  const auto spoil = [](const std::string& body, const std::string& key, void (*change)(BeamSpecification&)) {
    return Spoil{"body " + body, "beam." + key, [=](Model& m) { change_beam(m, body, change); }};
  };
  return {
      spoil("blade", "section.area", [](BeamSpecification& b) { b.area *= 1.01; }),
      spoil("blade", "section.torsion_constant", [](BeamSpecification& b) { b.torsion_constant *= 1.002; }),
      spoil("tube", "section.second_moment_y", [](BeamSpecification& b) { b.second_moment_y *= 1.01; }),
      spoil("blade", "damping_ratio", [](BeamSpecification& b) { b.damping_ratio = 0.02; }),
      spoil("tube", "damping_ratio", [](BeamSpecification& b) { b.damping_ratio = 0.02; }),
      spoil("blade", "frame", [](BeamSpecification& b) { b.axes.col(1).swap(b.axes.col(2)); }),
      spoil("tube", "frame", [](BeamSpecification& b) { b.axes.transposeInPlace(); }),
      spoil("blade", "first_end", [](BeamSpecification& b) { b.first_end_L.z() *= -1.0; }),
      spoil("blade", "length", [](BeamSpecification& b) { b.length = 0.4; }),
      spoil("tube", "elements", [](BeamSpecification& b) { b.elements = 24; }),
      spoil("tube", "youngs_modulus", [](BeamSpecification& b) { b.youngs_modulus *= 2; }),
      spoil("tube", "shear_modulus", [](BeamSpecification& b) { b.shear_modulus *= 2; }),
      spoil("blade", "poissons_ratio", [](BeamSpecification& b) { b.shear_modulus *= 1.01; }),
      spoil("tube", "density", [](BeamSpecification& b) { b.density *= 2; }),
      spoil("tube", "support", [](BeamSpecification& b) { b.support = BeamSupport::cantilever; }),
      spoil("blade", "modes.bending_xz", [](BeamSpecification& b) { b.modes[1].number = 3; }),
  };
}

std::vector<Spoil> of_modes_files() {
  const auto spoil = [](const std::string& key, void (*change)(ModalData&)) {
    return Spoil{"body panel", key, [=](Model& m) { change(*body(m, "panel").modal); }};
  };
  const auto of_node = [](const std::string& key, void (*change)(ModalNode&)) {
    return Spoil{"body panel, node edge", key, [=](Model& m) { change(body(m, "panel").modal->nodes[1]); }};
  };
  return {
      spoil("stiffness", [](ModalData& d) { d.stiffness(0, 1) = d.stiffness(1, 0) = 0.0; }),
      spoil("damping_ratios", [](ModalData& d) { d.damping = MatX(d.damping.diagonal().asDiagonal()); }),
      spoil("damping_ratios", [](ModalData& d) { d.damping *= 1.001; }),
      spoil("mass_point", [](ModalData& d) { d.G(0, 0) += 1e-6; }),
      spoil("mass_point", [](ModalData& d) { d.G(4, 5) = d.G(5, 4) += 1e-6; }),
      spoil("mass_point (as mass points)", [](ModalData& d) { d.mass_points.back().mass *= 1.001; }),
      spoil("frequencies", [](ModalData& d) { d.frequencies = d.frequencies * 1.001; }),
      of_node("point", [](ModalNode& node) { node.s0_L.y() *= -1; }),
      of_node("Psi_t", [](ModalNode& node) { node.Psi_t_L(0, 1) = 0; }),
      of_node("Psi_r", [](ModalNode& node) { node.Psi_r_L(0, 1) = 0; }),
      of_node("name", [](ModalNode& node) { node.name = "egde"; }),
  };
}

std::vector<Spoil> of_joints() {
  return {
      {"joint glue", "type", [](Model& m) { joint(m, "glue").type = joints::find("spherical"); }},
      {"joint hinge", "child.point", [](Model& m) { joint(m, "hinge").sides[1].point_L.x() *= -1.0; }},
      {"joint hinge", "child.frame", [](Model& m) { joint(m, "hinge").sides[1].C.col(0) *= -1.0; }},
      {"joint thread", "parent.frame", [](Model& m) { joint(m, "thread").sides[0].C.transposeInPlace(); }},
      {"joint thread", "child.frame", [](Model& m) { joint(m, "thread").sides[1].C.setIdentity(); }},
      {"joint thread", "parent.point", [](Model& m) { joint(m, "thread").sides[0].point_L.y() = 0.4; }},
      {"joint thread", "child.body", [](Model& m) { joint(m, "thread").sides[1].body = 6; }},
      {"joint thread", "lead", [](Model& m) { change_type(m, "thread", 0.05); }},
      {"joint rod_of_air", "length", [](Model& m) { change_type(m, "rod_of_air", 0.4); }},
      {"joint roller", "radius", [](Model& m) { change_type(m, "roller", 0.25); }},
      {"joint rod_of_air", "child.offset", [](Model& m) { joint(m, "rod_of_air").sides[1].point_L.y() += 0.04; }},
      {"joint rod_of_air", "child.node.Psi_t", [](Model& m) { joint(m, "rod_of_air").sides[1].Psi_t_L(2, 0) *= -1; }},
      {"joint rod_of_air", "child.node.Psi_r", [](Model& m) { joint(m, "rod_of_air").sides[1].Psi_r_L *= -1; }},
      {"joint seat", "child.node.Psi_t",
       [](Model& m) { joint(m, "seat").sides[1].Psi_t_L = body(m, "panel").modal->nodes[0].Psi_t_L; }},
      {"joint hinge", "cut", [](Model& m) { joint(m, "hinge").named_as_cut = false; }},
      {"joint cross", "cut", [](Model& m) { joint(m, "cross").named_as_cut = true; }},
      {"joint thread", "start.turn.guess", [](Model& m) { joint(m, "thread").start[0].q(0) = 0.1745; }},
      {"joint thread", "start.turn.guess", [](Model& m) { joint(m, "thread").start[0].role_q = StartRole::keep; }},
      {"joint thread", "start.turn.keep_speed", [](Model& m) { joint(m, "thread").start[0].u(0) = 2; }},
      {"joint rod_of_air", "start.ball.keep", [](Model& m) { joint(m, "rod_of_air").start[3].q(1) *= -1; }},
      {"joint rod_of_air", "start.ball.guess_speed", [](Model& m) { joint(m, "rod_of_air").start[3].u(1) = 0; }},
      {"joint rod_of_air", "start.turn_y", [](Model& m) { joint(m, "rod_of_air").start[1].role_q = StartRole::guess; }},
      {"joint hinge", "drive.turn_z.to",
       [](Model& m) { std::get<SmoothStep>(joint(m, "hinge").drivers[0].law).to *= 1.01; }},
      {"joint hinge", "drive.turn_z.law", [](Model& m) { joint(m, "hinge").drivers[0].law = ConstantSpeed{}; }},
      {"model", "joint", [](Model& m) { m.joints.push_back(m.joints.front()); }},
      {"coupling mesh", "factor", [](Model& m) { m.couplings[0].terms[1].factor = 3; }},
      {"coupling mesh", "coordinate", [](Model& m) { m.couplings[0].terms[0].word = 0; }},
      {"coupling mesh", "offset", [](Model& m) { m.couplings[0].offset *= -1; }},
  };
}

std::vector<Spoil> of_laws() {
  return {
      {"joint hinge", "spring.turn_z.preload", [](Model& m) { joint(m, "hinge").springs[0].law.preload *= -1; }},
      {"joint hinge", "spring.turn_z.free", [](Model& m) { joint(m, "hinge").springs[0].law.free = 15; }},
      {"joint hinge", "spring.turn_z.stiffness", [](Model& m) { joint(m, "hinge").springs[0].law.stiffness = 1; }},
      {"joint hinge", "spring.turn_z.damping", [](Model& m) { joint(m, "hinge").springs[0].law.damping = 0; }},
      {"joint cross", "spring.turn_y.upper_stop.width", [](Model& m) { law_of_cross(m).upper->width *= 2; }},
      {"joint cross", "spring.turn_y.lower_stop.at", [](Model& m) { law_of_cross(m).lower->at *= -1; }},
      {"joint cross", "spring.turn_y.lower_stop.damping", [](Model& m) { law_of_cross(m).lower->damping = 1; }},
      {"joint cross", "spring.turn_y.lower_stop", [](Model& m) { law_of_cross(m).lower.reset(); }},
      {"joint cross", "spring.turn_y.damper_table.force",
       [](Model& m) {
         law_of_cross(m).damper_table = ForceTable({-5, -1, 0, 1, 5}, {-0.4, -0.15, 0, 0.15, 0.3});
       }},
      {"joint cross", "spring.turn_y.actuator.values",
       [](Model& m) {
         law_of_cross(m).actuator = SplineTable({0, 1, 2, 3}, {0, 0.2, 0.1, 0.5});
       }},
      {"force coil", "spring_table.x",
       [](Model& m) {
         element<LineSpring>(m, "coil").law.spring_table = ForceTable({-2, -1, 1, 3}, {-8, -1, 1, 8});
       }},
      {"force coil", "actuator",
       [](Model& m) {
         element<LineSpring>(m, "coil").law.actuator = ConstantSpeed{4, 1};
       }},
      {"force helix", "actuator.coefficients",
       [](Model& m) { std::get<Polynomial>(*element<TurnSpring>(m, "helix").law.actuator).coefficients[2] = 0; }},
      {"force helix", "damping", [](Model& m) { element<TurnSpring>(m, "helix").law.damping = 0; }},
  };
}

std::vector<Spoil> of_elements() {
  return {
      {"force wind", "force", [](Model& m) { element<Load>(m, "wind").force.y() = 2; }},
      {"force wind", "torque", [](Model& m) { element<Load>(m, "wind").torque.setZero(); }},
      {"force wind", "axes", [](Model& m) { element<Load>(m, "wind").axes = LoadAxes::body; }},
      {"force wind", "frame", [](Model& m) { element<Load>(m, "wind").at.C.setIdentity(); }},
      {"force wind", "law.phase", [](Model& m) { std::get<Harmonic>(element<Load>(m, "wind").law).phase = 0; }},
      {"force push", "law",
       [](Model& m) {
         element<Load>(m, "push").law = ConstantSpeed{2.0, 0.0};
       }},
      {"force push", "node.Psi_r", [](Model& m) { element<Load>(m, "push").at.Psi_r_L.setZero(); }},
      {"force coil", "child.node.Psi_t",
       [](Model& m) { element<LineSpring>(m, "coil").ends[1].Psi_t_L(1, 3) += 1e-3; }},
      {"force helix", "child.frame", [](Model& m) { element<TurnSpring>(m, "helix").ends[1].C.setIdentity(); }},
      {"force mount", "stiffness", [](Model& m) { element<Bushing>(m, "mount").stiffness(0, 5) = 0; }},
      {"force mount", "damping", [](Model& m) { element<Bushing>(m, "mount").damping(3, 5) = 0; }},
      {"force mount", "preload", [](Model& m) { element<Bushing>(m, "mount").preload *= -1; }},
      {"force mount", "parent.frame", [](Model& m) { element<Bushing>(m, "mount").ends[0].C.transposeInPlace(); }},
      {"force tire", "radius", [](Model& m) { element<Tire>(m, "tire").radius = 0.31; }},
      {"force tire", "stiffness", [](Model& m) { element<Tire>(m, "tire").stiffness *= 2; }},
      {"force tire", "damping", [](Model& m) { element<Tire>(m, "tire").damping = 0; }},
      {"force tire", "slip_stiffness", [](Model& m) { element<Tire>(m, "tire").slip_stiffness = 2e4; }},
      {"force tire", "cornering_stiffness", [](Model& m) { element<Tire>(m, "tire").cornering_stiffness = 3e4; }},
      {"force tire", "friction", [](Model& m) { element<Tire>(m, "tire").friction = 1; }},
      {"force tire", "speed_scale", [](Model& m) { element<Tire>(m, "tire").speed_scale = 0.1; }},
      {"force spare", "speed_scale", [](Model& m) { element<Tire>(m, "spare").speed_scale = 0.2; }},
      {"force tire", "point", [](Model& m) { element<Tire>(m, "tire").wheel.point_L.setZero(); }},
      {"road bump", "height",
       [](Model& m) {
         change_road(m, "tire", [](Road& road) { std::get<HalfSineBump>(road.profile).height = 0.02; });
       }},
      {"road hills", "x",
       [](Model& m) { change_road(m, "spare", [](Road& road) { std::get<RoadTable>(road.profile).last = 3; }); }},
      {"model", "force elements", [](Model& m) { m.elements.push_back(m.elements.front()); }},
  };
}

std::vector<Spoil> of_runs() {
  return {
      {"gravity", "gravity", [](Model& m) { m.gravity.z() *= -1.0; }},
      {"model", "name", [](Model& m) { m.name = "another"; }},
      {"run", "until", [](Model& m) { m.run.until = 1.0; }},
      {"run", "samples", [](Model& m) { m.run.samples.reset(); }},
      {"run", "rtol", [](Model& m) { m.run.rtol = 1e-9; }},
      {"run", "start", [](Model& m) { m.run.from_equilibrium = false; }},
      {"need 1", "same_run", [](Model& m) { m.needs[0].same_run = 5; }},
      {"need 1", "refined", [](Model& m) { m.needs[0].refined = 5; }},
      {"need 1", "component", [](Model& m) { m.needs[0].component = "T_x"; }},
      {"need 1", "joint", [](Model& m) { m.needs[0].joint = "seat"; }},
      {"model", "need", [](Model& m) { m.needs.clear(); }},
  };
}

void expect_each_named(const std::vector<Spoil>& spoils) {
  const TemporaryFolder folder;
  write_file(folder.path(), "panel.toml", kStatedPanel);
  const std::filesystem::path file = write_file(folder.path(), "machine.toml", kStatedMachine);
  const Model model = read_model(file);
  for (const Spoil& one : spoils) {
    Model spoiled = model;
    one.spoil(spoiled);
    const SecondReading found = read_again(spoiled, file);
    ASSERT_FALSE(found.differing.empty()) << one.where << ": " << one.key;
    for (const StatedValue& value : found.differing) {
      EXPECT_EQ(value.where, one.where) << one.key;
      EXPECT_EQ(value.key, one.key) << one.where;
      EXPECT_GT(value.scale, 0.0);
      EXPECT_GT(value.residual, 0.0);
    }
  }
}

TEST(SecondReadingOfSpoiledModel, NamesBodies) { expect_each_named(of_bodies()); }
TEST(SecondReadingOfSpoiledModel, NamesBeams) { expect_each_named(of_beams()); }
TEST(SecondReadingOfSpoiledModel, NamesModesFiles) { expect_each_named(of_modes_files()); }
TEST(SecondReadingOfSpoiledModel, NamesJoints) { expect_each_named(of_joints()); }
TEST(SecondReadingOfSpoiledModel, NamesLaws) { expect_each_named(of_laws()); }
TEST(SecondReadingOfSpoiledModel, NamesElements) { expect_each_named(of_elements()); }
TEST(SecondReadingOfSpoiledModel, NamesRuns) { expect_each_named(of_runs()); }

TEST(SecondReadingOfSpoiledModel, NamesBothMomentsOfAnExchangedSection) {
  const TemporaryFolder folder;
  write_file(folder.path(), "panel.toml", kStatedPanel);
  const std::filesystem::path file = write_file(folder.path(), "machine.toml", kStatedMachine);
  Model model = read_model(file);
  change_beam(model, "blade", [](BeamSpecification& beam) { std::swap(beam.second_moment_y, beam.second_moment_z); });
  const SecondReading found = read_again(model, file);
  ASSERT_EQ(found.differing.size(), 2U);
  EXPECT_EQ(found.differing[0].key, "beam.section.second_moment_y");
  EXPECT_EQ(found.differing[1].key, "beam.section.second_moment_z");
  EXPECT_EQ(found.differing[0].line, 32);
}

TEST(SecondReadingOfSpoiledModel, NamesWhatWasLost) {
  const TemporaryFolder folder;
  write_file(folder.path(), "panel.toml", kStatedPanel);
  const std::filesystem::path file = write_file(folder.path(), "machine.toml", kStatedMachine);
  Model model = read_model(file);
  model.elements.pop_back();
  const SecondReading found = read_again(model, file);
  ASSERT_EQ(found.differing.size(), 2U);
  EXPECT_EQ(found.differing[0].where, "force spare");
  EXPECT_EQ(found.differing[0].text, "read as '', stated 'spare'");
  EXPECT_EQ(found.differing[1].key, "force elements");
}

}  // namespace
}  // namespace concord::second_reading
