#include "compare/report/explanations.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/quantities/observe.h"
#include "compare/verdict/third_words.h"

namespace concord::compare {

namespace {

using Json = nlohmann::ordered_json;

Json reference_row(const ReferenceRow& row) {
  return {{"of", row.of},
          {"component", row.component},
          {"unit", row.unit},
          {"peak", row.peak},
          {"stated_error", row.allowed},
          {"cartesian_off", row.differences[0]},
          {"relative_off", row.differences[1]},
          {"t", row.t},
          {"stated", row.stated},
          {"line", row.line},
          {"hint", row.hint},
          {"word", to_string(row.word)},
          {"verdict", row.word == ReferenceWord::not_judged ? "not_judged"
                      : is_off(row)                         ? "differ"
                                                            : "agree"}};
}

Json third_row(const Model& model, const ThirdRow& row, const std::string& third) {
  return {{"of", describe_owner(model, row.quantity)},
          {"kind", word_of(row.quantity.kind)},
          {"component", describe_component(row.quantity)},
          {"scale", row.scale},
          {"cartesian_digits", digits_json(row.shared[0].digits)},
          {"relative_digits", digits_json(row.shared[1].digits)},
          {"between_digits", digits_json(row.between.digits)},
          {"need", row.need},
          {"off", name_of(blame_in(row), third)}};
}

Json third_opinion(const Model& model, const ThirdReport& third) {
  Json said{{"name", third.name}};
  if (!third.not_expressible.empty()) {
    said["not_expressible"] = third.not_expressible;
    return said;
  }
  said["states"] = third.states;
  said["failed"] = third.failed;
  said["rows"] = Json::array();
  for (const ThirdRow& row : third.rows) said["rows"].push_back(third_row(model, row, third.name));
  return said;
}

/// Whose fault a difference is, and whether motions or equations differ; empty where nothing differs.
Json attribution_of(const Verdict& verdict) {
  Json told = Json::object();
  if (verdict.attribution) {
    constexpr std::array kSolvers{"cartesian", "relative", "both"};
    const bool is_nobodys = verdict.attribution->term == Term::statement;
    told["solver"] = is_nobodys ? "none" : kSolvers[verdict.attribution->solver];
    told["place"] = verdict.attribution->where;
    told["term"] = name_of(verdict.attribution->term);
    told["because"] = verdict.attribution->because;
    if (verdict.attribution->closed_digits) told["closed_digits"] = digits_json(verdict.attribution->closed_digits);
  }
  if (verdict.two_by_two) {
    const TwoByTwo& table = *verdict.two_by_two;
    told["two_by_two"] = {
        {"of", table.of},
        {"unit", table.unit},
        {"samples", table.samples},
        {"formulation", {{"cartesian_motion", table.formulation[0]}, {"relative_motion", table.formulation[1]}}},
        {"integration", {{"cartesian_equations", table.integration[0]}, {"relative_equations", table.integration[1]}}},
        {"curves",
         {{"peak", table.curves.peak},
          {"t_peak", table.curves.t_peak},
          {"rms_over_range", table.curves.rms_over_range},
          {"magnitude", table.curves.magnitude},
          {"phase", table.curves.phase},
          {"combined", table.curves.combined}}}};
  }
  return told;
}

}  // namespace

Json judgement_json(Judgement judgement) {
  return judgement == Judgement::not_judged ? "not_judged" : to_string(judgement);
}

Json digits_json(const std::optional<double>& value) {
  if (!value) return nullptr;
  return std::floor(*value * 100.0) / 100.0;
}

void add_explanations(Json& said, const Model& model, const Verdict& verdict) {
  for (const ReferenceRow& row : verdict.references) said["reference"].push_back(reference_row(row));
  if (verdict.attribution || verdict.two_by_two) said["attribution"] = attribution_of(verdict);
  if (verdict.third) said["third_opinion"] = third_opinion(model, *verdict.third);
}

}  // namespace concord::compare
