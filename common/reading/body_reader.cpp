#include "common/reading/body_reader.h"

#include <fmt/format.h>

#include <filesystem>

#include "common/reading/beam_reader.h"
#include "common/reading/model_checks.h"
#include "common/reading/modes_file.h"
#include "common/reading/orientation_reader.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

/// The inertia tensor from 3 principal elements, or from the 6 elements xx, yy, zz, xy, xz, yz.
std::optional<Mat3> read_inertia(const TableReader& table) {
  const auto elements = table.numbers("inertia");
  if (!elements) return std::nullopt;
  if (elements->size() != 3 && elements->size() != 6) {
    table.complain("inertia", fmt::format("'inertia' must be 3 numbers (xx, yy, zz) or 6 (xx, yy, zz, xy, xz, yz), "
                                          "found {}",
                                          elements->size()));
    return std::nullopt;
  }
  const std::vector<double>& I = *elements;
  Mat3 inertia = Vec3(I[0], I[1], I[2]).asDiagonal();
  if (I.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = I[3];
    inertia(0, 2) = inertia(2, 0) = I[4];
    inertia(1, 2) = inertia(2, 1) = I[5];
  }
  if (const auto complaint = complaint_about_inertia(inertia)) {
    table.complain("inertia", fmt::format("'inertia' has {}", *complaint));
    return std::nullopt;
  }
  return inertia;
}

bool read_rigid_inertia(const TableReader& table, Body& body) {
  const bool complete = table.require({"inertia"});
  const auto mass = table.positive_number("mass");
  const auto inertia = read_inertia(table);
  const auto center = table.has("center_of_mass") ? table.vector3("center_of_mass") : Vec3(Vec3::Zero());
  if (!complete || !mass || !inertia || !center) return false;
  body.mass = *mass;
  body.inertia_L = *inertia;
  body.center_of_mass_L = *center;
  return true;
}

/// Path of a modes file as it is found: relative to the folder of the model file.
std::filesystem::path beside(const std::string& model_file, const std::string& path) {
  return std::filesystem::path(model_file).parent_path() / path;
}

std::optional<ModalData> read_modal_data(const TableReader& table) {
  if (const toml::table* beam = table.table("beam")) return read_beam(*beam, table.title(), table.reading());
  const auto path = table.text("modes_file");
  if (!path) return std::nullopt;
  const std::filesystem::path file = beside(table.reading().file, *path);
  std::error_code unknown;
  if (!std::filesystem::exists(file, unknown)) {
    table.complain("modes_file", fmt::format("there is no modes file '{}'", file.generic_string()));
    return std::nullopt;
  }
  try {
    return read_modes_file(file);
  } catch (const InputError& error) {
    const Diagnostic& first = error.diagnostics().front();
    if (first.where.line == 0) {  // about the file as a whole
      table.complain("modes_file", fmt::format("'{}': {}", first.where.file, first.message));
      return std::nullopt;
    }
    auto& complaints = table.reading().complaints;
    complaints.insert(complaints.end(), error.diagnostics().begin(), error.diagnostics().end());
    return std::nullopt;
  }
}

Pose read_pose(const TableReader& start) {
  Pose pose;
  const toml::table* found = start.table("pose");
  if (found == nullptr) return pose;
  const TableReader table(*found, start.title() + ", pose", with_orientation({"origin"}), start.reading());
  pose.r = table.vector3("origin").value_or(pose.r);
  pose.A = read_orientation(table).value_or(pose.A);
  return pose;
}

void read_start(const TableReader& body_table, bool inertia_is_known, Body& body) {
  const int n_modes = body.n_modes();
  body.a_start = VecX::Zero(n_modes);
  body.adot_start = VecX::Zero(n_modes);
  const toml::table* found = body_table.table("start");
  if (found == nullptr) return;
  const TableReader table(*found, body_table.title() + ", start", {"pose", "a", "adot"}, body_table.reading());
  if (table.has("pose")) body.pose_guess = read_pose(table);
  if (!inertia_is_known) return;
  for (const std::string_view key : {"a", "adot"}) {
    if (!table.has(key)) continue;
    if (n_modes == 0) {
      table.complain(key, fmt::format("a rigid body has no modal coordinates: '{}' has no place here", key));
    } else if (const auto values = table.vector(key, n_modes)) {
      (key == "a" ? body.a_start : body.adot_start) = *values;
    }
  }
}

}  // namespace

BodyReading read_body(const toml::table& found, FileReading& reading) {
  const TableReader table(found, title_with_name(found, "body"),
                          {"name", "mass", "center_of_mass", "inertia", "beam", "modes_file", "start"}, reading);
  BodyReading result;
  Body& body = result.body;
  body.where = table.where();
  body.name = table.name();
  result.is_flexible = table.has("beam") || table.has("modes_file");
  if (table.require_one_of({"mass", "beam", "modes_file"})) {
    if (result.is_flexible) {
      for (const std::string_view key : {"center_of_mass", "inertia"}) {
        if (table.has(key)) table.complain(key, fmt::format("'{}' follows from the flexible body: leave it out", key));
      }
      body.modal = read_modal_data(table);
      result.is_usable = body.modal.has_value();
    } else {
      result.is_usable = read_rigid_inertia(table, body);
    }
  }
  read_start(table, result.is_usable || !result.is_flexible, body);
  return result;
}

}  // namespace concord
