#include "compare/page/machine_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/audit/digits.h"
#include "compare/page/packing.h"
#include "compare/page/thinning.h"
#include "compare/report/result_document.h"

namespace concord::compare::page {

namespace {

using DataJson = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".result.json";
constexpr std::size_t kBytesOfNumber = 16;  // in base64, three numbers: both curves and their difference
constexpr double kShareOfCurves = 0.65;     // of the bytes; poses take the rest

std::string names_of(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code trouble;
  for (const auto& entry : fs::directory_iterator(folder, trouble)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  if (names.empty()) return "it is empty";
  constexpr std::size_t kShown = 6;
  std::string text;
  for (std::size_t k = 0; k < std::min(names.size(), kShown); ++k) text += (k == 0 ? "" : ", ") + names[k];
  return "it holds " + text + (names.size() > kShown ? fmt::format(" and {} more", names.size() - kShown) : "");
}

DataJson read_document(const fs::path& file, std::string& text) {
  const auto refuse = [&](const std::string& reason) { throw InputError({file.string(), 0, 0}, reason); };
  text = read_text_file(file);
  DataJson document = DataJson::parse(text, nullptr, false);
  if (!document.is_object() || document.value("kind", DataJson()) != "concord result") {
    refuse("is no result that `concord compare --out` wrote: \"kind\": \"concord result\" was expected");
  }
  const DataJson format = document.value("format", DataJson());
  if (format != kResultFormat) {
    refuse(fmt::format("has format {}, but format {} was expected: compare the model again with this program",
                       format.dump(), kResultFormat));
  }
  return document;
}

void require_same_machine(const fs::path& file, const Curves& curves, const DataJson& document) {
  const DataJson& machine = document.at("machine");
  const bool fits = curves.bodies + 1 == machine.at("bodies").size() && curves.joints == machine.at("joints").size() &&
                    curves.elements == machine.at("elements").size();
  if (fits) return;
  throw InputError({file.string(), 0, 0}, "belongs to another machine than the result beside it");
}

MachineResult read_result(const fs::path& file) {
  MachineResult result;
  const DataJson document = read_document(file, result.document);
  const std::string name = file.filename().string();
  const std::string stem = name.substr(0, name.size() - kEnding.size());
  try {
    for (std::size_t who = 0; who < 2; ++who) {
      const auto solver = document.at("solvers").at(who).at("name").get<std::string>();
      const fs::path run = file.parent_path() / fmt::format("{}.{}.nc", stem, solver);
      if (!fs::exists(run)) continue;
      result.runs[who] = read_curves(run, solver);
      require_same_machine(run, *result.runs[who], document);
    }
  } catch (const DataJson::exception& error) {
    throw InputError({file.string(), 0, 0}, fmt::format("is damaged: {}", error.what()));
  }
  return result;
}

/// The runs of both solvers over the samples that both have.
class RunData {
 public:
  RunData(const MachineResult& result, std::size_t bytes) : runs_(result.runs) {
    for (const auto& run : runs_) {
      if (run && (first_ == nullptr || run->t.size() < first_->t.size())) first_ = &*run;
    }
    if (first_ == nullptr || first_->t.empty()) return;
    samples_ = first_->t.size();
    for (const Samples Curves::*which : {&Curves::reaction, &Curves::element}) {
      for (std::size_t place = 0; place < (first_->*which).width; ++place) {
        if (!vanishes(which, place)) ++rows_;
      }
    }
    const double share = kShareOfCurves * static_cast<double>(bytes);
    points_ = static_cast<std::size_t>(share / static_cast<double>(kBytesOfNumber * std::max<std::size_t>(1, rows_)));
    points_ = std::clamp<std::size_t>(points_, 100, 1200);
    choose_frames((1.0 - kShareOfCurves) * static_cast<double>(bytes));
  }

  [[nodiscard]] DataJson data() const {
    if (samples_ == 0) return nullptr;
    const Bins bins(samples_, points_);
    const std::vector<double> t(first_->t.begin(), first_->t.begin() + static_cast<std::ptrdiff_t>(samples_));
    DataJson said{{"samples", samples_}, {"bins", bins.count()}, {"thinned", bins.thins()}};
    said["t"] = thin_times(bins, t);
    said["joints"] = items(bins, &Curves::reaction);
    said["elements"] = items(bins, &Curves::element);
    said["frames"] = frames();
    return said;
  }

 private:
  [[nodiscard]] bool vanishes(const Samples Curves::*which, std::size_t place) const {
    for (const auto& run : runs_) {
      if (!run) continue;
      for (std::size_t k = 0; k < samples_; ++k) {
        if (((*run).*which).at(k, place) != 0.0) return false;
      }
    }
    return true;
  }

  /// A component by both solvers; null where it is zero throughout.
  [[nodiscard]] DataJson row(const Bins& bins, const Samples Curves::*which, std::size_t place) const {
    if (vanishes(which, place)) return nullptr;
    DataJson said = DataJson::object();
    const std::array<const char*, 2> names{"a", "b"};
    for (std::size_t who = 0; who < 2; ++who) {
      if (!runs_[who]) continue;
      const Samples& samples = (*runs_[who]).*which;
      said[names[who]] = packed(thin(bins, [&](std::size_t k) { return samples.at(k, place); }));
    }
    if (runs_[0] && runs_[1]) {
      const Samples& one = (*runs_[0]).*which;
      const Samples& other = (*runs_[1]).*which;
      said["d"] = packed(largest_sizes(bins, [&](std::size_t k) { return other.at(k, place) - one.at(k, place); }));
    }
    return said;
  }

  [[nodiscard]] DataJson items(const Bins& bins, const Samples Curves::*which) const {
    DataJson all = DataJson::array();
    for (std::size_t item = 0; item < (first_->*which).width / 12; ++item) {
      DataJson sides = DataJson::array();
      for (std::size_t side = 0; side < 2; ++side) {
        DataJson components = DataJson::array();
        for (std::size_t c = 0; c < 6; ++c) components.push_back(row(bins, which, 12 * item + 6 * side + c));
        sides.push_back(std::move(components));
      }
      all.push_back(std::move(sides));
    }
    return all;
  }

  void choose_frames(double bytes) {
    const std::size_t numbers =
        2 * (first_->bodies * (7 + first_->modes) + 6 * (first_->joints + first_->elements)) + 1;
    const double affordable = bytes / (16.0 / 3.0 * static_cast<double>(numbers));
    const auto most = static_cast<std::size_t>(std::clamp(affordable, 40.0, 400.0));
    const std::size_t count = std::min(samples_, most);
    for (std::size_t k = 0; k < count; ++k) {
      frames_.push_back(count < 2 ? 0 : (k * (samples_ - 1) + (count - 1) / 2) / (count - 1));
    }
  }

  [[nodiscard]] std::string picked(const Samples& samples, std::size_t stride, std::size_t first,
                                   std::size_t count) const {
    std::vector<double> numbers;
    for (const std::size_t k : frames_) {
      for (std::size_t start = 0; start < samples.width; start += stride) {
        for (std::size_t c = first; c < first + count; ++c) numbers.push_back(samples.at(k, start + c));
      }
    }
    return packed(numbers);
  }

  /// Poses and wrenches on the children, global axes, at some times.
  [[nodiscard]] DataJson frames() const {
    DataJson said;
    std::vector<double> times;
    for (const std::size_t k : frames_) times.push_back(first_->t[k]);
    said["t"] = std::move(times);
    said["modes"] = first_->modes;
    said["runs"] = DataJson::array();
    for (const auto& run : runs_) {
      if (!run) {
        said["runs"].push_back(nullptr);
        continue;
      }
      DataJson one{{"r", picked(run->position, 3, 0, 3)}, {"p", picked(run->euler, 4, 0, 4)}};
      if (run->modes > 0) one["a"] = picked(run->modal, run->modes, 0, run->modes);
      one["joints"] = picked(run->reaction_global, 12, 6, 6);
      one["elements"] = picked(run->element_global, 12, 6, 6);
      said["runs"].push_back(std::move(one));
    }
    return said;
  }

  const std::array<std::optional<Curves>, 2>& runs_;
  const Curves* first_ = nullptr;  // the shorter one
  std::size_t samples_ = 0;
  std::size_t rows_ = 0;
  std::size_t points_ = 0;
  std::vector<std::size_t> frames_;
};

/// The check on which the digits have the least margin above what is asked, of the rows that are judged; `below`: only
/// if it misses that.
std::string nearest_to_need(const DataJson& document, bool below) {
  constexpr std::array<const char*, 3> kNames{"at the same state", "in the same run", "refined"};
  double least = below ? 0.0 : 1e300;
  std::string text;
  for (const DataJson& row : document.at("rows")) {
    for (std::size_t check = 0; check < kNames.size(); ++check) {
      const DataJson& digits = row.at("digits").at(check);
      if (!digits.is_number()) continue;
      const auto need = row.at("need").at(check).get<double>();
      if (digits.get<double>() - need >= least) continue;
      least = digits.get<double>() - need;
      const bool by_resolution = !below && least < 0.0 && row.at("by_resolution").get<bool>();
      text = fmt::format("{} digits {} where {:g} are asked{}", format_digits(digits.get<double>()), kNames[check],
                         need, by_resolution ? ", which is all that double precision resolves there" : "");
    }
  }
  return text;
}

}  // namespace

std::vector<MachineResult> read_results(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code trouble;
  for (const auto& entry : fs::directory_iterator(folder, trouble)) {
    if (entry.path().filename().string().ends_with(kEnding)) files.push_back(entry.path());
  }
  if (trouble) throw InputError({folder.string(), 0, 0}, fmt::format("cannot be read: {}", trouble.message()));
  if (files.empty()) {
    throw InputError({folder.string(), 0, 0},
                     fmt::format("holds no results: {}; files MODEL.result.json, which `concord compare --out` writes, "
                                 "were expected",
                                 names_of(folder)));
  }
  std::sort(files.begin(), files.end());
  std::vector<MachineResult> results;
  for (const fs::path& file : files) results.push_back(read_result(file));
  return results;
}

std::string sentence_of(const DataJson& document) {
  const auto outcome = document.at("outcome").get<std::string>();
  const auto name = document.at("model").get<std::string>();
  const auto judged = document.at("judged").get<int>();
  const auto total = document.at("total").get<int>();
  const std::string nearest = nearest_to_need(document, outcome != "agree");
  if (outcome == "agree") {
    const std::string count = judged == total ? fmt::format("all {}", total) : fmt::format("{} of {}", judged, total);
    const auto instead = document.value("judged_instead", std::string());
    return fmt::format("Both solvers agree on {} load components of {}{}{}.", count, name,
                       instead.empty() ? "" : ": " + instead,
                       nearest.empty() ? "" : "; nearest to its need: " + nearest);
  }
  if (outcome == "differ") {
    const std::size_t count = document.at("findings").size();
    return fmt::format("The results on {} differ: {} {}{}.", name, count, count == 1 ? "finding" : "findings",
                       nearest.empty() ? "" : "; farthest below its need: " + nearest);
  }
  const DataJson& failures = document.at("failures");
  return fmt::format("There is no verdict on {}{}", name,
                     failures.empty() ? "." : ": " + failures.front().get<std::string>());
}

DataJson machine_data(const MachineResult& result, std::size_t bytes) {
  DataJson document = DataJson::parse(result.document);
  document["sentence"] = sentence_of(document);
  for (std::size_t who = 0; who < 2; ++who) {
    if (result.runs[who] || !result.runs[1 - who]) continue;
    document["notes"].push_back(fmt::format("there is no run of {}: its file is missing, or it did not finish",
                                            document.at("solvers").at(who).at("name").get<std::string>()));
  }
  document["runs"] = RunData(result, bytes).data();
  return document;
}

}  // namespace concord::compare::page
