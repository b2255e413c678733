#pragma once

#include <stdexcept>

namespace concord::compare {

/// A model has something that the program of the third opinion does not know; the text names it. Its header includes
/// none of the others: who binds another program may have to be compiled as C++17.
class NotExpressible : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace concord::compare
