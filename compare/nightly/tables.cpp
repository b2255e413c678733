#include "compare/nightly/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

#include "common/reading/text_file.h"
#include "compare/audit/digits.h"
#include "compare/nightly/record.h"
#include "compare/report/files.h"
#include "compare/report/junit.h"
#include "compare/report/text_table.h"

namespace concord::compare::nightly {

namespace {

std::string format_cases(const NightReport& report) {
  const bool is_night = report.kind == "concord night";
  std::vector<std::vector<std::string>> lines{
      {"case", "ending", "judged", "same state", "same run", "refined", "evaluations", "steps", "past"}};
  for (const CaseLine& line : report.cases) {
    lines.push_back({line.id, to_string(line.ending), fmt::format("{} of {}", line.judged, line.total),
                     digits_cell(line.worst[0]), digits_cell(line.worst[1]), digits_cell(line.worst[2]),
                     pair_cell(line.evaluations), pair_cell(line.steps),
                     is_night || !line.changes.empty() ? past_words(line) : "same"});
  }
  return format_table(lines, {false, false, true, true, true, true, true, true, false});
}

std::string component_cell(const Change& change) {
  if (change.component.empty()) return "-";
  return change.component + (change.more > 0 ? fmt::format(" and {} more", change.more) : "");
}

std::string format_changes(const NightReport& report) {
  std::vector<std::vector<std::string>> lines{{"what", "case", "component", "measure", "was", "is", "against"}};
  for (const Change* change : all_changes(report)) {
    lines.push_back({to_string(change->kind), change->id, component_cell(*change), change->measure,
                     change->was.empty() ? "-" : change->was, change->is,
                     change->against.empty() ? "-" : change->against});
  }
  return lines.size() == 1 ? "" : format_table(lines, {false, false, false, false, false, false, false});
}

/// What is said of green cases, a line for each.
std::string notes_of(const NightReport& report) {
  std::string text;
  for (const CaseLine& line : report.cases) {
    if (!line.note.empty()) text += fmt::format("note: {}: {}\n", as_cell(line.id), as_cell(line.note));
  }
  return text;
}

/// "18 agree, 1 differ, 1 crashed": how often there is each of some kinds, `words` says how a kind is told of so many.
template <class Kind, class Words>
std::string counted(const std::vector<Kind>& kinds, const Words& words) {
  std::map<Kind, int> counts;
  for (const Kind kind : kinds) ++counts[kind];
  std::string text;
  for (const auto& [kind, count] : counts) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, words(kind, count));
  }
  return text;
}

std::vector<Ending> endings_of(const NightReport& report) {
  std::vector<Ending> endings;
  for (const CaseLine& line : report.cases) endings.push_back(line.ending);
  return endings;
}

/// "; 1 red, 2 worse"; empty where nothing changed.
std::string turns_of(const NightReport& report) {
  std::vector<ChangeKind> kinds;
  for (const Change* change : all_changes(report)) kinds.push_back(change->kind);
  const std::string turns = counted(kinds, [](ChangeKind kind, int) { return to_string(kind); });
  return turns.empty() ? "" : "; " + turns;
}

std::string change_line(const Change& change) {
  return fmt::format("{}: {}", to_string(change.kind), change_words(change));
}

std::string junit_case(const std::string& suite, const std::string& name, int code, bool is_known,
                       const std::vector<Change>& changes) {
  std::string words;
  for (const Change& change : changes) words += change_line(change) + '\n';
  std::string text = fmt::format("    <testcase classname=\"{}\" name=\"{}\">", escape_xml(suite), escape_xml(name));
  const std::string message = changes.empty() ? "" : change_line(changes.front());
  if (code != 0) {
    const char* kind = code == 1 ? "failure" : "error";
    text += fmt::format("\n      <{0} message=\"{1}\">{2}</{0}>\n    ", kind, escape_xml(message), escape_xml(words));
  } else if (is_known) {
    text += fmt::format("\n      <skipped message=\"{}\"/>\n    ", escape_xml(message));
  }
  return text + "</testcase>\n";
}

bool is_known_red(const CaseLine& line) {
  return std::any_of(line.changes.begin(), line.changes.end(),
                     [](const Change& change) { return change.kind == ChangeKind::known; });
}

Json head_json(const NightReport& report) {
  Json changes = Json::array();
  for (const Change* change : all_changes(report)) changes.push_back(change_json(*change));
  std::string headline = format_headline(report);
  headline.pop_back();  // the end of its line
  return {{"format", kNightFormat},       {"kind", report.kind},
          {"title", report.title},        {"started", report.started},
          {"origin", report.origin},      {"verdict", headline},
          {"exit_code", report.code},     {"trouble", report.trouble},
          {"only", report.only},          {"is_finished", report.is_finished},
          {"changes", std::move(changes)}};
}

}  // namespace

