#include "compare/report/origin.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "compare/report/files.h"
#include "concord_commit.h"

namespace concord::compare {

namespace {

std::string compiler_words() {
#if defined(__clang__)
  return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#else
  return fmt::format("gcc {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
}

std::string processor_words() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "processor unknown";
}

std::string machine_words() {
  utsname system{};
  if (uname(&system) != 0) return "unknown";
  return fmt::format("{}: {}, {} processors, {}, {} {}", system.nodename, system.machine,
                     std::thread::hardware_concurrency(), processor_words(), system.sysname, system.release);
}

/// It is read once.
std::uint64_t hash_of_program() {
  static const std::uint64_t hash = hash_of_file("/proc/self/exe");
  return hash;
}

}  // namespace

Origin origin_of_program(const std::string& commit) {
  const char* said = std::getenv("CONCORD_COMMIT");
  const bool is_said = said != nullptr && *said != '\0';
  const std::string words = !commit.empty() ? commit
                            : is_said       ? said
                                            : tell_builds_apart(CONCORD_COMMIT, hash_of_program());
  return {"concord " CONCORD_VERSION, words, compiler_words(), machine_words()};
}

std::string tell_builds_apart(const std::string& commit, std::uint64_t build) {
  const bool is_told = commit != "unknown" && !commit.ends_with("-dirty");
  return is_told ? commit : fmt::format("{}.{:08x}", commit, static_cast<std::uint32_t>(build));
}

std::string version_words() {
  return fmt::format("concord {} ({}, {})", CONCORD_VERSION, CONCORD_COMMIT, compiler_words());
}

std::string build_words() { return fmt::format("{}, build {:016x}", version_words(), hash_of_program()); }

}  // namespace concord::compare
