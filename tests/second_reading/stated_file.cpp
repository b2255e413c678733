#include "tests/second_reading/stated_file.h"

#include <utility>

namespace concord::second_reading {

namespace {

using Given = std::map<std::string, double>;

void collect_names(StatedFile& file) {
  const auto collect = [&](const char* table, Names kind) {
    const toml::array* items = file.root[table].as_array();
    if (items == nullptr) return;
    for (const toml::node& item : *items) {
      if (!item.is_table()) continue;
      file.names[static_cast<std::size_t>(kind)].insert(item.as_table()->at_path("name").value_or(std::string()));
    }
  };
  collect("body", Names::bodies);
  collect("road", Names::roads);
  collect("joint", Names::joints);
  collect("coupling", Names::couplings);
  for (const char* table : kElementTables) collect(table, Names::elements);
}

std::unique_ptr<StatedFile> make_file(toml::table root, const std::filesystem::path& path, const Given& given,
                                      const StatedFile* outer, const std::string& prefix, Ledger& ledger) {
  auto file = std::make_unique<StatedFile>();
  file->path = path;
  file->root = std::move(root);
  file->prefix = prefix;
  file->outer = outer;
  const toml::table* own = file->root["parameters"].as_table();
  file->scope = std::make_unique<Scope>(own, given, outer != nullptr ? outer->scope.get() : nullptr);
  file->top = std::make_unique<StatedTable>(file->root, *file, ledger, "model", "");
  return file;
}

void open_includes(StatedFile& file, Ledger& ledger) {
  collect_names(file);
  for (const StatedTable& include : file.top->tables("include")) {
    const std::string prefix = include.text("prefix").value_or("");
    Given given;
    if (const auto parameters = include.table("parameters")) {
      for (const std::string& name : parameters->keys()) given[name] = *parameters->number(name);
    }
    const std::filesystem::path path = file.path.parent_path() / include.text("file").value_or("");
    auto inner = make_file(toml::parse_file(path.string()), path, given, &file, file.prefix + prefix, ledger);
    open_includes(*inner, ledger);
    for (std::size_t kind = 0; kind < file.names.size(); ++kind) {
      for (const std::string& name : inner->names[kind]) file.names[kind].insert(prefix + name);
    }
    file.includes.push_back(std::move(inner));
  }
}

std::unique_ptr<StatedFile> open_root(toml::table root, const std::filesystem::path& path, const Given& given,
                                      Ledger& ledger) {
  auto file = make_file(std::move(root), path, given, nullptr, "", ledger);
  open_includes(*file, ledger);
  return file;
}

}  // namespace

std::string StatedFile::full_name(Names kind, const std::string& name) const {
  if (names[static_cast<std::size_t>(kind)].contains(name)) return prefix + name;
  return outer != nullptr ? outer->full_name(kind, name) : name;
}

std::unique_ptr<StatedFile> open_file(const std::filesystem::path& path, Ledger& ledger) {
  return make_file(toml::parse_file(path.string()), path, {}, nullptr, "", ledger);
}

std::unique_ptr<StatedFile> open_model(const std::filesystem::path& path, const Given& given, Ledger& ledger) {
  return open_root(toml::parse_file(path.string()), path, given, ledger);
}

std::unique_ptr<StatedFile> open_model_text(std::string_view text, const std::filesystem::path& path, Ledger& ledger) {
  return open_root(toml::parse(text), path, {}, ledger);
}

std::vector<const StatedFile*> all_files(const StatedFile& file) {
  std::vector<const StatedFile*> files{&file};
  for (const auto& include : file.includes) {
    const std::vector<const StatedFile*> inner = all_files(*include);
    files.insert(files.end(), inner.begin(), inner.end());
  }
  return files;
}

}  // namespace concord::second_reading
