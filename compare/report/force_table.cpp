#include "compare/report/force_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compare/audit/digits.h"
#include "compare/audit/joint_motion.h"
#include "compare/report/table.h"
#include "compare/report/text_table.h"
#include "compare/report/told_axes.h"
#include "compare/verdict/redundant.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

using Line = std::vector<std::string>;

std::string number(double value) { return fmt::format("{:.6g}", value == 0.0 ? 0.0 : value); }  // no -0

/// The peak and its time.
Line peak_cells(const ForcePeak& peak, const std::string& unit = "") {
  if (!peak.exists) return {"-", "-"};
  if (!peak.value) return {"not unique", "-"};
  std::string size = number(peak.value->value) + (unit.empty() ? "" : " " + unit);
  if (!peak.axes.empty()) size += fmt::format(" ({})", peak.axes);
  return {std::move(size), number(peak.value->t)};
}

/// "F_x 13.0 (7)": digits and need of the component that comes nearest to its need, where it does, and the verdict.
Line judged_cells(const QuantityRow* row) {
  if (row == nullptr) return {"-", "-"};
  const Check check = tightest_check(*row);
  const std::optional<double> digits = digits_of(*row, check);
  if (!row->unique || !is_judged(*row) || !digits) return {"-", judgement_text(*row)};
  const std::string component = is_scalar_force(row->quantity.kind) ? "" : describe_component(row->quantity) + " ";
  return {fmt::format("{}{} ({:g})", component, format_digits(*digits), need_of(*row, check)), judgement_text(*row)};
}

/// Of the components of a row of forces, or of a vector of which a part is unique, whichever comes nearer to its need.
Line judged_cells(const Verdict& verdict, const Quantity& of) {
  const QuantityRow* row = worst_row(verdict, of);
  const PartlyUnique* worst = nullptr;
  for (const PartlyUnique& part : verdict.partly_unique) {
    const bool is_of_row = part.of.kind == of.kind && part.of.owner == of.owner && part.of.side == of.side;
    if (is_of_row && (worst == nullptr || part.unexplained_digits < worst->unexplained_digits)) worst = &part;
  }
  if (worst == nullptr) return judged_cells(row);
  const double need = need_of(verdict, *worst);
  const bool is_judged_by_row = row != nullptr && row->unique && is_judged(*row);
  if (is_judged_by_row && margin(*row, tightest_check(*row)) < worst->unexplained_digits - need)
    return judged_cells(row);
  return {fmt::format("{} {} ({:g})", worst->of.component < 3 ? "F" : "T", format_digits(worst->digits), need),
          to_string(worst->holds(need) ? Judgement::agree : Judgement::differ)};
}

Line wrench_line(const Model& model, const ForcePeaks& row) {
  const auto [owner, body] = owner_names(model, row.of);
  Line line{owner, body};
  for (const ForcePeak& part : row.parts) {
    const Line cells = peak_cells(part);
    line.insert(line.end(), cells.begin(), cells.end());
  }
  return line;
}

Line line_along(const Model& model, const ForcePeaks& row) {
  const auto& [force, power] = row.parts;
  Line line{describe_owner(model, row.of), coordinate_of(model, row.of)};
  const Line cells = peak_cells(force, unit_of(model, row.of));
  line.insert(line.end(), cells.begin(), cells.end());
  line.push_back(force.value ? number(force.value->root_mean_square) : "-");
  line.push_back(power.value ? number(power.value->value) : "-");
  return line;
}

/// `verdict`: nullptr where nothing is judged.
TextTable table_of(const Model& model, const std::vector<ForcePeaks>& rows, Line head, const Verdict* verdict) {
  std::vector<bool> right(head.size(), true);
  right[0] = right[1] = false;
  if (verdict != nullptr) {
    head.insert(head.end(), {"digits (need)", "verdict"});
    right.insert(right.end(), {true, false});
  }
  std::vector<Line> lines{std::move(head)};
  for (const ForcePeaks& row : rows) {
    Line& line = lines.emplace_back(is_scalar_force(row.of.kind) ? line_along(model, row) : wrench_line(model, row));
    if (verdict == nullptr) continue;
    const Line judged = judged_cells(*verdict, row.of);
    line.insert(line.end(), judged.begin(), judged.end());
  }
  return {std::move(lines), std::move(right)};
}

