#pragma once

#include <string>
#include <utility>

#include "common/error.h"

namespace concord {

/// A solver's own check of what it would report: the wrenches do not hold a body in balance. The text says by how much.
class UnbalancedBody : public SolverError {
 public:
  UnbalancedBody(const std::string& message, std::string body) : SolverError(message), body_(std::move(body)) {}

  [[nodiscard]] const std::string& body() const { return body_; }

 private:
  std::string body_;
};

}  // namespace concord
