#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"

/// Pictures as SVG, drawn by gnuplot in a process of its own. The same numbers give the same bytes.
namespace concord::compare {

/// Values over the page's common abscissa, drawn as a line or as dots.
struct Curve {
  enum class Style { line, dots, difference };

  std::string label;  // empty: not in the legend
  VecX values;
  Style style = Style::line;
};

struct Panel {
  std::string y_label;  // with its unit; stands above the axis
  std::vector<Curve> curves;
  /// The ordinate reaches at least this far up and down, so that round-off is not blown up to full height.
  double least_reach = 0.0;
};

struct Page {
  std::string title;
  std::string x_label;
  VecX x;
  int columns = 3;
  std::vector<Panel> panels;  // row by row
};

/// Draws a page to an SVG file, written under a temporary name and renamed. Returns nothing if it stands there, else
/// the reason in plain words (gnuplot is not installed, or it failed): no picture is no error. Throws InputError if the
/// place cannot be written.
std::optional<std::string> draw_page(const std::filesystem::path& svg, const Page& page);

/// The page of one joint: the six reaction components on the child in its joint frame, `first` as a line and `second`
/// as dots, and below each the difference, because two curves that agree cannot be told apart. Rows that only one of
/// the runs has are left out. `axes`: those of the runs, if other ones than the joint frame's.
Page reaction_page(const Model& model, std::size_t joint, const std::array<std::string_view, 2>& solvers,
                   const Trajectory& first, const Trajectory& second, std::optional<int> axes = {});

/// Draws the page of every joint to `folder`/`model name`.reaction_`joint`.svg, with reactions in the `axes` of a body
/// if they are wanted there. Returns as draw_page().
std::optional<std::string> plot_reactions(const std::filesystem::path& folder, const Model& model,
                                          const std::array<std::string_view, 2>& solvers, const Trajectory& first,
                                          const Trajectory& second, std::optional<int> axes = {});

}  // namespace concord::compare
