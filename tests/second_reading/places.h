#pragma once

#include <optional>
#include <string>

#include "common/model.h"
#include "tests/second_reading/stated_table.h"

namespace concord::second_reading {

/// An orientation that a file states, and what of it the file leaves open: the many turns of a long rotation vector.
struct StatedFrame {
  Mat3 R = Mat3::Identity();
  double doubt = 0.0;
};

/// The frame that the keys of a table give; none without any of these keys.
std::optional<StatedFrame> frame_of(const StatedTable& table);

void hold_frame(Ledger& ledger, const Entry& entry, const Mat3& read, const StatedFrame& stated);

/// Index of the body of that name, or -1.
int body_index(const Model& model, const std::string& name);

/// The place of a load or a tire, whose keys stand among the element's own.
void hold_place(const Model& model, const StatedTable& item, const Attachment& read);

/// Both sides of a joint or of a force element, with what it states of both.
void hold_sides(const Model& model, const StatedTable& item, const std::array<Attachment, 2>& read);

}  // namespace concord::second_reading
