#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "compare/verdict/reference.h"
#include "judged_machines.h"

/// Joint reactions by other programs, data/published, and what is said of tables in other conventions.
namespace concord::verification {
namespace {

using compare::ReferenceWord;

const std::filesystem::path kPublished = std::filesystem::path(CONCORD_DATA) / "published";

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

compare::Verdict against(const Model& model, compare::Verdict verdict, const std::string& table) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "concord_published_reference.csv";
  std::ofstream(file) << table;
  compare::judge_reference(model, compare::read_reference(file, model), verdict);
  std::filesystem::remove(file);
  return verdict;
}

compare::Verdict judged_at_its_times(const Model& model) {
  compare::VerifyOptions options;
  options.samples = model.run.samples;
  options.states = 20;
  return judged(model, options);
}

int count_of(const compare::Verdict& verdict, ReferenceWord word) {
  return static_cast<int>(std::count_if(verdict.references.begin(), verdict.references.end(),
                                        [&](const compare::ReferenceRow& row) { return row.word == word; }));
}

std::string findings_of(const compare::Verdict& verdict) {
  std::string text;
  for (const compare::Finding& finding : verdict.findings) text += finding.what + '\n';
  return text;
}

void replace(const std::string& old, const std::string& with, std::string& text) {
  REQUIRE(text.find(old) != std::string::npos);
  text.replace(text.find(old), old.size(), with);
}

/// What a table tells of one side of a joint.
using Telling = std::function<Wrench(const Joint&, const Sample&, std::size_t joint)>;

/// A long table of all joints at three times, each as `telling` says.
std::string table_of(const Model& model, const Trajectory& run, const Telling& telling) {
  std::string text = "# error = 1e-7 %\nt,of,component,value\n";
  for (const std::size_t k : {0U, 7U, 20U}) {
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const Vec6 told = telling(model.joints[j], run.samples[k], j).vector();
      for (int c = 0; c < 6; ++c) {
        text += fmt::format("{:.15g},{},{}_{},{:.15g}\n", run.samples[k].state.t, model.joints[j].name,
                            c < 3 ? "F" : "T", "xyz"[c % 3], told(c));
      }
    }
  }
  return text;
}

Eigen::Quaterniond turn_of(const State& state, int body) {
  const Vec4& p = state.bodies[static_cast<std::size_t>(body)].p;
  return {p(0), p(1), p(2), p(3)};
}

Vec3 point_of(const Attachment& side, const State& state) {
  return state.bodies[static_cast<std::size_t>(side.body)].r + turn_of(state, side.body) * side.point_L;
}

}  // namespace

TEST_CASE("Every published table is equal, or one of infinitely many where the reaction is not unique",
          "[reference][published]") {
  const std::map<std::string, std::array<int, 2>> expected{{"backhoe_light", {46, 36}},
                                                           {"circularPendulum", {6, 0}},
                                                           {"cut_force_and_torque", {6, 0}},
                                                           {"joint_ssr", {5, 0}},
                                                           {"piston", {15, 10}},
                                                           {"quasikine", {19, 0}},
                                                           {"quasikine_at25", {19, 0}},
                                                           {"spherical_spherical", {5, 0}},
                                                           {"ur5_rest", {6, 0}}};
  std::size_t tables = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kPublished)) {
    if (entry.path().extension() != ".csv") continue;
    ++tables;
    const std::string name = entry.path().stem().string();
    const Model model = read_model(kPublished / (name + ".toml"));
    const compare::Verdict verdict = against(model, judged_at_its_times(model), text_of(entry.path()));
    INFO(compare::format_verdict(model, verdict, true));
    const auto [equal, of_many] = expected.at(name);
    CHECK(count_of(verdict, ReferenceWord::equal) == equal);
    CHECK(count_of(verdict, ReferenceWord::one_of_many) == of_many);
    CHECK(verdict.references.size() == static_cast<std::size_t>(equal + of_many));
    CHECK(verdict.outcome == (of_many == 0 ? compare::Outcome::agree : compare::Outcome::differ));
    for (const compare::ReferenceRow& row : verdict.references) CHECK(row.allowed <= 0.01 * std::max(row.peak, 10.0));
  }
  CHECK(tables == expected.size());
}

