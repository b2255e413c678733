#include "compare/random_machines/outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

namespace concord::compare::fuzz {

namespace {

using Json = nlohmann::json;

struct RefusalKind {
  std::string_view kind;
  std::string_view message;  // a part of it
};

/// The closed list: a message that holds none of these parts is a needless stop until it is understood.
constexpr std::array kRefusals{
    RefusalKind{"not unique anywhere", "no component was judged"},
    RefusalKind{"carries nothing", "carries anything"},
    RefusalKind{"rank undecided", "rank of the constraints is undecided"},
    RefusalKind{"singular pose", "singular pose"},
    RefusalKind{"singular pose", "pose is singular"},
    RefusalKind{"singular pose", "singular in this pose"},
    RefusalKind{"singular pose", "its velocity is singular there"},
    RefusalKind{"singular pose", "passes a pose where two of its motions are one"},
    RefusalKind{"stiff beyond the integrator", "or is too stiff for "},
    RefusalKind{"integration does not converge", "the runs do not converge"},
    RefusalKind{"turned too far for its element", "allowed are 175 deg"},
    RefusalKind{"element without direction", "its force has no direction"},
    RefusalKind{"element without direction", "has no forward direction"},
    RefusalKind{"element without direction", "the wheel lies flat on the road"},
    RefusalKind{"element without direction", "has no angle"},
    RefusalKind{"element without direction", "that it has no angle"},
    RefusalKind{"tire chatters", "changes its regime"},
    RefusalKind{"bent too far", "through deformation alone"},
    RefusalKind{"bent too far", "deformation has turned its frame"},
    RefusalKind{"without inertia", "have no inertia"},
    RefusalKind{"grows without bound", "the motion of the model has grown without bound"},
};
constexpr std::size_t kMostOfKind = 60;
constexpr std::string_view kStartRefused = "start refused";

std::string_view up_to(std::string_view text, std::string_view mark) { return text.substr(0, text.find(mark)); }

/// "same state", "audit", "same run", ...: findings say it before the first colon of their symptom.
std::string differ_kind(const Finding& finding) {
  if (finding.what.find("is not in balance") != std::string::npos) {
    return fmt::format("{} not in balance", up_to(finding.what, " "));
  }
  if (finding.what.find("does not keep its energy") != std::string::npos) {
    return fmt::format("{} loses energy", up_to(finding.what, " "));
  }
  if (finding.what.find("does not accept") != std::string::npos) return "closures";
  const std::string_view check = up_to(finding.symptom, ":");
  for (const std::string_view known : {"same state", "same run", "refined", "audit"}) {
    if (check == known) return without_particulars(finding.symptom).substr(0, kMostOfKind);
  }
  return without_particulars(up_to(finding.what, ":"));
}

ResolutionRatios ratios_in(const Verdict& verdict) {
  ResolutionRatios ratios;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      const CheckDetail& detail = row.detail[0];
      if (row.same_state && detail.resolvable && detail.samples > 0) ratios.add(detail.ratio);
    }
  }
  return ratios;
}

}  // namespace

std::vector<std::string> refusal_kinds() {
  std::vector<std::string> kinds;
  for (const RefusalKind& one : kRefusals) {
    if (kinds.empty() || kinds.back() != one.kind) kinds.emplace_back(one.kind);
  }
  kinds.emplace_back(kStartRefused);
  return kinds;
}

std::string refusal_kind(std::string_view message) {
  for (const RefusalKind& one : kRefusals) {
    if (message.find(one.message) != std::string_view::npos) return std::string(one.kind);
  }
  return "";
}

std::string without_particulars(std::string_view message) {
  std::string plain;
  bool quoted = false;
  for (const char c : message) {
    if (c == '\'') quoted = !quoted;
    if (quoted) continue;
    const bool is_digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (is_digit && !plain.empty() && plain.back() == '#') continue;
    plain += is_digit ? '#' : c;
  }
  constexpr std::size_t kMost = 90;
  std::replace(plain.begin(), plain.end(), '\n', ' ');
  return plain.substr(0, kMost);
}

