#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"

/// Does a model say what its file says? Reads the file anew, from the pages of data/format alone, and holds every
/// number of the model against it. Both solvers and the audit see the model only, so that nothing else can notice a
/// number that was read wrongly.
namespace concord::second_reading {

/// One number, list or name that the file states and that the model has otherwise.
struct StatedValue {
  std::string where;      // "body rod", "joint A", "force spring", "coupling mesh", "run", "need 1", "model"
  std::string key;        // as in the file: "mass", "inertia", "start.turn_z.keep"
  double residual = 0.0;  // largest |read - stated|
  double scale = 1.0;     // what round-off is held against; positive
  std::string text;       // of what is no number, or of another count: "read as 'B', stated 'A'"; else empty
  int line = 0;           // of the file that states it; 0: not known
  std::string file = {};  // that states it: the model's, an include or a modes file; empty: not known
};

/// "body rod, mass: was not read as my.toml says in line 5: off by 1.00e-01, of 2.5"; `file`: the model's.
std::string describe(const StatedValue& value, const std::string& file);

/// What a model does not have as the file says, worst first, and how many numbers and words were held.
struct SecondReading {
  std::vector<StatedValue> differing;
  int held = 0;
  std::vector<std::string> not_held;  // what of the file could not be held: "body rod: foo"
};

/// Reads `file`, with what it includes and its modes files, and holds `model` against it. `parameters`: other values of
/// parameters, as they were given to read_model. Throws nothing for a file that read_model accepts.
SecondReading read_again(const Model& model, const std::filesystem::path& file,
                         const std::map<std::string, double>& parameters = {});

/// The same of a text, as parse_model(text, file).
SecondReading read_again_text(const Model& model, std::string_view text, const std::filesystem::path& file);

}  // namespace concord::second_reading
