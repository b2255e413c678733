#pragma once

#include <set>
#include <string>
#include <vector>

#include "compare/nightly/history.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"

namespace concord::compare::nightly {

/// What the page of a night is made of.
struct NightPage {
  const NightReport& report;  // with its code
  Night night;                // finished or not
  Judging judging;            // what counts as a step between two nights
  int last = 100;             // nights that are shown, this one included
  std::vector<std::string> notes;
  /// Pages of single cases that stand beside it, see page_name_of().
  std::set<std::string> pages = {};
};

/// A night as one HTML page that needs nothing else: verdict, changes, all cases, and each case over the nights of the
/// suite before it, with the commits before and after each step. A night of so many cases that the page would be large
/// shows fewer nights, and says so. The same history gives the same bytes. Throws DatabaseError.
std::string format_night_page(const NightPage& page, History& history);

}  // namespace concord::compare::nightly
