#pragma once

#include <exception>
#include <ostream>

#include "common/error.h"
#include "compare/commands.h"

namespace concord::compare {

/// Runs `work` and turns what it throws into a message and an exit code.
template <class Work>
int guarded(const Console& console, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    console.err << error.what() << '\n';
    return kBadInput;
  } catch (const SolverError& error) {
    console.err << error.what() << '\n';
    return kCouldNotFinish;
  } catch (const std::exception& error) {
    console.err << "could not finish: " << error.what() << '\n';
    return kCouldNotFinish;
  }
}

}  // namespace concord::compare
