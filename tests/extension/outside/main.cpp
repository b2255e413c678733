#include <cstdio>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/joint_check/sheet.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"
#include "planar_cam.h"
#include "relative/solver.h"

/// A follower on the cam, swinging. Model files know the catalogue's types alone: the page's type is put in afterwards.
concord::Model follower() {
  concord::Model model = concord::parse_model(R"(format = 1
gravity = [0.4, -9.6, 1.1]
[[body]]
name = "follower"
mass = 1.7
center_of_mass = [0.11, -0.07, 0.23]
inertia = [0.031, 0.022, 0.041, 0.004, -0.002, 0.003]
[[joint]]
name = "cam"
type = "revolute"
parent = "ground"
child = "follower"
[run]
until = 0.05
)",
                                              "follower.toml");
  concord::Joint& cam = model.joints.front();
  cam.type = &concord::joints::planar_cam;
  cam.start = {
      {concord::StartRole::keep, concord::StartRole::keep, Eigen::Vector2d(0.4, 0.9), Eigen::Vector2d(2.0, 1.0)}};
  return model;
}

int main() {
  concord::compare::joint_check::SheetOptions options;
  options.poses = {1, 2, 3};
  const auto sheet = concord::compare::joint_check::check_joint(concord::joints::planar_cam, options);
  std::fputs(concord::compare::joint_check::format_sheet(sheet).c_str(), stdout);

  const concord::Model model = follower();
  const auto cartesian = concord::cartesian::make_solver(model);
  const auto relative = concord::relative::make_solver(model);
  const auto verdict = concord::compare::verify(model, *cartesian, *relative, {});
  std::fputs(concord::compare::format_verdict(model, verdict, false).c_str(), stdout);
  return sheet.holds() && verdict.outcome == concord::compare::Outcome::agree ? 0 : 1;
}
