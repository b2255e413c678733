#include "compare/report/redundancy_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "compare/audit/digits.h"
#include "compare/report/explanations.h"
#include "compare/verdict/redundant.h"

namespace concord::compare {

namespace {

using Json = nlohmann::ordered_json;

std::string joint_name(const Model& model, int joint) { return model.joints[static_cast<std::size_t>(joint)].name; }

std::vector<std::string> names_of(const Model& model, const std::vector<int>& joints) {
  std::vector<std::string> names;
  for (const int joint : joints) names.push_back(joint_name(model, joint));
  return names;
}

Json vector_json(const Vec3& v) { return {v(0), v(1), v(2)}; }

Json part_json(const Model& model, const Verdict& verdict, const PartlyUnique& part) {
  const Attachment& side = model.joints[static_cast<std::size_t>(part.of.owner)].on(part.of.side);
  Json left_out = Json::array();
  for (Eigen::Index c = 0; c < part.left_out.cols(); ++c) left_out.push_back(vector_json(part.left_out.col(c)));
  const double need = need_of(verdict, part);
  return {{"joint", joint_name(model, part.of.owner)},
          {"side", part.of.side == Side::child ? "child" : "parent"},
          {"part", part.of.component < 3 ? "F" : "T"},
          {"left_out", std::move(left_out)},
          {"axes_of", model.bodies[static_cast<std::size_t>(side.body)].name},
          {"fixed", part.is_fixed},
          {"peak", part.peak},
          {"t", part.t_peak},
          {"states", part.samples},
          {"same_state_digits", digits_json(part.digits)},
          {"need", need},
          {"verdict", part.holds(need) ? "agree" : "differ"}};
}

}  // namespace

bool is_across_plane(const std::optional<PlanarLoops>& planar, int joint) {
  return planar && std::find(planar->joints.begin(), planar->joints.end(), joint) != planar->joints.end();
}

std::string planar_text(const Model& model, const PlanarLoops& planar) {
  const Vec3 n = (planar.normal.array().abs() < 1e-12).select(0.0, planar.normal);
  return fmt::format("across the plane of the loops, normal ({:.6g}, {:.6g}, {:.6g}): forces along it{} in joints {}",
                     n(0), n(1), n(2), planar.has_torques ? " and torques about axes in the plane" : "",
                     fmt::join(names_of(model, planar.joints), ", "));
}

std::string partly_unique_text(const Model& model, const Verdict& verdict) {
  std::string text;
  for (const PartlyUnique& part : verdict.partly_unique) {
    text += fmt::format("unique: {}: {:.6g} {} at most, at t = {:.4g} s, {} digits at the same state\n",
                        describe(model, part), part.peak, part.of.component < 3 ? "N" : "N m", part.t_peak,
                        format_digits(part.digits));
  }
  return text;
}

std::string cures_text(const Model& model, const Cures& cures) {
  constexpr std::size_t kShown = 3;
  if (cures.tried == 0) return "";
  const std::string tries = fmt::format("{} tried{}", cures.tried, cures.is_complete ? "" : ", no more");
  if (cures.found.empty()) {
    return fmt::format(
        "no other types of one joint or of two make all reactions unique at the same degrees of freedom ({})\n", tries);
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(kShown, cures.found.size()); ++k) {
    text += fmt::format("all reactions would be unique if {}\n", describe(model, cures.found[k]));
  }
  if (cures.found.size() > kShown) {
    text += fmt::format("and so with {} more such changes of {} ({})\n", cures.found.size() - kShown,
                        cures.found[0].size() == 1 ? "one joint" : "two joints", tries);
  }
  return text;
}

void add_redundancy(Json& said, const Model& model, const Verdict& verdict) {
  for (const PartlyUnique& part : verdict.partly_unique) {
    said["partly_unique"].push_back(part_json(model, verdict, part));
  }
  if (verdict.planar) {
    said["planar_loops"] = {{"joints", names_of(model, verdict.planar->joints)},
                            {"normal", vector_json(verdict.planar->normal)}};
  }
  for (const std::vector<JointChange>& changes : verdict.cures.found) {
    Json all = Json::array();
    for (const JointChange& change : changes) {
      all.push_back({{"joint", joint_name(model, change.joint)}, {"type", change.to->name}});
    }
    said["unique_if"].push_back(std::move(all));
  }
}

}  // namespace concord::compare
