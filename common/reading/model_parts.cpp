#include "common/reading/model_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "common/reading/force_element_reader.h"
#include "common/reading/spelling.h"
#include "common/reading/text_file.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

namespace fs = std::filesystem;

constexpr int kFormat = 1;
/// Files that are included in all, each counted as often as it is, how deep, and their text together.
constexpr std::size_t kMostIncluded = 1000;
constexpr std::size_t kDeepestInclude = 30;
constexpr std::size_t kMostIncludedBytes = std::size_t{16} << 20U;
/// What other tables of a model refer to by name.
constexpr std::string_view kNamedKinds[] = {"body", "joint", "road"};

bool in_order(const ParameterDefinition& a, const ParameterDefinition& b) {
  return std::pair(a.where.line, a.where.column) < std::pair(b.where.line, b.where.column);
}

/// What is said of a file where it is included; of the model file its path alone.
struct Inclusion {
  fs::path file;
  std::string prefix;                           // of all its names, from the model file on
  std::vector<ParameterDefinition> parameters;  // instead of the file's own of these names
  std::string included_from;
  const FileReading* includer = nullptr;
  std::vector<fs::path> way;  // from the model file to this one, both included
};

/// The parameters of a file: those that are said where it is included, its own, those of the file that includes it.
void read_parameters(const std::vector<ParameterDefinition>& from_outside, ModelPart& part) {
  FileReading& reading = part.reading;
  std::vector<ParameterDefinition> definitions = from_outside;
  const auto is_said = [&](std::string_view name) {
    return std::any_of(from_outside.begin(), from_outside.end(), [&](const auto& one) { return one.name == name; });
  };
  if (const toml::table* found = part.document->table("parameters")) {
    for (const auto& [key, value] : *found) {
      if (is_said(key.str())) continue;
      ParameterDefinition& own = definitions.emplace_back();
      own.name = key.str();
      own.where = reading.at(value.source());
      if (value.is_number()) {
        own.value = number_in(value);
      } else if (value.is_string()) {
        own.value = **value.as_string();
      } else {
        reading.complain(own.where, fmt::format("parameter '{}': must be a number or an expression, found {}", own.name,
                                                type_name(value)));
      }
    }
  }
  std::sort(definitions.begin() + static_cast<std::ptrdiff_t>(from_outside.size()), definitions.end(), in_order);
  const Parameters outer = reading.includer != nullptr ? reading.includer->parameters : Parameters{};
  reading.parameters = Parameters(definitions, reading.complaints, outer);
}

/// Whether a name stands in a text, not as a part of a longer one.
bool has_word(std::string_view text, std::string_view name) {
  const auto is_of_a_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || !is_of_a_name(text[at - 1])) && (end == text.size() || !is_of_a_name(text[end]))) return true;
  }
  return false;
}

/// What an `[[include]]` says for parameters of the file, by expressions of the including file's.
std::vector<ParameterDefinition> read_overrides(const TableReader& include) {
  std::vector<ParameterDefinition> definitions;
  const toml::table* found = include.table("parameters");
  if (found == nullptr) return definitions;
  KnownKeys any;
  for (const auto& [key, value] : *found) any.push_back(key.str());
  const TableReader table(*found, include.title() + ", parameters", any, include.reading());
  for (const std::string_view key : any) {
    ParameterDefinition& definition = definitions.emplace_back();
    definition.name = key;
    definition.where = table.where(key);
    if (const auto value = table.number(key)) definition.value = *value;
  }
  std::sort(definitions.begin(), definitions.end(), in_order);
  return definitions;
}

class PartsReader {
 public:
  PartsReader(KnownKeys known, ModelParts& parts) : known_(std::move(known)), parts_(&parts) {}

  /// Reads the part and all that it includes; where the grammar is broken throws InputError.
  ModelPart& read(std::string_view text, const Inclusion& inclusion) {
    ModelPart& part = parts_->emplace_back();
    part.reading.file = inclusion.file.generic_string();
    part.reading.text = text;
    part.reading.prefix = inclusion.prefix;
    part.reading.includer = inclusion.includer;
    part.included_from = inclusion.included_from;
    part.root = parse(text, inclusion, part);
    part.document.emplace(part.root, "", known_, part.reading);
    check_format(*part.document, kFormat);
    read_parameters(inclusion.parameters, part);
    require_use(text, inclusion, part);
    for (const std::string_view kind : kNamedKinds) take_names(part, kind);
    for (const std::string_view kind : force_element_keys()) take_names(part, kind);
    for (const toml::table* table : part.document->tables("include")) read_include(*table, inclusion, part);
    return part;
  }

 private:
  static void take_names(ModelPart& part, std::string_view kind) {
    for (const NamedPlace& one : names_in(part, kind)) part.reading.own_names[std::string(kind)].insert(one.name);
  }

  /// A parameter that is said where a file is included and of which the file says nothing is a slip. What the file
  /// includes itself may use it.
  static void require_use(std::string_view text, const Inclusion& inclusion, ModelPart& part) {
    if (part.reading.includer == nullptr || !part.reading.complaints.empty()) return;
    if (!part.document->tables("include").empty()) return;
    for (const ParameterDefinition& said : inclusion.parameters) {
      if (has_word(text, said.name)) continue;
      part.reading.complain(said.where, fmt::format("include, parameters: unknown name '{}': '{}' neither defines nor "
                                                    "uses it; {}",
                                                    said.name, inclusion.file.filename().generic_string(),
                                                    suggestion(said.name, names_of_parameters(part), "parameters")));
    }
  }

