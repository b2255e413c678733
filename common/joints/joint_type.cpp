#include "common/joints/joint_type.h"

namespace concord::joints {

int JointType::rows() const {
  int count = 0;
  for (const Forbid& word : forbids) count += joints::rows(word);
  return count;
}

int JointType::nonholonomic_rows() const {
  int count = 0;
  for (const ForbidSpeed& word : forbids_speeds) count += joints::rows(word);
  return count;
}

int JointType::n_q() const {
  int count = 0;
  for (const Permit& word : permits) count += joints::n_q(word);
  return count;
}

int JointType::n_u() const {
  int count = 0;
  for (const Permit& word : permits) count += joints::n_u(word);
  return count;
}

}  // namespace concord::joints