/// Those of joints, of force elements and of actors, each where there is one.
std::vector<TextTable> tables_of(const Model& model, const std::vector<ForcePeaks>& all, const Verdict* verdict) {
  const auto those = [&](const auto& are) {
    std::vector<ForcePeaks> chosen;
    std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [&](const auto& row) { return are(row.of.kind); });
    return chosen;
  };
  const auto wrench_head = [](const char* owner) {
    return Line{owner, "on", "peak F [N]", "at t [s]", "peak T [N m]", "at t [s]"};
  };
  std::vector<TextTable> tables{
      table_of(model, those([](Kind kind) { return kind == Kind::reaction; }), wrench_head("joint"), verdict),
      table_of(model, those([](Kind kind) { return kind == Kind::element; }), wrench_head("force element"), verdict),
      table_of(model, those(is_scalar_force), {"force", "along", "peak", "at t [s]", "RMS", "peak power [W]"},
               verdict)};
  std::erase_if(tables, [](const TextTable& table) { return table.lines.size() < 2; });
  return tables;
}

/// Below each other, with an empty line between two.
std::string text_of(const std::vector<TextTable>& tables) {
  std::string text;
  for (const TextTable& table : tables) text += (text.empty() ? "" : "\n") + format_table(table);
  return text;
}

/// What is said of axes that are not those of the sides; `verdict`: nullptr where nothing is judged.
std::string axes_words(const Model& model, std::optional<int> axes, const Verdict* verdict) {
  if (!axes) return "";
  return fmt::format(
      "wrenches in {}, each at the point of its own side{}", words_of(model, axes),
      verdict != nullptr ? "; digits and verdicts are those of components in each side's own frame" : "");
}

/// By how much two runs differ at most in a component, over samples in which it is unique.
double largest_difference(const ToldRun& one, const ToldRun& other, const Quantity& of, int row) {
  double largest = 0.0;
  const std::size_t samples = std::min(one.run.samples.size(), other.run.samples.size());
  for (std::size_t k = 0; k < samples; ++k) {
    if (!one.unique(row, static_cast<Eigen::Index>(k))) continue;
    const Vec6 difference = wrench_of(of, one.run.samples[k]).vector() - wrench_of(of, other.run.samples[k]).vector();
    largest = std::max(largest, std::abs(difference(of.component)));
  }
  return largest;
}

/// Each component of wrenches in the axes of a body: its peak with its sign, when, and, of two runs, by how much they
/// differ at most.
TextTable component_table(const Model& model, const std::vector<ForcePeaks>& peaks, std::optional<int> axes,
                          const std::vector<ToldRun>& runs) {
  const QuantityLayout layout(model);
  std::vector<Line> lines{{"in " + words_of(model, axes), "on", "component", "peak", "at t [s]"}};
  if (runs.size() == 2) lines.front().emplace_back("runs differ by");
  for (const ForcePeaks& row : peaks) {
    if (is_scalar_force(row.of.kind)) continue;
    const auto [owner, body] = owner_names(model, row.of);
    for (int c = 0; c < 6; ++c) {
      const ForcePeak& part = row.parts.at(static_cast<std::size_t>(c / 3));
      if (!part.exists) continue;
      const std::optional<Peak>& peak = part.components.at(static_cast<std::size_t>(c % 3));
      Quantity of = row.of;
      of.component = c;
      const Line cells = peak_cells({true, "", peak, {}}, unit_of(model, of));
      Line& line = lines.emplace_back(Line{owner, body, describe_component(of)});
      line.insert(line.end(), cells.begin(), cells.end());
      if (runs.size() < 2) continue;
      line.push_back(peak ? fmt::format("{:.1e}", largest_difference(runs[0], runs[1], of, layout.row_of(of))) : "-");
    }
  }
  std::vector<bool> right(lines.front().size(), true);
  std::fill_n(right.begin(), 3, false);
  return {std::move(lines), std::move(right)};
}

/// The runs of a verdict that are told: the first one that there is, and the other; nullptr: none.
std::array<const Trajectory*, 2> told_runs(const Verdict& verdict) {
  std::array<const Trajectory*, 2> runs{nullptr, nullptr};
  if (!verdict.unique) return runs;
  std::size_t next = 0;
  for (const std::optional<Trajectory>& run : verdict.trajectories) {
    if (run && !run->samples.empty()) runs.at(next++) = &*run;
  }
  return runs;
}

/// Whether a row of forces stands for a component.
bool holds(const Quantity& of, const Quantity& component) {
  if (is_scalar_force(of.kind)) return of == component;
  return of.kind == component.kind && of.owner == component.owner && of.side == component.side;
}

double least_margin(const QuantityRow& row) { return margin(row, tightest_check(row)); }

