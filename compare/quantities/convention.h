#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/quantities/columns.h"

/// In which convention a table from outside tells reactions of joints.
namespace concord::compare {

/// What is told of a joint's reaction; what is not set is as the names of the columns say.
struct Convention {
  std::optional<Side> side;           // on which body it acts, at that side's joint frame
  std::optional<bool> in_world_axes;  // else in the axes of the side's joint frame
  std::optional<bool> with_driver;    // the total wrench, with the forces on the joint's own coordinates
  std::optional<bool> opposite;       // minus what acts on that side

  bool operator==(const Convention&) const = default;
};

/// Of joints by their name; "" is the one of all others.
using Conventions = std::map<std::string, Convention>;

/// Whether a column is a component of a joint's wrench, of which there are conventions.
bool has_convention(const Column& column);

/// The column of the same component, at the same joint, in another convention; one without conventions as it is.
Column in_convention(const Column& column, const Convention& convention);

/// -1 if a column's numbers have the other sign in a convention, else 1.
double sign_in(const Column& column, const Convention& convention);

/// Lines of a header that say it: "# side = parent", "# axes = world"; of one joint "# side D = parent".
std::vector<std::string> header_lines(const Convention& convention, const std::string& joint);

/// Puts what a header says of `word` into a convention: "side", "parent". False: no such word or value.
bool say(const std::string& word, const std::string& value, Convention& convention);

/// The words: "side", "axes", "driver", "sign", each with its two values.
std::string words_of_conventions();

/// All that set each of the four, 16.
std::vector<Convention> all_conventions();

}  // namespace concord::compare
