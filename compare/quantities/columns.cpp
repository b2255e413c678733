#include "compare/quantities/columns.h"

#include <fmt/format.h>

#include <array>

namespace concord::compare {

namespace {

constexpr std::array<const char*, 3> kAxisNames{"x", "y", "z"};

/// One unit for each number of a joint's coordinates or speeds; which count and which unit, the members say.
std::vector<std::string> unit_list(const joints::JointType& type, int joints::KindFacts::*count,
                                   const char* joints::KindFacts::*unit) {
  std::vector<std::string> units;
  for (const joints::Permit& word : type.permits) {
    for (const joints::StatedCoordinate& one : stated_coordinates(word)) {
      const joints::KindFacts facts = joints::facts_of(one.kind);
      units.insert(units.end(), static_cast<std::size_t>(facts.*count), facts.*unit);
    }
  }
  return units;
}

const char* wrench_unit(int component) { return component < 3 ? "N" : "N m"; }

const char* side_name(Side side) { return side == Side::child ? "child" : "parent"; }

/// "F_x" ... of a wrench column, which stands at the end of its name; any other after the owner's name.
std::string component_of(const Column& column) { return column.name.substr(column.name.rfind('.') + 1); }

/// Columns of one kind for one owner.
class ColumnList {
 public:
  void add_xyz(Field field, int owner, const std::string& prefix, const char* unit) {
    for (int c = 0; c < 3; ++c) columns.push_back({prefix + kAxisNames[c], unit, field, owner, Side::child, c});
  }
  void add_numbered(Field field, int owner, const std::string& prefix, const std::vector<std::string>& units) {
    for (std::size_t k = 0; k < units.size(); ++k) {
      columns.push_back({fmt::format("{}{}", prefix, k + 1), units[k], field, owner, Side::child, static_cast<int>(k)});
    }
  }
  void add_wrench(Field field, int owner, Side side, const std::string& prefix) {
    for (int c = 0; c < 6; ++c) {
      columns.push_back({prefix + component_names()[c], wrench_unit(c), field, owner, side, c});
    }
  }

  std::vector<Column> columns;
};

const Wrench& wrench_of(const Column& column, const Evaluation& evaluation) {
  const auto owner = static_cast<std::size_t>(column.owner);
  switch (column.field) {
    case Field::reaction:
      return evaluation.joints.at(owner).reaction_on(column.side).in_C;
    case Field::reaction_global:
      return evaluation.joints.at(owner).reaction_on(column.side).in_global;
    case Field::total:
      return evaluation.joints.at(owner).total_on(column.side).in_C;
    case Field::total_global:
      return evaluation.joints.at(owner).total_on(column.side).in_global;
    case Field::element:
      return evaluation.elements.at(owner).on_side(column.side).in_C;
    default:
      return evaluation.elements.at(owner).on_side(column.side).in_global;
  }
}

}  // namespace

std::vector<std::string> coordinate_units(const joints::JointType& type) {
  return unit_list(type, &joints::KindFacts::n_q, &joints::KindFacts::unit_of_q);
}

std::vector<std::string> speed_units(const joints::JointType& type) {
  return unit_list(type, &joints::KindFacts::n_u, &joints::KindFacts::unit_of_u);
}

std::vector<std::string> speed_force_units(const joints::JointType& type) {
  return unit_list(type, &joints::KindFacts::n_u, &joints::KindFacts::unit_of_tau);
}

double value_of(const Column& column, const Sample& sample) {
  const auto owner = static_cast<std::size_t>(column.owner);
  const int c = column.component;
  switch (column.field) {
    case Field::position:
      return sample.state.bodies.at(owner).r(c);
    case Field::euler_parameter:
      return sample.state.bodies.at(owner).p(c);
    case Field::velocity:
      return sample.state.bodies.at(owner).v(c);
    case Field::angular_velocity:
      return sample.state.bodies.at(owner).omega(c);
    case Field::acceleration:
      return sample.evaluation.bodies.at(owner).vdot(c);
    case Field::angular_acceleration:
      return sample.evaluation.bodies.at(owner).omegadot(c);
    case Field::modal_coordinate:
      return sample.state.bodies.at(owner).a(c);
    case Field::modal_velocity:
      return sample.state.bodies.at(owner).adot(c);
    case Field::modal_acceleration:
      return sample.evaluation.bodies.at(owner).addot(c);
    case Field::joint_coordinate:
      return sample.state.q.at(owner)(c);
    case Field::tau:
      return sample.evaluation.joints.at(owner).tau(c);
    case Field::share:
      return sample.evaluation.joints.at(owner).share_of(column.actor)(c);
    case Field::coupling:
      return sample.evaluation.couplings.at(owner);
    default:
      return wrench_of(column, sample.evaluation).vector()(c);
  }
}

std::vector<Column> motion_columns(const Model& model) {
  ColumnList list;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const int owner = static_cast<int>(i);
    const std::string name = model.bodies[i].name + ".";
    const auto modal = [&](const char* unit) {
      return std::vector<std::string>(static_cast<std::size_t>(model.bodies[i].n_modes()), unit);
    };
    list.add_xyz(Field::position, owner, name, "m");
    for (int c = 0; c < 4; ++c) {
      list.columns.push_back({fmt::format("{}e{}", name, c), "1", Field::euler_parameter, owner, Side::child, c});
    }
    list.add_xyz(Field::velocity, owner, name + "v_", "m/s");
    list.add_xyz(Field::angular_velocity, owner, name + "omega_", "rad/s");
    list.add_xyz(Field::acceleration, owner, name + "vdot_", "m/s2");
    list.add_xyz(Field::angular_acceleration, owner, name + "omegadot_", "rad/s2");
    list.add_numbered(Field::modal_coordinate, owner, name + "a_", modal("1"));
    list.add_numbered(Field::modal_velocity, owner, name + "adot_", modal("1/s"));
    list.add_numbered(Field::modal_acceleration, owner, name + "addot_", modal("1/s2"));
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    list.add_numbered(Field::joint_coordinate, static_cast<int>(k), joint.name + ".q_", coordinate_units(*joint.type));
  }
  return std::move(list.columns);
}

