#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/attachment.h"
#include "common/reading/body_reader.h"
#include "common/reading/toml_reader.h"

/// Where joints and force elements sit on their bodies, as model files say it.
namespace concord {

/// Keys of the table of one end, in which `own` keys may stand too: body, point or node and offset, frame.
KnownKeys with_attachment(KnownKeys own);

/// The end that a table says: `body = "crank", point = [...], x = [...], z = [...]`, on a flexible body a `node` and
/// `offset` instead of the point. Nothing if the body is missing or not known.
std::optional<Attachment> read_attachment(const TableReader& table, const std::vector<BodyReading>& bodies);

/// The keys of what connects two bodies, in which `own` keys may stand too.
KnownKeys with_ends(KnownKeys own);

/// The ends `parent` and `child` of a joint or a force element, each the name of a body or a table as for
/// read_attachment, with what `both` says for the two at once. Complains if one of them is missing or both are on the
/// same body. Nothing if a body is missing or not known.
std::optional<std::array<Attachment, 2>> read_ends(const TableReader& owner, const std::vector<BodyReading>& bodies);

}  // namespace concord
