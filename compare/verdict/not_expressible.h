#pragma once

#include <stdexcept>

namespace concord::compare {

/// A model has something that the program of the third opinion does not know; the text names it.
class NotExpressible : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace concord::compare
