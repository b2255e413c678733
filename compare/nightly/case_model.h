#pragma once

#include <string>

#include "common/error.h"
#include "common/model.h"
#include "compare/nightly/case.h"

namespace concord::compare::nightly {

/// The model of a case: the file with the case's parameters, cut joints, needs and start. Throws InputError.
Model model_of(const Case& one);

/// What the suite asks of a model and the model cannot give is refused at the case in the suite.
InputError refusal(const Case& one, const std::string& reason);

}  // namespace concord::compare::nightly
