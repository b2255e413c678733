#include "compare/nightly/night_history.h"

#include <fmt/format.h>

#include <utility>

namespace concord::compare::nightly {

NightHistory::NightHistory(const std::filesystem::path& file, std::filesystem::path spare)
    : history_(std::make_unique<History>(file)), spare_(std::move(spare)) {}

void NightHistory::store(long night, const Result& result) {
  if (!trouble_) {
    try {
      return history_->store(night, result);
    } catch (const DatabaseError& error) {
      trouble_ = error;
    }
  }
  try {
    if (!is_copy_) go_on_in_copy();
    history_->store(night, result);
  } catch (const DatabaseError&) {
    throw *trouble_;
  }
}

void NightHistory::finish(long night, const std::string& now) {
  if (trouble_) return;
  try {
    history_->finish(night, now);
  } catch (const DatabaseError& error) {
    trouble_ = error;
  }
}

std::string NightHistory::trouble() const {
  return trouble_ ? fmt::format("{}; --resume goes on from there", trouble_->what()) : "";
}

void NightHistory::go_on_in_copy() {
  history_->copy_to(spare_);
  history_ = std::make_unique<History>(spare_);
  is_copy_ = true;
}

}  // namespace concord::compare::nightly
