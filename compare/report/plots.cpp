#include "compare/report/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "compare/quantities/observe.h"
#include "compare/report/feed_command.h"
#include "compare/report/files.h"
#include "compare/report/told_axes.h"

namespace concord::compare {

namespace {

constexpr int kPanelWidth = 430;  // pixels
constexpr int kPanelHeight = 250;
constexpr int kTitleHeight = 90;

/// A text in gnuplot's single quotes, where nothing but the quote is special.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

std::string style_of(Curve::Style style) {
  switch (style) {
    case Curve::Style::line:
      return "with lines linewidth 1.6 linecolor rgb '#0072b2'";
    case Curve::Style::dots:
      return "with points pointtype 7 pointsize 0.4 linecolor rgb '#d55e00'";
    case Curve::Style::difference:
      break;
  }
  return "with lines linewidth 1.0 linecolor rgb '#333333'";
}

/// Dots stand apart, so that the line under them shows.
std::string every(const Curve& curve) {
  constexpr Eigen::Index kDots = 60;
  if (curve.style != Curve::Style::dots || curve.values.size() <= kDots) return "";
  return fmt::format(" every {}", (curve.values.size() + kDots - 1) / kDots);
}

std::string data_name(std::size_t panel) { return fmt::format("$panel{}", panel); }

/// One block for each panel: abscissa, then a column for each curve.
std::string data_blocks(const Page& page) {
  std::string text;
  for (std::size_t p = 0; p < page.panels.size(); ++p) {
    text += data_name(p) + " << END_OF_DATA\n";
    for (Eigen::Index row = 0; row < page.x.size(); ++row) {
      text += fmt::format("{}", page.x(row));
      for (const Curve& curve : page.panels[p].curves) text += fmt::format(" {}", curve.values(row));
      text += '\n';
    }
    text += "END_OF_DATA\n";
  }
  return text;
}

/// Range of the ordinate where the curves alone would not give a good one, because they are flat or smaller than what
/// matters; says so where they vanish.
std::string range_of(const Panel& panel) {
  double reach = 0.0;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const Curve& curve : panel.curves) {
    if (curve.values.size() == 0) continue;
    lowest = std::min(lowest, curve.values.minCoeff());
    highest = std::max(highest, curve.values.maxCoeff());
    reach = std::max({reach, highest, -lowest});
  }
  std::string text = "unset label\n";
  if (reach == 0.0) text += "set label 'zero throughout' at graph 0.5, 0.6 center textcolor rgb '#666666'\n";
  const bool is_flat = highest - lowest <= 1e-9 * reach;
  if (reach >= panel.least_reach && !is_flat) return text + "set yrange [*:*]\n";
  const double half = reach + panel.least_reach > 0.0 ? std::max(1.2 * reach, panel.least_reach) : 1.0;
  return text + fmt::format("set yrange [{}:{}]\n", -half, half);
}

std::string panel_script(const Page& page, std::size_t p, int rows) {
  const Panel& panel = page.panels[p];
  const bool is_lowest = static_cast<int>(p) / page.columns == rows - 1;
  std::string text = range_of(panel);
  // Above the axis: beside it, wide numbers would push it out of the picture.
  text += fmt::format("set label {} at graph 0, graph 1.07 left noenhanced\n", quoted(panel.y_label));
  text += fmt::format("set xlabel {} noenhanced\n", quoted(is_lowest ? page.x_label : ""));
  text += "plot ";
  for (std::size_t c = 0; c < panel.curves.size(); ++c) {
    const Curve& curve = panel.curves[c];
    const std::string title = curve.label.empty() ? "notitle" : fmt::format("title {} noenhanced", quoted(curve.label));
    text += fmt::format("{}{}{} using 1:{} {} {}", c == 0 ? "" : ", ", data_name(p), every(curve), c + 2,
                        style_of(curve.style), title);
  }
  return text + '\n';
}

std::string script_of(const std::filesystem::path& svg, const Page& page) {
  const int rows = (static_cast<int>(page.panels.size()) + page.columns - 1) / page.columns;
  const int height = kTitleHeight + rows * kPanelHeight;
  std::string text = fmt::format("set terminal svg size {},{} font 'Helvetica,13' background rgb 'white'\n",
                                 page.columns * kPanelWidth, height);
  text += fmt::format("set output {}\n", quoted(svg.string()));
  text += data_blocks(page);
  text += "set grid linecolor rgb '#dddddd' linetype 1\nset border linecolor rgb '#888888'\n";
  text += fmt::format("set key at screen 0.99, screen {:.4f} right top horizontal samplen 2\n", 1.0 - 30.0 / height);
  text += "set tics nomirror textcolor rgb '#333333'\nset format y '%.3g'\n";
  text += fmt::format("set xrange [{}:{}]\n", page.x.minCoeff(), page.x.maxCoeff());
  text += fmt::format(
      "set multiplot layout {},{} rowsfirst title {} noenhanced font ',16' margins screen "
      "{:.4f},{:.4f},{:.4f},{:.4f} spacing screen {:.4f},{:.4f}\n",
      rows, page.columns, quoted(page.title), 80.0 / (page.columns * kPanelWidth),
      1.0 - 20.0 / (page.columns * kPanelWidth), 62.0 / height, 1.0 - 75.0 / height,
      85.0 / (page.columns * kPanelWidth), 60.0 / height);
  for (std::size_t p = 0; p < page.panels.size(); ++p) text += panel_script(page, p, rows);
  return text + "unset multiplot\nunset output\n";
}

/// Feeds a script to gnuplot. False if it does not end well.
bool run_gnuplot(const std::string& script) {
  const FedCommand fed = feed_command("gnuplot 2>/dev/null", script);
  return fed.has_started && fed.status == 0 && fed.has_read;
}

/// gnuplot does not tell of a disk that is full.
bool is_whole(const std::filesystem::path& svg) {
  constexpr std::string_view kEnd = "</svg>";
  std::ifstream file(svg, std::ios::binary | std::ios::ate);
  const auto size = std::min<std::streamoff>(file.tellg(), 64);
  std::string last(static_cast<std::size_t>(std::max<std::streamoff>(size, 0)), '\0');
  file.seekg(-size, std::ios::end);
  file.read(last.data(), size);
  return last.find(kEnd) != std::string::npos;
}

bool has_gnuplot() { return std::system("command -v gnuplot >/dev/null 2>&1") == 0; }

/// A component of the reaction on the child, over the run.
VecX component_of(const Trajectory& trajectory, std::size_t joint, int component, Eigen::Index rows) {
  VecX values(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const JointWrenches& wrenches = trajectory.samples[static_cast<std::size_t>(row)].evaluation.joints[joint];
    values(row) = wrenches.reaction_on(Side::child).in_C.vector()(component);
  }
  return values;
}

}  // namespace

