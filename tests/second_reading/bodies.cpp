#include "tests/second_reading/bodies.h"

#include <stdexcept>

#include "tests/second_reading/places.h"

namespace concord::second_reading {

namespace {

void hold_start_of_body(const Body& body, const StatedTable& table) {
  const auto start = table.table("start");
  const auto pose = start ? start->table("pose") : std::nullopt;
  if (table.ledger().both_have(table.entry("start.pose"), body.pose_guess.has_value(), pose.has_value())) {
    pose->hold_vector("origin", body.pose_guess->r);
    hold_frame(table.ledger(), pose->entry("frame"), body.pose_guess->A, frame_of(*pose).value_or(StatedFrame{}));
  }
  const auto hold_modal = [&](const char* key, const VecX& read) {
    const auto stated = start ? start->numbers(key) : std::nullopt;
    Entry entry = start ? start->entry(key) : table.entry(std::string("start.") + key);
    table.ledger().numbers(entry, read, stated ? column_of(*stated) : VecX(VecX::Zero(body.n_modes())));
  };
  hold_modal("a", body.a_start);
  hold_modal("adot", body.adot_start);
}

}  // namespace

Mat3 tensor_of(const std::vector<double>& numbers) {
  if (numbers.size() != 3 && numbers.size() != 6) throw std::runtime_error("an inertia of neither 3 nor 6 numbers");
  Mat3 tensor = Mat3::Zero();
  for (int k = 0; k < 3; ++k) tensor(k, k) = numbers[static_cast<std::size_t>(k)];
  if (numbers.size() == 6) {
    tensor(0, 1) = tensor(1, 0) = numbers[3];
    tensor(0, 2) = tensor(2, 0) = numbers[4];
    tensor(1, 2) = tensor(2, 1) = numbers[5];
  }
  return tensor;
}

void hold_body(const Body& body, const StatedTable& table) {
  Ledger& ledger = table.ledger();
  const auto beam = table.table("beam");
  const bool is_flexible = beam || table.has("modes_file");
  table.hold_number("mass", body.mass, 0.0);
  table.hold_vector("center_of_mass", body.center_of_mass_L);
  const auto inertia = table.numbers("inertia");
  ledger.numbers(table.entry("inertia"), body.inertia_L, inertia ? tensor_of(*inertia) : Mat3(Mat3::Zero()));
  hold_start_of_body(body, table);
  const Entry entry = table.entry(beam ? "beam" : "modes_file");
  if (!ledger.both_have(entry, body.modal.has_value(), is_flexible)) return;
  if (ledger.both_have(table.entry("beam"), body.modal->beam != nullptr, beam.has_value())) {
    hold_beam(*body.modal, *beam);
  }
  if (!beam) hold_modes_file(body, table);
}

}  // namespace concord::second_reading