std::string past_words(const CaseLine& line) {
  const auto gravest = std::min_element(line.changes.begin(), line.changes.end(),
                                        [](const Change& a, const Change& b) { return a.kind < b.kind; });
  return gravest == line.changes.end() ? (line.has_past ? "as accepted" : "no past") : to_string(gravest->kind);
}

std::vector<const Change*> all_changes(const NightReport& report) {
  std::vector<const Change*> all;
  for (const CaseLine& line : report.cases) {
    for (const Change& change : line.changes) all.push_back(&change);
  }
  for (const Change& change : report.others) all.push_back(&change);
  std::stable_sort(all.begin(), all.end(), [](const Change* a, const Change* b) { return a->kind < b->kind; });
  return all;
}

std::string change_words(const Change& change) {
  return fmt::format("{}{}{}: {} -> {}{}", change.component, change.component.empty() ? "" : ", ", change.measure,
                     change.was.empty() ? "-" : change.was, change.is,
                     change.more > 0 ? fmt::format(" and {} more", change.more) : "");
}

Json change_json(const Change& change) {
  return {{"what", to_string(change.kind)}, {"case", change.id},  {"component", change.component},
          {"measure", change.measure},      {"was", change.was},  {"is", change.is},
          {"against", change.against},      {"more", change.more}};
}

std::string pair_cell(const std::array<long, 2>& pair) {
  return pair[0] == 0 && pair[1] == 0 ? "-" : fmt::format("{} / {}", pair[0], pair[1]);
}

CaseLine case_line_of(const Result& result, std::vector<Change> changes) {
  CaseLine line{result.id, result.work, result.ending, result.judged,     result.total, worst_digits(result), {},
                {},        0,           true,          std::move(changes)};
  for (std::size_t who = 0; who < 2; ++who) {
    line.evaluations[who] = result.cost[who].evaluations;
    line.steps[who] = result.cost[who].steps;
  }
  for (const Change& change : line.changes) line.code = worse_code(line.code, exit_code(change, result.ending));
  if (result.is_green()) line.note = result.words;
  return line;
}

int code_of(const NightReport& report) {
  int code = 0;
  for (const CaseLine& line : report.cases) code = worse_code(code, line.code);
  for (const Change& change : report.others) code = worse_code(code, exit_code(change, Ending::agree));
  const bool is_whole = report.is_finished && report.trouble.empty();
  return is_whole ? code : worse_code(code, exit_code(Ending::not_run));
}

namespace {

/// What a report is in one word, and as the predicate of a sentence.
std::pair<const char*, const char*> state_words(const NightReport& report) {
  if (report.code == 0) return {"green", "is green"};
  if (report.code == kNoBaseline) {
    const std::vector<const Change*> changes = all_changes(report);
    const bool is_missing = std::any_of(changes.begin(), changes.end(),
                                        [](const Change* change) { return change->kind == ChangeKind::missing; });
    if (is_missing) return {"no baseline", "lacks baselines"};
    return {"changed", "has changed models"};
  }
  if (!report.is_finished) return {"unfinished", "is not finished"};
  return {"red", "is red"};
}

std::string number_of_cases(const NightReport& report) {
  return plural(static_cast<int>(report.cases.size()), "case", "cases");
}

}  // namespace

std::string format_headline(const NightReport& report) {
  const std::string endings = counted(endings_of(report), [](Ending ending, int) { return to_string(ending); });
  const std::string chosen = report.only.empty() ? "" : fmt::format(", only '{}'", as_cell(report.only));
  return fmt::format("{} {}{}: {}{}{}{}\n", state_words(report).first, as_cell(report.title), chosen,
                     number_of_cases(report), endings.empty() ? "" : ": ", endings, turns_of(report));
}

std::string format_sentence(const NightReport& report) {
  constexpr std::array<std::pair<const char*, const char*>, 8> kVerbs{{{"agrees", "agree"},
                                                                       {"differs", "differ"},
                                                                       {"has no verdict", "have no verdict"},
                                                                       {"has bad input", "have bad input"},
                                                                       {"crashed", "crashed"},
                                                                       {"hung", "hung"},
                                                                       {"ran out of memory", "ran out of memory"},
                                                                       {"was not run", "were not run"}}};
  const char* state = state_words(report).second;
  if (report.cases.empty()) return fmt::format("The night of {} {}: no case was run.", report.title, state);
  const std::string endings = counted(endings_of(report), [&](Ending ending, int count) {
    const auto& [one, several] = kVerbs.at(static_cast<std::size_t>(ending));
    return count == 1 ? one : several;
  });
  const std::string chosen =
      report.only.empty() ? "" : fmt::format("; only cases called '{}' were asked for", report.only);
  return fmt::format("The night of {} {}: of {} {}{}{}.", report.title, state, number_of_cases(report), endings,
                     turns_of(report), chosen);
}

