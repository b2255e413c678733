#include "compare/report/junit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compare/audit/digits.h"
#include "compare/quantities/observe.h"
#include "compare/report/force_table.h"
#include "compare/resolution/orders.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/two_by_two.h"

namespace concord::compare {

namespace {

/// With a sign in place of bytes that are no UTF-8, as a path may hold: they would be no XML.
std::string valid_utf8(const std::string& text) {
  const std::string quoted = nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

}  // namespace

std::string escape_xml(const std::string& text) {
  std::string result;
  for (const char c : valid_utf8(text)) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\n':
        result += "&#10;";
        break;
      default:
        result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return result;
}

namespace {

struct TestCase {
  enum class Result { passed, failed, error };

  std::string name;
  Result result = Result::passed;
  std::string message;
};

TestCase of_row(const Model& model, const QuantityRow& row) {
  TestCase test{fmt::format("{}, {}", describe_owner(model, row.quantity), describe_component(row.quantity)),
                TestCase::Result::passed, ""};
  if (row.judgement == Judgement::agree) return test;
  test.result = row.judgement == Judgement::differ ? TestCase::Result::failed : TestCase::Result::error;
  for (const Check check : kChecks) {
    if (!judges(check, row.quantity.kind) || meets_need(row, check)) continue;
    const auto digits = digits_of(row, check);
    test.message += fmt::format("{}{}: {} digits (need {:g})", test.message.empty() ? "" : ", ", name_of(check),
                                digits ? format_digits(*digits) : "no", need_of(row, check));
    if (digits && *digits >= need_of(row, check) && is_beyond_round_off(row, check)) {
      test.message += fmt::format(", {:.2g} times what double precision resolves", detail_of(row, check).ratio);
    }
  }
  return test;
}

TestCase of_reference(const ReferenceRow& row) {
  TestCase test{fmt::format("{}, {}, against the reference", row.of, row.component), TestCase::Result::passed, ""};
  if (!is_off(row)) return test;
  test.result = TestCase::Result::failed;
  test.message =
      fmt::format("{}: off by {:.3g} (cartesian) and {:.3g} (relative), error {:.3g}, t = {:.6g} s (line {}){}{}",
                  to_string(row.word), row.differences[0], row.differences[1], row.allowed, row.t, row.line,
                  row.hint.empty() ? "" : "; ", row.hint);
  return test;
}

TestCase yes_or_no(std::string name, bool passed, std::string message) {
  return {std::move(name), passed ? TestCase::Result::passed : TestCase::Result::failed,
          passed ? "" : std::move(message)};
}

/// A difference that no other test case reports, such as a state that one solver refuses.
void add_other_differences(const Verdict& verdict, std::vector<TestCase>& tests) {
  const auto has_failed = [](const TestCase& test) { return test.result == TestCase::Result::failed; };
  if (verdict.findings.empty() || std::any_of(tests.begin(), tests.end(), has_failed)) return;
  for (const Finding& finding : verdict.findings) {
    tests.push_back({"difference", TestCase::Result::failed, finding.what + ": " + finding.symptom});
  }
}

/// Who is to blame, and what tells a difference apart; nothing where nobody is.
void add_attribution(const Verdict& verdict, std::vector<TestCase>& tests) {
  if (!verdict.attribution) return;
  std::string message = "to blame: " + describe(*verdict.attribution);
  if (verdict.two_by_two) message += "; the difference of " + describe(*verdict.two_by_two);
  if (verdict.orders) message += fmt::format("; {}", fmt::join(describe(*verdict.orders), "; "));
  tests.push_back({"attribution", TestCase::Result::failed, std::move(message)});
}

std::vector<TestCase> tests_of(const ReportedCase& one) {
  if (one.verdict == nullptr) return {{"verdict", TestCase::Result::error, one.trouble}};
  const Verdict& verdict = *one.verdict;
  std::vector<TestCase> tests;
  for (const std::string& failure : verdict.failures) {
    const std::string name = tests.empty() ? "verdict" : fmt::format("verdict {}", tests.size() + 1);
    tests.push_back({name, TestCase::Result::error, failure});
  }
  if (verdict.rows.empty() && verdict.others.empty()) {
    add_attribution(verdict, tests);
    return tests;
  }
  tests.push_back(yes_or_no("rank", verdict.rank_agrees, "the solvers do not see the same constraints"));
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (row.unique) tests.push_back(of_row(*one.model, row));
    }
  }
  for (const ReferenceRow& row : verdict.references) {
    if (row.word != ReferenceWord::not_judged) tests.push_back(of_reference(row));
  }
  for (const SolverSummary& solver : verdict.solvers) {
    if (solver.audit_digits) {
      tests.push_back(yes_or_no(fmt::format("audit of {}", solver.name), *solver.audit_digits >= solver.audit_need,
                                fmt::format("{} (need {:g})", solver.audit_worst, solver.audit_need)));
    }
    if (!solver.energy_error) continue;
    tests.push_back(
        yes_or_no(fmt::format("energy of {}", solver.name), *solver.energy_error <= verdict.energy_allowed,
                  fmt::format("relative error {:.2e}, allowed {:.1e}", *solver.energy_error, verdict.energy_allowed)));
  }
  add_other_differences(verdict, tests);
  add_attribution(verdict, tests);
  return tests;
}

std::string format_test(const std::string& suite, const TestCase& test) {
  const std::string head =
      fmt::format("    <testcase classname=\"{}\" name=\"{}\"", escape_xml(suite), escape_xml(test.name));
  if (test.result == TestCase::Result::passed) return head + "/>\n";
  const char* kind = test.result == TestCase::Result::failed ? "failure" : "error";
  return fmt::format("{}>\n      <{} message=\"{}\"/>\n    </testcase>\n", head, kind, escape_xml(test.message));
}

}  // namespace

std::string format_junit(const std::vector<ReportedCase>& cases) {
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"concord\">\n";
  for (const ReportedCase& one : cases) {
    const std::vector<TestCase> tests = tests_of(one);
    const auto count = [&](TestCase::Result result) {
      return std::count_if(tests.begin(), tests.end(), [&](const TestCase& test) { return test.result == result; });
    };
    text += fmt::format("  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\">\n", escape_xml(one.name),
                        tests.size(), count(TestCase::Result::failed), count(TestCase::Result::error));
    for (const TestCase& test : tests) text += format_test(one.name, test);
    const std::string forces = one.verdict != nullptr ? format_forces(*one.model, *one.verdict) : "";
    if (!forces.empty()) text += fmt::format("    <system-out>{}</system-out>\n", escape_xml(forces));
    text += "  </testsuite>\n";
  }
  return text + "</testsuites>\n";
}

}  // namespace concord::compare
