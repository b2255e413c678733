#pragma once

#include <vector>

#include "common/model.h"

/// The order in which a machine is built from mobilizers.
namespace concord::compare::oracle {

/// One mobilizer to add: that of a joint, or one that lets a body go free because no joint has it as its child.
struct Step {
  int joint = -1;       // -1: free
  int body = 0;         // whose part is added
  bool is_main = true;  // the body itself; else a part of it, to be welded to it
};

/// Every body stands in the plan once as itself, after the parents of the joint that carries it, and once more for
/// each further joint that has it as its child. Joints are taken from parent to child only.
std::vector<Step> plan_of(const Model& model);

/// Into how many parts each body falls: 1 without a loop. Of ground: the number of joints that have it as their child.
std::vector<int> parts_of(const Model& model, const std::vector<Step>& plan);

}  // namespace concord::compare::oracle