std::string format_report(const NightReport& report) {
  std::string text;
  if (!report.cases.empty()) text += format_cases(report) + '\n';
  const std::string changes = format_changes(report);
  if (!changes.empty()) text += changes + '\n';
  text += notes_of(report);
  if (!report.trouble.empty()) text += report.trouble + '\n';
  return text + format_headline(report);
}

std::string format_markdown(const NightReport& report) {
  std::string text = "# " + format_headline(report) + '\n';
  text += fmt::format("{}, commit {}, {}; {}; {} UTC\n", report.origin.version, report.origin.commit,
                      report.origin.compiler, report.origin.machine, report.started);
  if (!report.trouble.empty()) text += '\n' + as_cell(report.trouble) + '\n';
  const std::string notes = notes_of(report);
  if (!notes.empty()) text += '\n' + notes;
  const std::string changes = format_changes(report);
  return text + '\n' + (changes.empty() ? "Nothing changed.\n" : changes);
}

std::string format_night_junit(const NightReport& report) {
  int failures = 0;
  int errors = 0;
  int skipped = 0;
  std::string cases;
  const auto add = [&](const std::string& name, int code, bool is_known, const std::vector<Change>& changes) {
    failures += code == 1 ? 1 : 0;
    errors += code > 1 ? 1 : 0;
    skipped += code == 0 && is_known ? 1 : 0;
    cases += junit_case(report.title, name, code, is_known, changes);
  };
  for (const CaseLine& line : report.cases) add(line.id, line.code, is_known_red(line), line.changes);
  for (const Change& change : report.others) add(change.id, exit_code(change, Ending::agree), false, {change});
  const Change trouble{ChangeKind::red, "", "", "history", "", report.trouble};
  if (!report.trouble.empty()) add("history", exit_code(Ending::not_run), false, {trouble});
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
      "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}  </testsuite>\n"
      "</testsuites>\n",
      escape_xml(report.title), report.cases.size() + report.others.size() + (report.trouble.empty() ? 0 : 1), failures,
      errors, skipped, cases);
}

void write_night_json(const std::filesystem::path& file, const NightReport& report,
                      const std::function<std::optional<Result>()>& next) {
  UnfinishedFile unfinished_file(file);
  {
    std::ofstream out(unfinished_file.path(), std::ios::binary);
    std::string head = dumped(head_json(report), 2);
    head.resize(head.rfind('\n'));  // without the brace that closes it
    out << head << ",\n  \"cases\": [";
    bool is_first = true;
    while (const std::optional<Result> result = next()) {
      out << (is_first ? "\n    " : ",\n    ") << dumped(*result);
      is_first = false;
    }
    out << "\n  ]\n}\n";
    out.close();
    if (!out) throw std::runtime_error(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
  }
  unfinished_file.finish();
}

std::string without_tag(const std::string& words) {
  const std::size_t end = words.starts_with("[json.exception.") ? words.find("] ") : std::string::npos;
  return end == std::string::npos ? words : words.substr(end + 2);
}

NightFile read_night_json(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& reason) { throw InputError({file.string(), 0, 0}, reason); };
  NightFile found;
  try {
    const Json document = Json::parse(read_text_file(file));
    if (!document.is_object() || document.value("kind", Json()) != "concord night") {
      refuse("is no file of results that `concord nightly --json` or `concord compare --json` writes");
    }
    if (document.at("format") != kNightFormat) {
      refuse(fmt::format("version {} of these results is not known: this program reads version {}",
                         document.at("format").dump(), kNightFormat));
    }
    found.origin = document.at("origin");
    found.title = document.at("title");
    found.only = document.value("only", "");
    found.is_finished = document.value("is_finished", true);
    for (const Json& one : document.at("cases")) {
      Result result = one;
      // A case that the night did not come to is none of its results.
      if (result.ending == Ending::not_run) {
        found.is_finished = false;
      } else {
        found.results.push_back(std::move(result));
      }
    }
  } catch (const Json::exception& error) {
    refuse(fmt::format("cannot be read: {}", without_tag(error.what())));
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    refuse(fmt::format("cannot be read: {}", without_tag(error.what())));
  }
  std::sort(found.results.begin(), found.results.end(), [](const Result& a, const Result& b) { return a.id < b.id; });
  return found;
}

}  // namespace concord::compare::nightly
