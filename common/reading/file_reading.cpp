#include "common/reading/file_reading.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace concord {

namespace {

bool stands_before(const SourceLocation& a, const SourceLocation& b) {
  return a.line != b.line ? a.line < b.line : a.column < b.column;
}

/// More complaints than this are not reported.
constexpr std::size_t kMostComplaints = 200;

}  // namespace

SourceLocation FileReading::at(const toml::source_region& region) const {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

std::string FileReading::word_at(const toml::source_region& region) const {
  std::size_t at = 0;
  for (auto line = region.begin.line; line > 1 && at < text.size(); --line) at = text.find('\n', at) + 1;
  const auto goes_on = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };  // a byte of a letter
  for (auto column = region.begin.column; column > 1 && at < text.size(); --column) {
    do {
      ++at;
    } while (at < text.size() && goes_on(text[at]));
  }
  if (at >= text.size()) return "";
  return text.substr(at, text.find_first_of(" \t\r\n,]}#", at) - at);
}

void FileReading::complain(const SourceLocation& where, std::string message) {
  complaints.push_back({where, std::move(message)});
  if (complaints.size() < kMostComplaints) return;
  std::vector<Diagnostic> all = sorted_complaints();
  all.push_back({where, fmt::format("too many errors: these are the first {}", kMostComplaints)});
  throw InputError(std::move(all));
}

std::vector<Diagnostic> FileReading::sorted_complaints() const {
  std::vector<Diagnostic> sorted = complaints;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Diagnostic& a, const Diagnostic& b) { return stands_before(a.where, b.where); });
  return sorted;
}

void FileReading::throw_if_any() const {
  if (!complaints.empty()) throw InputError(sorted_complaints());
}

bool FileReading::defines(std::string_view kind, const std::string& name) const {
  const auto own = own_names.find(kind);
  return own != own_names.end() && own->second.contains(name);
}

std::string FileReading::name_in_model(std::string_view kind, const std::string& name) const {
  if (defines(kind, name)) return prefix + name;
  return includer != nullptr ? includer->name_in_model(kind, name) : name;
}

std::string FileReading::name_in_file(std::string_view kind, const std::string& name) const {
  if (name.starts_with(prefix) && defines(kind, name.substr(prefix.size()))) return name.substr(prefix.size());
  return includer != nullptr ? includer->name_in_file(kind, name) : name;
}

}  // namespace concord
