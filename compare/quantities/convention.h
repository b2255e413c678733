#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/columns.h"

/// In which convention a table from outside tells reactions of joints.
namespace concord::compare {

/// What is told of a joint's reaction: on which body it acts; in axes of the joint frame on that side, of the world or
/// of that body; its torque about the joint's point on that body or on the other one; without or with the forces on the
/// joint's own coordinates (the total wrench); as what acts on that body, or as its opposite.
enum class ConventionWord { side, axes, point, driver, sign };

/// The value of each word, by its number in the order above; what is not set is as the names of the columns say.
using Convention = std::array<std::optional<int>, 5>;

/// Of joints by their name; "" is the one of all others.
using Conventions = std::map<std::string, Convention>;

/// What is stated of a joint, word by word, and, where that says nothing, of all.
Convention stated_of(const std::string& joint, const Conventions& stated);

/// Whether a column is a component of a joint's wrench, of which there are conventions.
bool has_convention(const Column& column);

/// The column of the same component, at the same joint, of the side, axes and forces that a convention says; one
/// without conventions as it is. The axes of a body and the other point are no column: re_express() brings a run there.
Column in_convention(const Column& column, const Convention& convention);

/// -1 if a column's numbers have the other sign in a convention, else 1.
double sign_in(const Column& column, const Convention& convention);

/// Whether a convention tells in the axes of bodies, and whether about the other point.
std::array<bool, 2> re_expression_of(const Convention& convention);
inline bool needs_re_expression(const Convention& convention) {
  return re_expression_of(convention) != std::array<bool, 2>{};
}

/// Brings the wrenches of one joint, in the frames of its sides and in world axes, about the other side's point, and
/// those in the frames of its sides into the axes of the bodies, as far as the convention says so. NaN goes to the
/// components that have a part of it.
void re_express(const Joint& joint, const Convention& convention, const State& state, JointWrenches& wrenches);

/// Lines of a header that say it: "# side = parent", "# axes = world"; of one joint "# side D = parent".
std::vector<std::string> header_lines(const Convention& convention, const std::string& joint);

/// Puts what a header says of `word` into a convention: "side", "parent". False: no such word or value.
bool say(const std::string& word, const std::string& value, Convention& convention);

/// Whether a header may say it.
bool is_convention_word(const std::string& word);

/// The words with their values.
std::string words_of_conventions();

/// All that set every word.
std::vector<Convention> all_conventions();

}  // namespace concord::compare