std::string lowered_needs(const Model& model, const Verdict& verdict) {
  std::string text;
  for (const std::vector<QuantityRow>* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      const bool is_shown = rows == &verdict.rows || row.quantity.kind == Kind::element;
      if (!is_shown || row.need.because.empty()) continue;
      text += fmt::format("need lowered: {}, {}: {:g} / {:g} / {:g}: {}\n", describe_owner(model, row.quantity),
                          describe_component(row.quantity), row.need.same_state, row.need.same_run, row.need.refined,
                          row.need.because);
    }
  }
  return text;
}

}  // namespace

Check tightest_check(const QuantityRow& row) {
  return *std::min_element(kChecks.begin(), kChecks.end(),
                           [&](Check one, Check other) { return margin(row, one) < margin(row, other); });
}

std::pair<std::string, std::string> owner_names(const Model& model, const Quantity& quantity) {
  if (quantity.kind == Kind::element) {
    const ForceElement& element = model.elements[quantity.owner];
    return {element.name, model.bodies[end_of(element, quantity.side)->body].name};
  }
  const Joint& joint = model.joints[quantity.owner];
  return {joint.name, model.bodies[joint.on(quantity.side).body].name};
}

std::string coordinate_of(const Model& model, const Quantity& of) {
  if (of.kind == Kind::coupling) return "-";
  const joints::JointType& type = *model.joints[static_cast<std::size_t>(of.owner)].type;
  return speed_names(type).at(static_cast<std::size_t>(of.component));
}

const QuantityRow* worst_row(const Verdict& verdict, const Quantity& of) {
  const QuantityRow* worst = nullptr;
  for (const std::vector<QuantityRow>* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (!holds(of, row.quantity)) continue;
      const bool better_known = worst != nullptr && row.unique && !worst->unique;
      const bool nearer = worst != nullptr && row.unique && least_margin(row) < least_margin(*worst);
      if (worst == nullptr || better_known || nearer) worst = &row;
    }
  }
  return worst;
}

std::vector<ForcePeaks> peaks_of(const Model& model, const Verdict& verdict) {
  if (verdict.rows.empty() && verdict.others.empty()) return {};
  const Trajectory* run = told_runs(verdict)[0];
  std::vector<ForcePeaks> all =
      force_peaks(QuantityLayout(model), run, run != nullptr ? &*verdict.unique : nullptr, verdict.axes);
  for (const PartlyUnique& part : verdict.partly_unique) {
    const auto row = std::find_if(all.begin(), all.end(), [&](const ForcePeaks& one) {
      return one.of.kind == part.of.kind && one.of.owner == part.of.owner && one.of.side == part.of.side;
    });
    if (row == all.end() || run == nullptr) continue;
    row->parts[static_cast<std::size_t>(part.of.component / 3)] = {true, "part", Peak{part.peak, part.t_peak, 0.0}};
  }
  return all;
}

std::string format_peaks(const Model& model, const Trajectory& run, const Mask* unique, std::optional<int> axes) {
  const std::vector<ForcePeaks> peaks = force_peaks(QuantityLayout(model), &run, unique, axes);
  std::vector<TextTable> tables = tables_of(model, peaks, nullptr);
  if (axes) tables.push_back(component_table(model, peaks, axes, {}));
  return axes_words(model, axes, nullptr) + (axes ? "\n" : "") + text_of(tables);
}

ForceTables force_tables(const Model& model, const Verdict& verdict) {
  const std::vector<ForcePeaks> peaks = peaks_of(model, verdict);
  ForceTables told{"", tables_of(model, peaks, &verdict)};
  const auto [run, other] = told_runs(verdict);
  if (!verdict.axes || run == nullptr) return told;
  const QuantityLayout layout(model);
  std::vector<ToldRun> both{told_in(layout, *run, &*verdict.unique, *verdict.axes)};
  if (other != nullptr) both.push_back(told_in(layout, *other, &*verdict.unique, *verdict.axes));
  told.axes = axes_words(model, verdict.axes, &verdict);
  told.tables.push_back(component_table(model, peaks, verdict.axes, both));
  return told;
}

std::string format_forces(const Model& model, const Verdict& verdict) {
  const ForceTables told = force_tables(model, verdict);
  const std::string text = told.axes + (told.axes.empty() ? "" : "\n") + text_of(told.tables);
  const std::string lowered = lowered_needs(model, verdict);
  return text + (text.empty() ? "" : "\n") + lowered + (lowered.empty() ? "" : "\n");
}

}  // namespace concord::compare
