#pragma once

#include <cstdint>
#include <string>

namespace concord::compare {

/// Where results come from, in words. Shown beside them, never compared.
struct Origin {
  std::string version;   // "concord 0.1.0"
  std::string commit;    // "3f97bf0c1a2b"; "3f97bf0c1a2b-dirty.5e2a90c4" if sources were changed; "unknown.5e2a90c4"
  std::string compiler;  // "clang 14.0.6"
  std::string machine;   // "ci-3: x86_64, 2 processors, Intel ..., Linux 6.1"

  friend bool operator==(const Origin&, const Origin&) = default;
};

/// Of this program on this machine. The commit is `commit` if that is not empty, else what the environment says in
/// CONCORD_COMMIT, else the one that was built.
Origin origin_of_program(const std::string& commit = "");

/// A commit that does not tell which program was built from it gets the build's number.
std::string tell_builds_apart(const std::string& commit, std::uint64_t build);

/// "concord 0.1.0 (3f97bf0c1a2b, clang 14.0.6)".
std::string version_words();

/// The same, and a number that tells two builds apart.
std::string build_words();

}  // namespace concord::compare
