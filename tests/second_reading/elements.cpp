#include <stdexcept>

#include "common/overloaded.h"
#include "tests/second_reading/laws.h"
#include "tests/second_reading/places.h"
#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

namespace {

void hold_load(const Model& model, const Load& load, const StatedTable& table) {
  hold_place(model, table, load.at);
  table.hold_vector("force", load.force);
  table.hold_vector("torque", load.torque);
  const bool is_global = load.axes == LoadAxes::global;
  table.hold_word("axes", is_global ? "global" : load.axes == LoadAxes::body ? "body" : "follower", "global");
  if (table.has("law")) {
    hold_law_of_time(load.law, table, "law");
    return;
  }
  const TimeFunctionValue now = evaluate(load.law, 0.0);
  const TimeFunctionValue later = evaluate(load.law, 1.0);
  table.ledger().numbers(table.entry("law"), Vec3(now.f, later.f, later.fdot), Vec3(1.0, 1.0, 0.0));
}

/// Forces and torques have units of their own: each quarter of a matrix is a group.
void hold_quarters(const StatedTable& table, const std::string& key, const Mat6& read) {
  const MatX stated = table.matrix(key).value_or(MatX::Zero(6, 6));
  if (stated.rows() != 6 || stated.cols() != 6) throw std::runtime_error(key + ": not six numbers");
  const MatX symmetric = 0.5 * (stated + stated.transpose());
  const auto size_of = [&](int row, int column) { return stated.block<3, 3>(row, column).cwiseAbs().maxCoeff(); };
  for (int row = 0; row < 6; row += 3) {
    for (int column = 0; column < 6; column += 3) {
      const double size = std::max(size_of(row, column), std::sqrt(size_of(row, row) * size_of(column, column)));
      table.ledger().numbers(table.entry(key), MatX(read.block<3, 3>(row, column)),
                             MatX(symmetric.block<3, 3>(row, column)), kRoundOff, size);
    }
  }
}

void hold_bushing(const Model& model, const Bushing& bushing, const StatedTable& table) {
  hold_sides(model, table, bushing.ends);
  hold_quarters(table, "stiffness", bushing.stiffness);
  hold_quarters(table, "damping", bushing.damping);
  const VecX preload = column_of(table.numbers("preload").value_or(std::vector<double>(6, 0.0)));
  if (preload.size() != 6) throw std::runtime_error("preload: not six numbers");
  table.ledger().numbers(table.entry("preload"), bushing.preload.head<3>(), preload.head<3>());
  table.ledger().numbers(table.entry("preload"), bushing.preload.tail<3>(), preload.tail<3>());
}

void hold_tire(const Model& model, const Tire& tire, const StatedTable& table) {
  hold_place(model, table, tire.wheel);
  table.hold_number("radius", tire.radius);
  table.hold_number("stiffness", tire.stiffness);
  table.hold_number("damping", tire.damping, 0.0);
  table.hold_number("slip_stiffness", tire.slip_stiffness);
  table.hold_number("cornering_stiffness", tire.cornering_stiffness);
  table.hold_number("friction", tire.friction);
  table.hold_number("speed_scale", tire.speed_scale, 0.1);
  const std::string road = table.reference(Names::roads, "road");
  table.ledger().word(table.entry("road"), tire.road ? tire.road->name : "", road);
}

std::string kind_of(const ForceElement& element) { return kElementTables.at(element.what.index()); }

}  // namespace

void hold_road(const Road& road, const StatedTable& table) {
  constexpr std::array profiles{"flat", "half_sine", "table"};
  table.hold_word("profile", profiles.at(road.profile.index()), "");
  if (table.text("profile") != profiles.at(road.profile.index())) return;
  std::visit(Overloaded{[&](const FlatRoad& flat) { table.hold_number("height", flat.height, 0.0); },
                        [&](const HalfSineBump& bump) {
                          table.hold_number("start", bump.start);
                          table.hold_number("length", bump.length);
                          table.hold_number("height", bump.height);
                        },
                        [&](const RoadTable& points) {
                          const VecX x = column_of(table.numbers("x").value());
                          table.ledger().numbers(table.entry("x"), column_of(points.spline.times()), x);
                          table.ledger().numbers(table.entry("height"), column_of(points.spline.values()),
                                                 column_of(table.numbers("height").value()));
                          table.ledger().number(table.entry("x"), points.first, x(0));
                          table.ledger().number(table.entry("x"), points.last, x(x.size() - 1));
                        }},
             road.profile);
}

void hold_element(const Model& model, const ForceElement& element, const StatedTable& table, const std::string& kind) {
  table.ledger().word(table.entry("kind"), kind_of(element), kind);
  if (kind_of(element) != kind) return;
  const auto hold_spring = [&](const auto& spring) {
    hold_sides(model, table, spring.ends);
    hold_force_law(spring.law, table);
  };
  std::visit(Overloaded{[&](const Load& load) { hold_load(model, load, table); },
                        [&](const LineSpring& spring) { hold_spring(spring); },
                        [&](const TurnSpring& spring) { hold_spring(spring); },
                        [&](const Bushing& bushing) { hold_bushing(model, bushing, table); },
                        [&](const Tire& tire) { hold_tire(model, tire, table); }},
             element.what);
}

}  // namespace concord::second_reading
