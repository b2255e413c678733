#pragma once

#include <memory>

#include "common/model.h"
#include "compare/quantities/third_opinion.h"

namespace concord::compare::oracle {

/// Simbody's opinion of a model, which must outlive it: its accelerations and wrenches, with force elements and springs
/// in joints as the laws of the comparator's own say. Throws NotExpressible, naming what Simbody does not know.
std::unique_ptr<ThirdOpinion> make_simbody(const Model& model);

}  // namespace concord::compare::oracle