Outcome outcome_of_error(const std::string& message) {
  const std::string kind = refusal_kind(message);
  if (!kind.empty()) return {Sort::refusal, kind, message};
  return {Sort::stop, "stop: " + without_particulars(message), message};
}

Outcome outcome_of_input_error(const std::string& message, bool is_read) {
  const std::string kind = refusal_kind(message);
  if (!kind.empty()) return {Sort::refusal, kind, message};
  if (is_read) return {Sort::refusal, std::string(kStartRefused), message};
  return {Sort::stop, "stop: the model is not read", message};
}

/// A difference outweighs a failure: it is the graver news.
Outcome outcome_of(const Verdict& verdict) {
  if (!verdict.findings.empty()) {
    const Finding& first = verdict.findings.front();
    std::string text;
    for (const Finding& finding : verdict.findings) text += fmt::format("{}\n  {}\n", finding.what, finding.symptom);
    return {Sort::differ, "differ: " + differ_kind(first), text, ratios_in(verdict)};
  }
  std::vector<Outcome> failures;
  for (const std::string& failure : verdict.failures) failures.push_back(outcome_of_error(failure));
  Outcome worst;
  for (const Outcome& one : failures) {
    // Where one solver says on a check what is with the machine, the other's stop there needs no other reason; nor does
    // a run that stops where a state of it is a singular pose.
    const auto explains = [&one](const Outcome& other) {
      if (other.sort != Sort::refusal) return false;
      const std::string_view where = up_to(other.text, ":");  // a check, or a solver that was asked in a state
      const bool is_state = where == "cartesian" || where == "relative";
      return where == up_to(one.text, ":") || (is_state && other.kind == "singular pose");
    };
    if (one.sort == Sort::stop && std::any_of(failures.begin(), failures.end(), explains)) continue;
    if (worst.sort == Sort::agree || (worst.sort == Sort::refusal && one.sort == Sort::stop)) worst = one;
  }
  worst.ratios = ratios_in(verdict);
  return worst;
}

void ResolutionRatios::add(double ratio) {
  const auto edge = std::lower_bound(kEdges.begin(), kEdges.end(), ratio);
  ++counts[static_cast<std::size_t>(edge - kEdges.begin())];
  largest = std::max(largest, ratio);
}

void ResolutionRatios::add(const ResolutionRatios& others) {
  for (std::size_t k = 0; k < counts.size(); ++k) counts[k] += others.counts[k];
  largest = std::max(largest, others.largest);
}

long ResolutionRatios::count() const { return std::accumulate(counts.begin(), counts.end(), 0L); }

double ResolutionRatios::edge_of(double share) const {
  long found = 0;
  for (std::size_t k = 0; k < kEdges.size(); ++k) {
    found += counts[k];
    if (static_cast<double>(found) >= share * static_cast<double>(count())) return kEdges[k];
  }
  return std::numeric_limits<double>::infinity();
}

Outcome outcome_of(const workers::Report& report) {
  if (report.end == workers::End::threw) return outcome_of_error(report.answer);
  if (report.end != workers::End::answered) {
    const std::string signal = report.signal != 0 ? fmt::format(" by signal {}", report.signal) : "";
    return {Sort::lost, fmt::format("{}{}", to_string(report.end), signal), report.last_words};
  }
  const Json answer = Json::parse(report.answer);
  const Json& largest = answer.at("largest");
  return {answer.at("sort"),
          answer.at("kind"),
          answer.at("text"),
          {answer.at("counts"), largest.is_null() ? std::numeric_limits<double>::infinity() : largest.get<double>()}};
}

std::string format_outcome(const Outcome& outcome) {
  const Json answer{{"sort", outcome.sort},
                    {"kind", outcome.kind},
                    {"text", outcome.text},
                    {"counts", outcome.ratios.counts},
                    {"largest", outcome.ratios.largest}};
  return answer.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool refuses_too_many(long regular, long refused) {
  constexpr long kFewest = 10;
  constexpr double kMost = 0.1;
  return refused >= kFewest && static_cast<double>(refused) > kMost * static_cast<double>(regular);
}

}  // namespace concord::compare::fuzz