  static std::vector<std::string> names_of_parameters(const ModelPart& part) {
    std::vector<std::string> names;
    if (const toml::table* found = part.document->table("parameters")) {
      for (const auto& [key, value] : *found) names.emplace_back(key.str());
    }
    return names;
  }

  /// The document; of an included file whose grammar is broken a sound one that says nothing, after a complaint.
  static toml::table parse(std::string_view text, const Inclusion& inclusion, ModelPart& part) {
    if (inclusion.way.size() == 1) return parse_toml(text, part.reading.file);
    try {
      return parse_toml(text, part.reading.file);
    } catch (const InputError& error) {
      part.reading.complaints = error.diagnostics();
      return toml::table{{"format", kFormat}};
    }
  }

  void read_include(const toml::table& found, const Inclusion& outer, ModelPart& part) {
    const TableReader table(found, "include", {"file", "prefix", "parameters"}, part.reading);
    Inclusion inner;
    const std::string own_prefix = table.text("prefix").value_or("");
    table.require_fit_for_files("prefix", own_prefix);
    inner.prefix = outer.prefix + own_prefix;
    inner.parameters = read_overrides(table);
    inner.includer = &part.reading;
    inner.way = outer.way;
    const SourceLocation where = table.where();
    inner.included_from = fmt::format("\n  included from {}:{}:{}", where.file, where.line, where.column);
    inner.included_from += outer.included_from;
    if (is_exhausted_ || !find_file(table, outer, inner)) return;
    const auto text = read_text(table, inner.file);
    if (!text || !is_within_limits(table, inner, text->size())) return;
    const ModelPart& included = read(*text, inner);
    for (const auto& [kind, names] : included.reading.own_names) {
      for (const std::string& name : names) part.reading.own_names[kind].insert(own_prefix + name);
    }
  }

  /// The file's text; nothing after a complaint.
  static std::optional<std::string> read_text(const TableReader& table, const fs::path& file) {
    try {
      return read_text_file(file);
    } catch (const InputError& error) {
      table.complain("file", fmt::format("'{}': {}", file.generic_string(), error.diagnostics().front().message));
      return std::nullopt;
    }
  }

  /// Whether one more file may be read. The first complaint ends all including: two includes in each of n files are
  /// 2^n.
  bool is_within_limits(const TableReader& table, const Inclusion& inner, std::size_t bytes) {
    bytes_ += bytes;
    if (parts_->size() > kMostIncluded) {
      table.complain("file", fmt::format("more than {} files are included in all", kMostIncluded));
    } else if (inner.way.size() > kDeepestInclude) {
      table.complain("file", fmt::format("files include each other more than {} deep", kDeepestInclude));
    } else if (bytes_ > kMostIncludedBytes) {
      table.complain("file", fmt::format("the included files have more than {} MiB in all", kMostIncludedBytes >> 20U));
    } else {
      return true;
    }
    is_exhausted_ = true;
    return false;
  }

  /// Where the file is; false after a complaint.
  static bool find_file(const TableReader& table, const Inclusion& outer, Inclusion& inner) {
    if (!table.require({"file"})) return false;
    const auto path = table.text("file");
    if (!path) return false;
    inner.file = (outer.file.parent_path() / *path).lexically_normal();
    std::error_code trouble;
    const fs::path file = fs::canonical(inner.file, trouble);
    if (trouble || path->find('\0') != std::string::npos) {
      table.complain("file", fmt::format("there is no file '{}'", inner.file.generic_string()));
      return false;
    }
    inner.way.push_back(inner.file);
    const auto is_it = [&](const fs::path& other) {
      std::error_code unknown;
      return fs::weakly_canonical(other, unknown) == file;
    };
    const auto begin = std::find_if(outer.way.begin(), outer.way.end(), is_it);
    if (begin == outer.way.end()) return true;
    std::string circle;
    for (auto step = begin; step != outer.way.end(); ++step) circle += step->generic_string() + " -> ";
    table.complain("file", fmt::format("goes round in a circle: {}{}", circle, inner.file.generic_string()));
    return false;
  }

  KnownKeys known_;
  ModelParts* parts_;
  std::size_t bytes_ = 0;
  bool is_exhausted_ = false;
};

}  // namespace

ModelParts read_model_parts(std::string_view text, const fs::path& file, KnownKeys known,
                            const std::vector<ParameterDefinition>& parameters) {
  known.insert(known.begin(), {"format", "parameters", "include"});
  ModelParts parts;
  Inclusion itself;
  itself.file = file;
  itself.parameters = parameters;
  itself.way = {file};
  PartsReader(std::move(known), parts).read(text, itself);
  return parts;
}

void throw_if_any(const ModelParts& parts) {
  std::vector<Diagnostic> all;
  std::set<std::string> told;
  for (const ModelPart& part : parts) {
    for (Diagnostic& complaint : part.reading.sorted_complaints()) {
      if (!told.insert(complaint.text()).second) continue;
      complaint.message += part.included_from;
      all.push_back(std::move(complaint));
    }
  }
  if (!all.empty()) throw InputError(std::move(all));
}

std::vector<NamedPlace> names_in(const ModelPart& part, std::string_view kind) {
  std::vector<NamedPlace> names;
  const toml::array* owners = part.root.contains(kind) ? part.root.get(kind)->as_array() : nullptr;
  if (owners == nullptr) return names;
  for (const toml::node& owner : *owners) {
    const toml::node* name = owner.is_table() ? owner.as_table()->get("name") : nullptr;
    if (name != nullptr && name->is_string()) {
      names.push_back({**name->as_string(), part.reading.at(name->source())});
    }
  }
  return names;
}

}  // namespace concord