std::vector<Column> reaction_columns(const Model& model) {
  ColumnList list;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const int owner = static_cast<int>(k);
    for (const Side side : kSides) {
      list.add_wrench(Field::reaction, owner, side, fmt::format("{}.{}.", joint.name, side_name(side)));
    }
    const std::vector<std::string> units = speed_force_units(*joint.type);
    list.add_numbered(Field::tau, owner, joint.name + ".tau_", units);
    for (int speed = 0; speed < static_cast<int>(units.size()); ++speed) {
      for (const Actor actor : actors_on(joint, speed)) {
        list.columns.push_back({fmt::format("{}.{}_{}", joint.name, name_of(actor), speed + 1),
                                units[static_cast<std::size_t>(speed)], Field::share, owner, Side::child, speed, actor,
                                !is_shared(model, owner, speed)});
      }
    }
  }
  return std::move(list.columns);
}

std::vector<Column> element_columns(const Model& model) {
  ColumnList list;
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    const ForceElement& element = model.elements[k];
    for (const Side side : kSides) {
      if (end_of(element, side) == nullptr) continue;
      list.add_wrench(Field::element, static_cast<int>(k), side, fmt::format("{}.{}.", element.name, side_name(side)));
    }
  }
  return std::move(list.columns);
}

std::vector<Column> further_columns(const Model& model) {
  ColumnList list;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      const std::string prefix = fmt::format("{}.{}.", model.joints[k].name, side_name(side));
      list.add_wrench(Field::reaction_global, static_cast<int>(k), side, prefix + "global.");
      list.add_wrench(Field::total, static_cast<int>(k), side, prefix + "total.");
      list.add_wrench(Field::total_global, static_cast<int>(k), side, prefix + "total_global.");
    }
  }
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    for (const Side side : kSides) {
      if (end_of(model.elements[k], side) == nullptr) continue;
      const std::string prefix = fmt::format("{}.{}.global.", model.elements[k].name, side_name(side));
      list.add_wrench(Field::element_global, static_cast<int>(k), side, prefix);
    }
  }
  for (std::size_t k = 0; k < model.couplings.size(); ++k) {
    const int owner = static_cast<int>(k);
    const std::string unit = unit_of(model, {Kind::coupling, owner, Side::child, 0});
    list.columns.push_back({model.couplings[k].name + ".force", unit, Field::coupling, owner, Side::child, 0});
  }
  return std::move(list.columns);
}

bool may_be_open(const Column& column) { return column.field >= Field::reaction && column.field <= Field::coupling; }

Column own_column(const Column& column) {
  Column own = column;
  own.name = "any_" + column.name;
  own.is_own = true;
  return own;
}

std::optional<Quantity> quantity_of(const Column& column) {
  const auto with = [&](Kind kind, int first) {
    return Quantity{kind, column.owner, column.side, first + column.component};
  };
  switch (column.field) {
    case Field::reaction:
      return with(Kind::reaction, 0);
    case Field::reaction_global:
      return with(Kind::reaction_global, 0);
    case Field::total:
    case Field::total_global:
      return with(Kind::total, 0);
    case Field::tau:
      return with(Kind::tau, 0);
    case Field::share:
      if (column.is_alone) return with(Kind::tau, 0);
      return Quantity{Kind::share, column.owner, column.side, column.component, column.actor};
    case Field::coupling:
      return with(Kind::coupling, 0);
    case Field::element:
    case Field::element_global:
      return with(Kind::element, 0);
    case Field::acceleration:
      return with(Kind::acceleration, 0);
    case Field::angular_acceleration:
      return with(Kind::acceleration, 3);
    case Field::modal_acceleration:
      return with(Kind::acceleration, 6);
    default:
      return std::nullopt;
  }
}

std::string describe_owner(const Model& model, const Column& column) {
  const auto owner = static_cast<std::size_t>(column.owner);
  const std::string joint_or_element = quantity_of(column) ? describe_owner(model, *quantity_of(column)) : "";
  switch (column.field) {
    case Field::total_global:
      return describe_owner(model, Quantity{Kind::reaction, column.owner, column.side, 0}) +
             " (total wrench, global axes)";
    case Field::element_global:
      return joint_or_element + " (global axes)";
    case Field::joint_coordinate:
    case Field::tau:
    case Field::share:
      return fmt::format("joint {}", model.joints.at(owner).name);
    default:
      return quantity_of(column) ? joint_or_element : fmt::format("body {}", model.bodies.at(owner).name);
  }
}

std::string describe_component(const Column& column) { return (column.is_own ? "any_" : "") + component_of(column); }

}  // namespace concord::compare
