#include "compare/python/options.h"

#include <fmt/format.h>

#include <cmath>

#include "common/reading/magnitude.h"

namespace concord::compare::python {

namespace {

constexpr long kMostSamples = 1000000;

}  // namespace

void refuse(const Model& model, const std::string& why) { throw InputError({model.file, 0, 0}, why); }

VerifyOptions verify_options(const Model& model, const AskedRun& asked, const std::array<std::string, 2>& integrators) {
  VerifyOptions options;
  options.integrators = integrators;
  if (asked.until) {
    const bool fits = std::isfinite(*asked.until) && has_usable_size(*asked.until) && *asked.until > 0.0;
    if (!fits) refuse(model, fmt::format("until must be a finite number above zero, found {:g}", *asked.until));
    options.until = asked.until;
  }
  if (asked.rtol) {
    const bool fits = *asked.rtol >= kTightestTolerance && *asked.rtol <= kLoosestTolerance;
    if (!fits) {
      refuse(model, fmt::format("rtol must lie between {:g} and {:g}, found {:g}", kTightestTolerance,
                                kLoosestTolerance, *asked.rtol));
    }
    options.rtol = asked.rtol;
  }
  if (asked.samples) {
    const bool fits = *asked.samples >= 1 && *asked.samples <= kMostSamples;
    if (!fits) refuse(model, fmt::format("samples must lie between 1 and {}, found {}", kMostSamples, *asked.samples));
    options.samples = static_cast<int>(*asked.samples);
  }
  return options;
}

bool is_cartesian(const Model& model, const std::string& name) {
  if (name != "cartesian" && name != "relative") {
    refuse(model, fmt::format("there is no solver '{}': known solvers: cartesian, relative", name));
  }
  return name == "cartesian";
}

}  // namespace concord::compare::python
