#include "common/reading/text_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "common/error.h"

namespace concord {

namespace {

std::string_view kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a fifo";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

/// An open file, closed at the end.
class OpenFile {
 public:
  /// Does not wait for somebody to write into a fifo.
  explicit OpenFile(const std::filesystem::path& path)
      : file_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}
  ~OpenFile() {
    if (file_ >= 0) ::close(file_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] bool is_open() const { return file_ >= 0; }
  [[nodiscard]] mode_t mode() const {
    struct stat found {};
    return ::fstat(file_, &found) == 0 ? found.st_mode : 0;
  }

  /// Appends the next bytes to `text`; 0 at the end, negative if the system refuses.
  ssize_t read_more(std::string& text) {
    std::array<char, 65536> bytes;
    ssize_t count = 0;
    do {
      count = ::read(file_, bytes.data(), bytes.size());
    } while (count < 0 && errno == EINTR);
    if (count > 0) text.append(bytes.data(), static_cast<std::size_t>(count));
    return count;
  }

 private:
  int file_;
};

}  // namespace

std::string read_text_file(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& reason) {
    throw InputError(SourceLocation{.file = file.generic_string()}, reason);
  };
  OpenFile open_file(file);
  const bool holds_nul = file.native().find('\0') != std::string::npos;
  const int why_not = errno;
  if (holds_nul || (!open_file.is_open() && (why_not == ENOENT || why_not == ENOTDIR))) {
    refuse("cannot read the file: is the path right?");
  }
  if (!open_file.is_open()) refuse(fmt::format("cannot read the file: {}", std::strerror(why_not)));
  if (!S_ISREG(open_file.mode())) {
    refuse(fmt::format("cannot read the file: it is {}, expected a regular file", kind_of(open_file.mode())));
  }
  std::string text;
  ssize_t count = 0;
  while ((count = open_file.read_more(text)) > 0) {
    if (text.size() > kMostBytes) refuse(fmt::format("the file is longer than {} MiB", kMostBytes >> 20U));
  }
  if (count < 0) refuse(fmt::format("cannot read the file: {}", std::strerror(errno)));
  return text;
}

}  // namespace concord
