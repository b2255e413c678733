#include "compare/joint_check/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <ostream>
#include <thread>

#include "common/error.h"
#include "common/joints/catalogue.h"
#include "common/reading/spelling.h"
#include "compare/joint_check/coupling_check.h"
#include "compare/joint_check/sheet.h"
#include "compare/report/files.h"
#include "compare/report/interrupt.h"

namespace concord::compare::joint_check {

namespace {

/// A joint type, or nullptr: couplings.
using Subject = const JointType*;

std::vector<Subject> subjects_of(const JointCommand& command) {
  std::vector<Subject> subjects;
  if (command.all) {
    subjects = joints::catalogue();
    subjects.push_back(nullptr);
    return subjects;
  }
  for (const std::string& name : command.names) {
    subjects.push_back(joints::find(name));
    if (subjects.back() != nullptr || name == kCouplings) continue;
    throw InputError({"command line", 0, 0},
                     fmt::format("no joint type '{}': {}", name, suggestion(name, subject_names(), "joint types")));
  }
  if (subjects.empty()) throw InputError({"command line", 0, 0}, "name a joint type, or say --all");
  return subjects;
}

SheetOptions options_of(const JointCommand& command) {
  SheetOptions options;
  options.seed = command.seed;
  if (command.pose) {
    options.poses = {*command.pose};
  } else {
    for (int k = 0; k < command.poses; ++k) options.poses.push_back(k);
  }
  return options;
}

/// Sheets of all subjects, in their order, made side by side.
std::vector<Sheet> check_all(const std::vector<Subject>& subjects, const SheetOptions& options) {
  std::vector<Sheet> sheets(subjects.size());
  std::vector<std::exception_ptr> troubles(subjects.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t k = next++; k < subjects.size(); k = next++) {
      try {
        sheets[k] = subjects[k] != nullptr ? check_joint(*subjects[k], options) : check_couplings(options);
      } catch (...) {
        troubles[k] = std::current_exception();
      }
    }
  };
  const std::size_t workers = std::min<std::size_t>(subjects.size(), std::max(1U, std::thread::hardware_concurrency()));
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < workers; ++k) threads.emplace_back(work);
  }
  for (const std::exception_ptr& trouble : troubles) {
    if (trouble) std::rethrow_exception(trouble);
  }
  return sheets;
}

std::filesystem::path sheet_file(const JointCommand& command, std::string_view subject, std::string_view ending) {
  return command.out / fmt::format("{}.sheet.{}", subject, ending);
}

/// Refuses places at which no sheet can be written.
void check_outputs(const JointCommand& command, const std::vector<Subject>& subjects) {
  if (command.out.empty()) return;
  check_target_folder(command.out);
  for (const Subject subject : subjects) {
    const std::string_view name = subject != nullptr ? std::string_view(subject->name) : kCouplings;
    for (const char* ending : {"txt", "json"}) check_target(sheet_file(command, name, ending));
  }
}

int check_and_tell(const JointCommand& command, const Console& console) {
  const std::vector<Subject> subjects = subjects_of(command);
  check_outputs(command, subjects);
  const std::vector<Sheet> sheets = check_all(subjects, options_of(command));
  bool all_hold = true;
  for (const Sheet& sheet : sheets) {
    const std::string text = format_sheet(sheet);
    console.out << text << '\n';
    all_hold = all_hold && sheet.holds();
    if (command.out.empty()) continue;
    write_file(sheet_file(command, sheet.joint, "txt"), text);
    write_file(sheet_file(command, sheet.joint, "json"), format_sheet_json(sheet));
    note_finished(sheet.joint);
  }
  if (sheets.size() > 1) console.out << format_summary(sheets);
  return all_hold ? kAgree : kDiffer;
}

}  // namespace

int check_joints(const JointCommand& command, const Console& console) {
  return guarded(console, [&] { return check_and_tell(command, console); });
}

}  // namespace concord::compare::joint_check