TEST_CASE("The piston's table is equal in the parent's convention, and a number that is changed in it is wrong",
          "[reference][published]") {
  const Model model = read_model(kPublished / "piston.toml");
  const compare::Verdict verdict = judged_at_its_times(model);
  const std::string table = text_of(kPublished / "piston.csv");
  std::string untold = table;
  replace("# side = parent\n", "", untold);
  const compare::Verdict named = against(model, verdict, untold);
  INFO(compare::format_verdict(model, named, false));
  CHECK(named.outcome == compare::Outcome::differ);
  CHECK(named.findings.at(0).what == "reference: all joints are equal in another convention: `# side = parent`");
  CHECK(count_of(named, ReferenceWord::one_of_many) == 10);
  CHECK(count_of(named, ReferenceWord::wrong) == 0);

  std::string unique = table;  // 135.19 N, by 1e-8 of the peak
  replace("0.04,Joint1,F_x,135.19210941797", "0.04,Joint1,F_x,135.19210641797", unique);
  const compare::Verdict off = against(model, verdict, unique);
  CHECK(count_of(off, ReferenceWord::wrong) == 1);
  CHECK(off.findings.at(0).what.find("joint Joint1 on ground, F_x") != std::string::npos);
  CHECK(off.findings.at(0).what.find("at t = 0.04 s, where it says 135.192 N (line 11)") != std::string::npos);

  std::string of_many = table;  // by 5 % of a force that nothing determines, which passes four joints
  replace("0.04,Joint1,F_z,-0.10441880438122", "0.04,Joint1,F_z,-0.10941880438122", of_many);
  const compare::Verdict unbalanced = against(model, verdict, of_many);
  INFO(compare::format_verdict(model, unbalanced, false));
  CHECK(count_of(unbalanced, ReferenceWord::wrong) >= 1);
  CHECK(count_of(unbalanced, ReferenceWord::equal) == 15);
  double most = 0.0;
  for (const compare::ReferenceRow& row : unbalanced.references) {
    if (row.word != ReferenceWord::wrong) continue;
    CHECK(row.t == Approx(0.04));
    most = std::max(most, row.differences[0]);
  }
  CHECK(most > 0.002);  // another member halves the 0.005 N at best
  CHECK(most < 0.0051);
}

TEST_CASE("A sign that a table of both sides takes otherwise is named, and the sides are left as they are",
          "[reference][published]") {
  const Model model = read_model(kPublished.parent_path() / "models" / "slider_crank_spatial_rigid.toml");
  const compare::Verdict verdict = judged(model, in_short(model, 0.1));
  std::string table = "# error = 1e-7 %\nt,of,component,value\n";
  const Sample& sample = verdict.trajectories[0]->samples.at(7);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    for (const Side side : kSides) {
      const Vec6 told = sample.evaluation.joints[j].reaction_on(side).in_C.vector();
      for (int c = 0; c < 6; ++c) {
        table += fmt::format("{:.15g},{},{}.{}_{},{:.15g}\n", sample.state.t, model.joints[j].name,
                             side == Side::parent ? "parent" : "child", c < 3 ? "F" : "T", "xyz"[c % 3], -told(c));
      }
    }
  }
  const compare::Verdict named = against(model, verdict, table);
  INFO(compare::format_verdict(model, named, false));
  CHECK(named.outcome == compare::Outcome::differ);
  CHECK(named.findings.at(0).what == "reference: all joints are equal in another convention: `# sign = opposite`");
  CHECK(count_of(named, ReferenceWord::wrong) == 0);
  CHECK(against(model, verdict, "# sign = opposite\n" + table).outcome == compare::Outcome::agree);
}

