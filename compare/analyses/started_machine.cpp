#include "compare/analyses/started_machine.h"

#include "compare/analyses/judge.h"
#include "compare/verdict/near_parallel.h"

namespace concord::compare::analyses {

StartedMachine::StartedMachine(const Model& given, const SolverMakers& makers) : near_(given) {
  std::string start;
  model_ = as_it_starts(near_.model(), makers, start);
  std::string branch;
  try {
    solvers_ = make_solvers_on_one_branch(model_, makers, branch);
  } catch (const InputError& error) {
    throw explained(error, model_);
  }
  for (const std::string& note : {near_.note(), start, branch}) {
    if (!note.empty()) notes_.push_back(note);
  }
}

}  // namespace concord::compare::analyses
