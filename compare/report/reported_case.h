#pragma once

#include <string>

#include "common/model.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// A model that was compared, or why it could not be.
struct ReportedCase {
  std::string name;
  const Model* model = nullptr;  // with `verdict`: both or none
  const Verdict* verdict = nullptr;
  std::string trouble;  // if there is no verdict
  bool is_bad_input = false;
};

}  // namespace concord::compare
