#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/model.h"
#include "compare/reread/second_reading.h"
#include "compare/verdict/verdict.h"

/// A model, read from its file and held against a second reading of it: what all solve must be what the file says.
namespace concord::compare {

/// A model that is not what its file says. Its text: what differs, a line each, and who is to blame.
class MisreadModel : public std::runtime_error {
 public:
  MisreadModel(Model model, SecondReading reading);

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const SecondReading& reading() const { return reading_; }

 private:
  Model model_;
  SecondReading reading_;
};

/// As read_model() and parse_model(). Throws MisreadModel where the second reading finds another number, besides what
/// these throw.
Model read_twice(const std::filesystem::path& file, const std::map<std::string, double>& parameters = {});
Model parse_twice(std::string_view text, const std::filesystem::path& file);

/// The verdict on a model that was misread: differs, and no solver was asked.
Verdict verdict_on(const MisreadModel& misread);

}  // namespace concord::compare
