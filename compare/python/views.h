#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <vector>

#include "common/results.h"
#include "common/solver.h"
#include "compare/python/bindings.h"

/// Arrays of NumPy that show numbers where they are, without a copy. Each keeps alive its `owner`, the object that
/// holds the numbers, and nothing that Python can call changes the number of items of an owner: no view outlives its
/// memory.
namespace concord::compare::python {

/// What a view lets Python do with the numbers.
enum class Access { read, write };

/// A view of a block of numbers (shape, steps in bytes) from `first` on; where the shape holds none, an empty array.
template <class Number>
py::array view(py::handle owner, const Number* first, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> steps,
               Access access) {
  for (const py::ssize_t length : shape) {
    if (length == 0) return py::array_t<Number>(shape);
  }
  py::array_t<Number> all(std::move(shape), std::move(steps), first, owner);
  if (access == Access::read) all.attr("setflags")(py::arg("write") = false);
  return all;
}

/// A row of `width` numbers for each item, found by `first`.
template <class Item, class First>
py::array rows_view(py::handle owner, const std::vector<Item>& items, py::ssize_t width, Access access,
                    const First& first) {
  const auto count = static_cast<py::ssize_t>(items.size());
  return view<double>(owner, items.empty() ? nullptr : first(items.front()), {count, width},
                      {sizeof(Item), sizeof(double)}, access);
}

/// Six numbers for each item and side; `first` finds an item's wrench on the parent.
template <class Item, class First>
py::array wrenches_view(py::handle owner, const std::vector<Item>& items, const First& first) {
  static_assert(sizeof(Wrench) == 6 * sizeof(double) && offsetof(Wrench, torque) == 3 * sizeof(double));
  const auto count = static_cast<py::ssize_t>(items.size());
  return view<double>(owner, items.empty() ? nullptr : first(items.front()).force.data(), {count, 2, 6},
                      {sizeof(Item), sizeof(SideWrench), sizeof(double)}, Access::read);
}

/// A list with a view of one vector of each item, found by `pick`.
template <class Item, class Pick>
py::list vectors_view(py::handle owner, const std::vector<Item>& items, Access access, const Pick& pick) {
  py::list all;
  for (const Item& item : items) {
    const VecX& vector = pick(item);
    all.append(view<double>(owner, vector.data(), {static_cast<py::ssize_t>(vector.size())}, {sizeof(double)}, access));
  }
  return all;
}

}  // namespace concord::compare::python
