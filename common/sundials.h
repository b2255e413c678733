#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <memory>
#include <string>

#include "common/types.h"

/// Owners of SUNDIALS handles, and its messages turned into exceptions. All that version 7 will change stands here.
namespace concord::sundials {

/// One context for each integrator, used by one thread.
class Context {
 public:
  Context();

  [[nodiscard]] SUNContext get() const { return context_.get(); }

 private:
  struct Free {
    void operator()(SUNContext context) const;
  };
  std::unique_ptr<std::remove_pointer_t<SUNContext>, Free> context_;
};

struct FreeVector {
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
};
struct FreeMatrix {
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
};
struct FreeLinearSolver {
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
};
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, FreeVector>;
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, FreeMatrix>;
using LinearSolver = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, FreeLinearSolver>;

/// A new vector of n numbers, all zero.
Vector make_vector(Eigen::Index n, const Context& context);

/// The numbers of a serial vector, in place.
inline Eigen::Map<VecX> view(N_Vector vector) {
  return {NV_DATA_S(vector), static_cast<Eigen::Index>(NV_LENGTH_S(vector))};
}

/// Keeps the last message of an integrator instead of letting it reach stderr: pass `record` and the address of the
/// object to CVodeSetErrHandlerFn, ARKStepSetErrHandlerFn, ERKStepSetErrHandlerFn or IDASetErrHandlerFn.
struct MessageRecord {
  std::string last;

  static void record(int code, const char* module, const char* function, char* message, void* self);
};

/// Throws SolverError with the name of the call and the last message if `code` is negative. Positive codes are not
/// errors.
void check(int code, const char* call, const MessageRecord& messages);

/// Throws SolverError if a constructor of SUNDIALS gave nothing.
template <class Handle>
Handle require(Handle handle, const char* call);

[[noreturn]] void throw_no_handle(const char* call);

template <class Handle>
Handle require(Handle handle, const char* call) {
  if (handle == nullptr) throw_no_handle(call);
  return handle;
}

}  // namespace concord::sundials
