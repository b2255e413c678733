#include "compare/report/force_json.h"

#include <nlohmann/json.hpp>

#include "compare/report/explanations.h"
#include "compare/report/force_table.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

using Json = nlohmann::ordered_json;

Json peak_json(const ForcePeak& peak, bool is_wrench) {
  if (!peak.exists) return nullptr;
  if (!peak.value) return {{"not_unique", true}};
  Json said{{"peak", peak.value->value}, {"t", peak.value->t}};
  if (is_wrench) {
    said["components"] = peak.axes.empty() ? "xyz" : peak.axes;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::optional<Peak>& one = peak.components[c];
      if (one) said[std::string(1, "xyz"[c])] = {{"peak", one->value}, {"t", one->t}};
    }
  } else {
    said["rms"] = peak.value->root_mean_square;
  }
  return said;
}

void add_judgement(Json& said, const QuantityRow* row) {
  if (row == nullptr) return;
  const Check check = tightest_check(*row);
  const std::optional<double> digits = is_judged(*row) ? digits_of(*row, check) : std::optional<double>();
  said["component"] = describe_component(row->quantity);
  said["check"] = digits ? Json(name_of(check)) : Json(nullptr);
  said["digits"] = digits_json(digits);
  said["need"] = need_of(*row, check);
  said["verdict"] = judgement_json(row->judgement);
}

Json row_json(const Model& model, const ForcePeaks& row) {
  const auto& [first, second] = row.parts;
  if (is_scalar_force(row.of.kind)) {
    return {{"kind", "actor"},
            {"of", describe_owner(model, row.of)},
            {"along", coordinate_of(model, row.of)},
            {"unit", unit_of(model, row.of)},
            {"force", peak_json(first, false)},
            {"power", peak_json(second, false)}};
  }
  const auto [owner, body] = owner_names(model, row.of);
  return {{"kind", row.of.kind == Kind::element ? "element" : "joint"},
          {"of", owner},
          {"on", body},
          {"side", row.of.side == Side::child ? "child" : "parent"},
          {"F", peak_json(first, true)},
          {"T", peak_json(second, true)}};
}

}  // namespace

Json forces_json(const Model& model, const Verdict& verdict) {
  Json rows = Json::array();
  for (const ForcePeaks& row : peaks_of(model, verdict)) {
    Json& said = rows.emplace_back(row_json(model, row));
    add_judgement(said, worst_row(verdict, row.of));
  }
  return rows;
}

}  // namespace concord::compare
