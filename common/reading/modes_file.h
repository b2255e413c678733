#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/flexible/modal_data.h"

namespace concord {

/// Reads a modes file (TOML, `format = 1`; data/README.md explains it): mass points or all their integrals, joint
/// nodes, modal stiffness and damping. Throws InputError with every complaint about the file.
ModalData read_modes_file(const std::filesystem::path& file);

/// The same from text; `file` names it in messages.
ModalData parse_modes(std::string_view text, const std::filesystem::path& file);

/// How a modes file gives the inertia: as mass points, or as all entries of their integrals G.
enum class InertiaForm { mass_points, integrals };

/// The text of a modes file that reads back as the same numbers, digit for digit.
std::string format_modes(const ModalData& data, InertiaForm form);

}  // namespace concord
