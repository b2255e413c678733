#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/report/result_folder.h"
#include "compare/report/text_table.h"
#include "compare/resolution/run_check.h"
#include "tests/faults/catalogue.h"
#include "tests/read_back/read_back.h"

/// Faults in what is written: no verdict can show them, because it is reached before.
namespace concord::compare {
namespace {

using faults::Fault;
using faults::Planting;

/// A run of a machine of this folder, and what reading its files back complains of.
class WrittenRun {
 public:
  explicit WrittenRun(const std::string& machine)
      : model_(read_model(CONCORD_FAULTS "/" + machine + ".toml")), solver_(cartesian::make_solver(model_)) {
    RunOptions options;
    options.until = 0.02;
    options.samples = 4;
    options.integrator = solver_->integrators().front();
    trajectory_ = solver_->integrate(options, [](double) {});
    unique_ = check_run(QuantityLayout(model_), *solver_, trajectory_, options).unique;
  }

  [[nodiscard]] std::vector<std::string> complaints() const {
    const auto folder = std::filesystem::temp_directory_path() / fmt::format("concord_faults_{}", getpid());
    std::filesystem::create_directories(folder);
    write_run_files(folder, model_, {"cartesian", &trajectory_, &unique_});
    std::vector<std::string> told = read_back::unlike_run(folder, {model_, "cartesian", trajectory_, &unique_});
    std::filesystem::remove_all(folder);
    return told;
  }

 private:
  Model model_;
  std::unique_ptr<Solver> solver_;
  Trajectory trajectory_;
  Mask unique_;
};

TEST_CASE("Every planted fault in what is written is told by reading the files back, with file and column") {
  std::vector<Fault> all = faults::read_catalogue();
  std::erase_if(all, [](const Fault& fault) { return !fault.is_in("compare/report"); });
  REQUIRE(all.size() >= 3);
  std::vector<std::vector<std::string>> lines{{"fault", "planted in", "told first"}};
  for (const Fault& fault : all) {
    INFO(fault.name);
    const WrittenRun run(fault.machine);
    CHECK(run.complaints().empty());
    const Planting planting(fault.number);
    const std::vector<std::string> told = run.complaints();
    REQUIRE_FALSE(told.empty());
    lines.push_back({fault.name, fault.file, told.front()});
    if (fault.where == "-") continue;
    CHECK(std::all_of(told.begin(), told.end(), [&](const std::string& line) {
      return line.find(".csv: ") != std::string::npos || line.find(".nc: ") != std::string::npos;
    }));
    CHECK(told.front().find(fault.where) != std::string::npos);
  }
  std::cout << format_table(lines, {false, false, false});
}

}  // namespace
}  // namespace concord::compare
