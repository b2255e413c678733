#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "closed_forms.h"
#include "common/reading/modes_file.h"
#include "common/reading/text_file.h"
#include "compare/audit/carried_components.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"

/// The machines of data/models, each over the whole run that its file states, at its needs and default tolerances.
namespace concord::verification {
namespace {

const std::filesystem::path kModels = std::filesystem::path(CONCORD_DATA) / "models";

compare::Verdict verdict_of(const Model& model, const compare::VerifyOptions& options) {
  const auto cartesian_solver = cartesian::make_solver(model);
  const auto relative_solver = relative::make_solver(model);
  return compare::verify(model, *cartesian_solver, *relative_solver, options);
}

/// Model files by whether their names begin with "car".
std::vector<std::string> shipped(bool cars) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kModels)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".toml" && name.starts_with("car") == cars) names.push_back(name);
  }
  REQUIRE(names.size() > 3);
  std::sort(names.begin(), names.end());
  return names;
}

void expect_agreement(const std::string& name) {
  const Model model = read_model(kModels / name);
  const compare::Verdict verdict = verdict_of(model, {});
  const std::string table = compare::format_verdict(model, verdict, false);
  std::printf("%s", table.substr(table.rfind('\n', table.size() - 2) + 1).c_str());
  std::fflush(stdout);
  INFO(table);
  CHECK(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.judged > 0);
}

TEST_CASE("Every shipped machine agrees over its whole run", "[nightly]") {
  for (const std::string& name : shipped(false)) expect_agreement(name);
}

TEST_CASE("Every shipped car agrees over its whole run", "[nightly]") {
  for (const std::string& name : shipped(true)) expect_agreement(name);
}

TEST_CASE(
    "Whichever integrators run the spatial flexible slider-crank, stiff ones too, all its reactions agree; that ida "
    "refines its vibrations no further is told as that",
    "[nightly]") {
  const Model model = read_model(kModels / "slider_crank_spatial_flexible.toml");
  for (const std::string first : {"gauss", "ida"}) {
    for (const std::string second : {"adams", "dirk"}) {
      compare::VerifyOptions options;
      options.integrators = {first, second};
      const compare::Verdict verdict = verdict_of(model, options);
      std::printf("%s, %s: same run %.1f, refined %.1f\n", first.c_str(), second.c_str(),
                  verdict.same_run.digits.value_or(0.0), verdict.refined.digits.value_or(0.0));
      std::fflush(stdout);
      INFO(first << ", " << second << '\n' << compare::format_verdict(model, verdict, false));
      CHECK(verdict.same_state.passed);
      CHECK(verdict.same_run.passed);
      if (verdict.outcome == compare::Outcome::agree) continue;
      CHECK(first == "ida");
      CHECK(verdict.outcome == compare::Outcome::failed);
      for (const std::string& failure : verdict.failures) {
        CHECK_THAT(failure, Catch::Contains("refined: the runs do not converge as far as the verdict needs"));
      }
    }
  }
}

/// The flexible slider-crank with its beam said by a modes file that lies beside it.
Model with_modes_file(const ModalData& modes, InertiaForm form) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("concord_modes_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "coupler.toml") << format_modes(modes, form);
  std::string text = read_text_file(kModels / "slider_crank_spatial_flexible.toml");
  const std::size_t first = text.find("[body.beam]");
  const std::string last = "damping_ratio = 0.01\n";
  text.replace(first, text.find(last) + last.size() - first, "modes_file = \"coupler.toml\"\n");
  const struct Cleaner {
    const std::filesystem::path& path;
    ~Cleaner() { std::filesystem::remove_all(path); }
  } cleaner{folder};
  return parse_model(text, folder / "machine.toml");
}

TEST_CASE(
    "A coupler from a modes file, as mass points or as integrals, loads its joints as the beam it came from does") {
  const Model beam = read_model(kModels / "slider_crank_spatial_flexible.toml");
  const Trajectory swing = relative::make_solver(beam)->integrate({0.02, 1e-9, 8, ""}, {});
  for (const InertiaForm form : {InertiaForm::mass_points, InertiaForm::integrals}) {
    const Model model = with_modes_file(*beam.bodies[2].modal, form);
    REQUIRE(model.bodies[2].modal->n_modes() == 8);
    const auto expected = both_solvers(beam);
    const auto found = both_solvers(model);
    for (std::size_t who = 0; who < 2; ++who) {
      for (const Sample& sample : swing.samples) {
        const Evaluation one = expected[who]->evaluate(sample.state);
        const Evaluation other = found[who]->evaluate(sample.state);
        for (std::size_t k = 0; k < model.joints.size(); ++k) {
          for (const Side side : {Side::parent, Side::child}) {
            const Vec6 exact = one.joints[k].reaction_on(side).in_C.vector();
            const Vec6 difference = other.joints[k].reaction_on(side).in_C.vector() - exact;
            INFO(found[who]->name() << ", joint " << model.joints[k].name << ", t = " << sample.state.t);
            CHECK(difference.norm() <= 1e-12 * exact.norm());
          }
        }
      }
    }
  }
}

TEST_CASE("Of the spatial slider-cranks every reaction component that a joint can carry is above 1 % of its scale") {
  for (const char* name : {"slider_crank_spatial_rigid.toml", "slider_crank_spatial_flexible.toml"}) {
    Model model = read_model(kModels / name);
    model.run.until = 0.5;
    const auto solver = relative::make_solver(model);
    const Trajectory trajectory = solver->integrate({model.run.until, 1e-8, 250, ""}, {});
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        Vec6 peak = Vec6::Zero();
        Eigen::Vector2d scale = Eigen::Vector2d::Zero();  // largest force and torque
        for (const Sample& sample : trajectory.samples) {
          const Wrench& wrench = sample.evaluation.joints[k].reaction_on(side).in_C;
          peak = peak.cwiseMax(wrench.vector().cwiseAbs());
          scale = scale.cwiseMax(Eigen::Vector2d(wrench.force.norm(), wrench.torque.norm()));
        }
        scale(1) = std::max(scale(1), scale(0) * model.length_scale());
        for (int c = 0; c < 6; ++c) {
          if (!compare::carries(*model.joints[k].type, side, c)) continue;
          INFO(name << ", joint " << model.joints[k].name << ", side " << index(side) << ", component " << c);
          CHECK(peak(c) > 0.01 * scale(c / 3));
        }
      }
    }
  }
}

}  // namespace
}  // namespace concord::verification
