#include "compare/report/info.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/audit/carried_components.h"
#include "compare/audit/joint_motion.h"
#include "compare/quantities/observe.h"
#include "compare/report/redundancy_text.h"
#include "compare/report/text_table.h"

namespace concord::compare {

namespace {

using Lines = std::vector<std::vector<std::string>>;

std::string body_table(const Model& model) {
  Lines lines{{"body", "mass [kg]", "modes", "frequencies [rad/s]"}};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const double mass = body.modal ? body.modal->G(0, 0) : body.mass;
    std::string frequencies;
    if (body.modal) {
      for (const double frequency : body.modal->frequencies) {
        frequencies += fmt::format("{}{:.6g}", frequencies.empty() ? "" : " ", frequency);
      }
    }
    lines.push_back({body.name, fmt::format("{:.6g}", mass), fmt::format("{}", body.n_modes()), frequencies});
  }
  return format_table(lines, {false, true, true, false});
}

std::string joint_table(const Model& model, const std::array<SolverView, 2>& solvers) {
  Lines lines{{"joint", "type", "parent", "child", "drivers", "springs", "cut by"}};
  for (const Joint& joint : model.joints) {
    std::string cut_by;
    for (const SolverView& solver : solvers) {
      if (std::find(solver.cut_joints.begin(), solver.cut_joints.end(), joint.name) == solver.cut_joints.end())
        continue;
      cut_by += (cut_by.empty() ? "" : ", ") + solver.name;
    }
    lines.push_back({joint.name, joint.type->name, model.bodies[joint.on(Side::parent).body].name,
                     model.bodies[joint.on(Side::child).body].name, fmt::format("{}", joint.drivers.size()),
                     fmt::format("{}", joint.springs.size()), cut_by});
  }
  return format_table(lines, {false, false, false, false, true, true, false});
}

std::string kind_of(const ForceElement& element) {
  std::string words(key_of(element));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string element_table(const Model& model) {
  if (model.elements.empty()) return "";
  Lines lines{{"force element", "kind", "parent", "child"}};
  for (const ForceElement& element : model.elements) {
    const Attachment* parent = end_of(element, Side::parent);
    lines.push_back({element.name, kind_of(element), parent != nullptr ? model.bodies[parent->body].name : "-",
                     model.bodies[end_of(element, Side::child)->body].name});
  }
  return format_table(lines, {false, false, false, false}) + '\n';
}

std::string coupling_table(const Model& model) {
  if (model.couplings.empty()) return "";
  Lines lines{{"coupling", "sum", "offset"}};
  for (const Coupling& coupling : model.couplings) {
    std::string sum;
    for (const CouplingTerm& term : coupling.terms) {
      const Joint& joint = model.joints[term.joint];
      const std::string name = speed_names(*joint.type).at(static_cast<std::size_t>(speed_of(model, term)));
      sum += fmt::format("{}{:g} {}.{}", sum.empty() ? "" : " + ", term.factor, joint.name, name);
    }
    lines.push_back({coupling.name, sum, fmt::format("{:g}", coupling.offset)});
  }
  return format_table(lines, {false, false, true}) + '\n';
}

std::string not_unique(const Model& model, const SolverView& solver, const std::optional<PlanarLoops>& planar) {
  std::string text;
  if (planar) text += planar_text(model, *planar) + " (concord compare --all lists them)\n";
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      if (is_across_plane(planar, static_cast<int>(k))) continue;
      std::string components;
      for (int c = 0; c < 6; ++c) {
        if (!carries(*model.joints[k].type, side, c) || solver.rank.joints.at(k).unique[index(side)][c]) continue;
        components += " " + component_names()[c];
      }
      if (components.empty()) continue;
      text += fmt::format("{}:{}\n", describe_owner(model, {Kind::reaction, static_cast<int>(k), side, 0}), components);
    }
    for (const int speed : forced_speeds(model, static_cast<int>(k))) {
      for (const Kind kind : {Kind::tau, Kind::share}) {
        const JointUniqueness& unique = solver.rank.joints.at(k);
        const Quantity force{kind, static_cast<int>(k), Side::child, speed};
        if (kind == Kind::tau ? unique.unique_tau[speed] : unique.unique_driver[speed]) continue;
        if (kind == Kind::share && !is_shared(model, static_cast<int>(k), speed)) continue;
        text += fmt::format("{}: {}\n", describe_owner(model, force), describe_component(force));
      }
    }
  }
  for (std::size_t g = 0; g < model.couplings.size(); ++g) {
    if (solver.rank.unique_coupling.empty() || solver.rank.unique_coupling.at(g)) continue;
    const Quantity force{Kind::coupling, static_cast<int>(g), Side::child, 0};
    text += fmt::format("{}: {}\n", describe_owner(model, force), describe_component(force));
  }
  return text;
}

std::string rank_text(const Model& model, const SolverView& solver, const std::optional<PlanarLoops>& planar) {
  std::string text = fmt::format("{}: {} constraints of rank {}, {} degrees of freedom, integrators {}\n", solver.name,
                                 solver.rank.constraints, solver.rank.rank, solver.rank.degrees_of_freedom,
                                 fmt::join(solver.integrators, ", "));
  if (solver.rank.undecided) text += "  the rank is undecided: a singular value lies between 1e-12 and 1e-8\n";
  const std::string names = not_unique(model, solver, planar);
  if (names.empty()) return text + "  every reaction component is unique\n";
  text += "  reactions that are not unique, and not judged:\n";
  std::size_t first = 0;
  while (first < names.size()) {
    const std::size_t end = names.find('\n', first) + 1;
    text += "    " + names.substr(first, end - first);
    first = end;
  }
  return text;
}

}  // namespace

std::string format_info(const Model& model, const std::array<SolverView, 2>& solvers,
                        const RedundancyView& redundancy) {
  const int bodies = static_cast<int>(model.bodies.size()) - 1;
  const int joints = static_cast<int>(model.joints.size());
  std::string text =
      fmt::format("{}: {}, {}, {}, gravity ({:g}, {:g}, {:g}) m/s2\n\n", model.name,
                  plural(bodies, "moving body", "moving bodies"), plural(joints, "joint", "joints"),
                  plural(joints - bodies, "loop", "loops"), model.gravity(0), model.gravity(1), model.gravity(2));
  text += body_table(model) + '\n' + joint_table(model, solvers) + '\n' + coupling_table(model) + element_table(model);
  for (const SolverView& solver : solvers) text += rank_text(model, solver, redundancy.planar);
  return text + cures_text(model, redundancy.cures);
}

}  // namespace concord::compare