std::optional<std::string> draw_page(const std::filesystem::path& svg, const Page& page) {
  make_folder(svg.parent_path());
  if (!has_gnuplot()) return "no plots: gnuplot is not installed (Debian package gnuplot-nox)";
  UnfinishedFile unfinished(svg);
  if (!run_gnuplot(script_of(unfinished.path(), page))) return fmt::format("no plot {}: gnuplot failed", svg.string());
  if (!is_whole(unfinished.path())) {
    throw std::runtime_error(fmt::format("{}: cannot be written: gnuplot left it unfinished", svg.string()));
  }
  unfinished.finish();
  return std::nullopt;
}

Page reaction_page(const Model& model, std::size_t joint, const std::array<std::string_view, 2>& solvers,
                   const Trajectory& first, const Trajectory& second, std::optional<int> axes) {
  const auto rows = static_cast<Eigen::Index>(std::min(first.samples.size(), second.samples.size()));
  const Joint& machine_joint = model.joints[joint];
  const std::string& child = model.bodies[machine_joint.on(Side::child).body].name;
  Page page;
  page.title = fmt::format("{}: reaction of joint {} ({}) on {}, in {}", model.name, machine_joint.name,
                           machine_joint.type->name, child, words_of(model, axes));
  page.x_label = "t [s]";
  page.x =
      VecX::NullaryExpr(rows, [&](Eigen::Index row) { return first.samples[static_cast<std::size_t>(row)].state.t; });

  std::array<VecX, 6> of_first;
  std::array<VecX, 6> of_second;
  std::array<double, 2> peak{0.0, 0.0};  // of forces and of torques
  for (int c = 0; c < 6; ++c) {
    of_first[c] = component_of(first, joint, c, rows);
    of_second[c] = component_of(second, joint, c, rows);
    if (rows > 0) peak[c / 3] = std::max(peak[c / 3], of_first[c].cwiseAbs().maxCoeff());
  }
  peak[1] = std::max(peak[1], peak[0] * model.length_scale());
  for (const int kind : {0, 1}) {
    const char* unit = kind == 0 ? "N" : "N m";
    for (int c = 3 * kind; c < 3 * kind + 3; ++c) {
      const bool labelled = c == 0;
      page.panels.push_back({fmt::format("{} [{}]", component_names()[c], unit),
                             {{labelled ? std::string(solvers[0]) : "", of_first[c], Curve::Style::line},
                              {labelled ? std::string(solvers[1]) : "", of_second[c], Curve::Style::dots}},
                             1e-6 * peak[kind]});
    }
    for (int c = 3 * kind; c < 3 * kind + 3; ++c) {
      page.panels.push_back({fmt::format("difference of {} [{}]", component_names()[c], unit),
                             {{"", of_second[c] - of_first[c], Curve::Style::difference}},
                             0.0});
    }
  }
  return page;
}

std::optional<std::string> plot_reactions(const std::filesystem::path& folder, const Model& model,
                                          const std::array<std::string_view, 2>& solvers, const Trajectory& first,
                                          const Trajectory& second, std::optional<int> axes) {
  const Trajectory one = axes ? told_run(model, first, *axes) : first;
  const Trajectory other = axes ? told_run(model, second, *axes) : second;
  for (std::size_t joint = 0; joint < model.joints.size(); ++joint) {
    const std::string name = fmt::format("{}.reaction_{}.svg", model.name, model.joints[joint].name);
    if (auto reason = draw_page(folder / name, reaction_page(model, joint, solvers, one, other, axes))) return reason;
  }
  return std::nullopt;
}

}  // namespace concord::compare
