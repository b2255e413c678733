#pragma once

#include <string>

/// What a disagreement looks like, so that the reader knows where to search first.
namespace concord::compare {

class QuantityLayout;
struct Series;

/// One line on a failing row of a series (a reaction, total wrench, driver force, acceleration or sum), such as
/// "same size, opposite sign in all 300 samples: check side, point and frame before the dynamics". A pattern is named
/// if it explains 99.9 % of the difference: one solver gives zero; opposite sign; factor two, or another constant
/// factor; components in global axes or in the other side's joint frame; one frame turned against the other by a
/// constant rotation; torque about another point; same size, other direction.
std::string diagnose(const QuantityLayout& layout, const Series& series, int row);

}  // namespace concord::compare
