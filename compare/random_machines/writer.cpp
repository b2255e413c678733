#include "compare/random_machines/writer.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/joints/named_coordinates.h"
#include "compare/random_machines/laws.h"

namespace concord::compare::fuzz {

namespace {

bool is_unturned(const Vec4& p) { return p == Vec4::Unit(0); }

Entries end_entries(const Machine& machine, const End& end, bool has_frame) {
  Entries entries{{"body", fmt::format("\"{}\"", machine.bodies[end.body].name)}};
  if (const auto& flexible = machine.bodies[end.body].flexible) {
    entries.push_back({"node", fmt::format("\"{}\"", flexible->node_names[end.node])});
    const Vec3 offset = end.point - flexible->nodes[end.node];
    if (!offset.isZero(0.0)) entries.push_back({"offset", list_text(offset)});
  } else if (!end.point.isZero(0.0)) {
    entries.push_back({"point", list_text(end.point)});
  }
  if (has_frame && !is_unturned(end.p)) entries.push_back({"euler_parameters", list_text(end.p)});
  return entries;
}

std::string end_text(const Machine& machine, const End& end, bool has_frame) {
  return inline_text(end_entries(machine, end, has_frame));
}

class Writer {
 public:
  explicit Writer(const Machine& machine) : machine_(machine) {}

  ModelText write() {
    line("format = 1");
    line(fmt::format("name = \"{}\"", machine_.name));
    if (!machine_.gravity.isZero(0.0)) line("gravity = " + list_text(machine_.gravity));
    for (std::size_t i = 1; i < machine_.bodies.size(); ++i) write_body(machine_.bodies[i]);
    for (const JointPlan& joint : machine_.joints) write_joint(joint);
    for (const CouplingPlan& coupling : machine_.couplings) write_coupling(coupling);
    for (const ElementPlan& element : machine_.elements) write_element(element);
    line("\n[run]");
    line("until = " + number_text(machine_.until));
    return std::move(text_);
  }

 private:
  void line(const std::string& text) { text_.model += text + '\n'; }
  void entries(const Entries& all) {
    for (const Entry& entry : all) line(fmt::format("{} = {}", entry.key, entry.value));
  }

  void write_body(const BodyPlan& body) {
    line("\n[[body]]");
    line(fmt::format("name = \"{}\"", body.name));
    if (!body.flexible) {
      line("mass = " + number_text(body.mass));
      if (!body.center_of_mass.isZero(0.0)) line("center_of_mass = " + list_text(body.center_of_mass));
      const bool is_diagonal = body.inertia.tail<3>().isZero(0.0);
      line("inertia = " + (is_diagonal ? list_text(body.inertia.head<3>()) : list_text(body.inertia)));
      return;
    }
    const Flexible& flexible = *body.flexible;
    if (flexible.beam.empty()) {
      const std::string file = fmt::format("{}.{}.modes.toml", machine_.name, body.name);
      line(fmt::format("modes_file = \"{}\"", file));
      text_.beside.emplace_back(file, flexible.modes_file);
    }
    if (!flexible.a.isZero(0.0)) line("start.a = " + list_text(flexible.a));
    if (!flexible.adot.isZero(0.0)) line("start.adot = " + list_text(flexible.adot));
    if (flexible.beam.empty()) return;
    line("\n[body.beam]");
    entries(flexible.beam);
  }

  void write_joint(const JointPlan& joint) {
    line("\n[[joint]]");
    line(fmt::format("name = \"{}\"", joint.name));
    line(fmt::format("type = \"{}\"", joint.type->name));
    for (std::size_t k = 0; k < joint.parameters.size(); ++k) {
      line(fmt::format("{} = {}", joint.type->parameters[k].name, number_text(joint.parameters[k])));
    }
    if (joint.named_as_cut) line("cut = true");
    line("parent = " + end_text(machine_, joint.ends[0], true));
    line("child = " + end_text(machine_, joint.ends[1], true));
    const std::vector<NamedCoordinate> named = named_coordinates(*joint.type);
    for (std::size_t k = 0; k < named.size(); ++k) {
      const CoordinatePlan& coordinate = joint.coordinates[k];
      if (coordinate.drive.empty()) write_start(joint, named[k]);
      if (!coordinate.drive.empty()) line(fmt::format("drive.{} = {}", named[k].name, inline_text(coordinate.drive)));
      if (!coordinate.spring.empty()) {
        line(fmt::format("spring.{} = {}", named[k].name, inline_text(coordinate.spring)));
      }
    }
  }

  void write_start(const JointPlan& joint, const NamedCoordinate& named) {
    const int q = first_q(*joint.type, named.word) + named.component;
    const int u = first_u(*joint.type, named.word) + named.component;
    const bool is_ball = named.kind == joints::CoordinateKind::orientation;
    const std::string place =
        is_ball ? inline_text({{"euler_parameters", list_text(joint.q.segment<4>(q))}}) : number_text(joint.q(q));
    const std::string speed = is_ball ? list_text(joint.u.segment<3>(u)) : number_text(joint.u(u));
    line(fmt::format("start.{} = {{ {} = {}, {} = {} }}", named.name, joint.keeps_q[named.word] ? "keep" : "guess",
                     place, joint.keeps_u[named.word] ? "keep_speed" : "guess_speed", speed));
  }

  void write_coupling(const CouplingPlan& coupling) {
    line("\n[[coupling]]");
    line(fmt::format("name = \"{}\"", coupling.name));
    std::string terms;
    for (const TermPlan& term : coupling.terms) {
      const JointPlan& joint = machine_.joints[term.joint];
      const NamedCoordinate named = named_coordinates(*joint.type)[term.coordinate];
      terms += fmt::format("{}{{ joint = \"{}\", coordinate = \"{}\", factor = {} }}", terms.empty() ? "" : ", ",
                           joint.name, named.name, number_text(term.factor));
    }
    line("terms = [" + terms + "]");
    line("offset = " + number_text(coupling.offset));
  }

  void write_element(const ElementPlan& element) {
    if (!element.road.empty()) {
      line("\n[[road]]");
      line(fmt::format("name = \"{}_road\"", element.name));
      entries(element.road);
    }
    line(fmt::format("\n[[{}]]", element.table));
    line(fmt::format("name = \"{}\"", element.name));
    if (!element.road.empty()) line(fmt::format("road = \"{}_road\"", element.name));
    if (element.parent) {
      line("parent = " + end_text(machine_, *element.parent, element.has_frame));
      line("child = " + end_text(machine_, element.child, element.has_frame));
    } else {
      entries(end_entries(machine_, element.child, element.has_frame));
    }
    entries(element.entries);
  }

  const Machine& machine_;
  ModelText text_;
};

}  // namespace

ModelText write_machine(const Machine& machine) { return Writer(machine).write(); }

std::string pack(const ModelText& text) { return nlohmann::json::array({text.model, text.beside}).dump(); }

ModelText unpack(const std::string& packed) {
  const nlohmann::json parts = nlohmann::json::parse(packed);
  return {parts.at(0), parts.at(1)};
}

}  // namespace concord::compare::fuzz