TEST_CASE("A sign, a side, an axis, a frame and a point that a table takes otherwise are each named",
          "[reference][published]") {
  const Model model = read_model(kPublished.parent_path() / "models" / "slider_crank_spatial_rigid.toml");
  const compare::Verdict verdict = judged(model, in_short(model, 0.1));
  REQUIRE(verdict.outcome == compare::Outcome::agree);
  const auto on = [](Side side, std::size_t j, const Sample& sample) {
    return sample.evaluation.joints[j].reaction_on(side);
  };
  const Telling plain = [&](const Joint&, const Sample& sample, std::size_t j) {
    return on(Side::child, j, sample).in_C;
  };
  const Telling opposite = [&](const Joint& joint, const Sample& sample, std::size_t j) {
    const Wrench wrench = plain(joint, sample, j);
    return Wrench{-wrench.force, -wrench.torque};
  };
  const Telling of_first = [&](const Joint& joint, const Sample& sample, std::size_t j) {
    return j == 0 ? opposite(joint, sample, j) : plain(joint, sample, j);
  };
  const Telling parent = [&](const Joint&, const Sample& sample, std::size_t j) {
    return on(Side::parent, j, sample).in_C;
  };
  const Telling world = [&](const Joint&, const Sample& sample, std::size_t j) {
    return on(Side::child, j, sample).in_global;
  };
  const Telling body = [&](const Joint& joint, const Sample& sample, std::size_t j) {
    const Wrench wrench = world(joint, sample, j);
    const Eigen::Quaterniond to_body = turn_of(sample.state, joint.on(Side::child).body).conjugate();
    return Wrench{to_body * wrench.force, to_body * wrench.torque};
  };
  const Telling point = [&](const Joint& joint, const Sample& sample, std::size_t j) {
    Wrench wrench = world(joint, sample, j);
    const Vec3 arm = point_of(joint.on(Side::child), sample.state) - point_of(joint.on(Side::parent), sample.state);
    wrench.torque += arm.cross(wrench.force);
    return wrench;
  };
  struct Case {
    Telling telling;
    std::string named;
    std::string header;
  };
  const std::vector<Case> cases{
      {opposite, "all joints are equal in another convention: `# sign = opposite`", "# sign = opposite\n"},
      {of_first, fmt::format("joint {0} is equal in another convention: `# sign {0} = opposite`", model.joints[0].name),
       fmt::format("# sign {} = opposite\n", model.joints[0].name)},
      {parent, "all joints are equal in another convention: `# side = parent`", "# side = parent\n"},
      {world, "all joints are equal in another convention: `# axes = world`", "# axes = world\n"},
      {body, "all joints are equal in another convention: `# axes = body`", "# axes = body\n"},
      {point, "all joints are equal in another convention: `# axes = world` and `# point = other`",
       "# axes = world\n# point = other\n"}};
  const Trajectory& run = *verdict.trajectories[0];
  CHECK(against(model, verdict, table_of(model, run, plain)).outcome == compare::Outcome::agree);
  for (const Case& one : cases) {
    const std::string table = table_of(model, run, one.telling);
    const compare::Verdict off = against(model, verdict, table);
    INFO(compare::format_verdict(model, off, false));
    CHECK(off.outcome == compare::Outcome::differ);
    CHECK(count_of(off, ReferenceWord::wrong) == 0);
    CHECK(findings_of(off).find(one.named) != std::string::npos);
    CHECK(against(model, verdict, one.header + table).outcome == compare::Outcome::agree);
  }
  const Telling grown = [&](const Joint& joint, const Sample& sample, std::size_t j) {
    const Wrench wrench = parent(joint, sample, j);
    return Wrench{1.001 * wrench.force, 1.001 * wrench.torque};
  };
  CHECK(findings_of(against(model, verdict, table_of(model, run, grown))).find("convention") == std::string::npos);
}

}  // namespace concord::verification
