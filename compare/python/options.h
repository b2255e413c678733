#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/model.h"
#include "compare/verdict/verify.h"

namespace concord::compare::python {

/// What Python says of a run; what is missing comes from the model.
struct AskedRun {
  std::optional<double> until;
  std::optional<double> rtol;
  std::optional<long> samples;
};

/// The same for the comparator. Throws InputError that names what is out of the ranges of the command line.
VerifyOptions verify_options(const Model& model, const AskedRun& asked, const std::array<std::string, 2>& integrators);

/// Throws InputError about a call for the model.
[[noreturn]] void refuse(const Model& model, const std::string& why);

/// Whether `name` is the Cartesian solver; throws InputError where it is none of the two.
bool is_cartesian(const Model& model, const std::string& name);

}  // namespace concord::compare::python
