#include "common/sundials.h"

#include <fmt/format.h>

#include "common/error.h"

namespace concord::sundials {

Context::Context() {
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) throw_no_handle("SUNContext_Create");
  context_.reset(context);
}

void Context::Free::operator()(SUNContext context) const { SUNContext_Free(&context); }

Vector make_vector(Eigen::Index n, const Context& context) {
  Vector vector(require(N_VNew_Serial(n, context.get()), "N_VNew_Serial"));
  N_VConst(0.0, vector.get());
  // Sums of many stages in one pass; vectors made like this one inherit it.
  if (N_VEnableLinearCombination_Serial(vector.get(), SUNTRUE) != 0)
    throw_no_handle("N_VEnableLinearCombination_Serial");
  return vector;
}

void MessageRecord::record(int code, const char* /*module*/, const char* /*function*/, char* message, void* self) {
  if (code < 0) static_cast<MessageRecord*>(self)->last = message;
}

void check(int code, const char* call, const MessageRecord& messages) {
  if (code >= 0) return;
  throw SolverError(fmt::format("{} returned {}: {}", call, code, messages.last));
}

void throw_no_handle(const char* call) { throw SolverError(fmt::format("{} gave no handle: out of memory?", call)); }

}  // namespace concord::sundials
