#include "compare/nightly/database.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "common/error.h"
#include "compare/report/files.h"

namespace concord::compare::nightly {

namespace {

constexpr int kPatienceMs = 60000;  // for another program that writes

void check_readable(const std::filesystem::path& file) {
  std::error_code unknown;
  const auto refuse = [&](const char* why) { throw InputError({file.string(), 0, 0}, why); };
  if (!std::filesystem::exists(file, unknown)) refuse("there is no such file");
  if (!std::filesystem::is_regular_file(file, unknown)) refuse("is no file");
  if (std::filesystem::file_size(file, unknown) == 0) refuse("is no history: it is empty");
}

/// The file, and the log of changes beside it.
bool may_write_at(const std::filesystem::path& file) {
  return ::access(file.c_str(), W_OK) == 0 && ::access(file.parent_path().c_str(), W_OK) == 0;
}

/// What SQLite reads without making a file: as if nobody wrote, unless somebody does, whose files it then shares.
std::string read_only_name(const std::filesystem::path& file) {
  std::string name = "file:";
  for (const char c : file.string()) {
    const bool is_special = c == '%' || c == '?' || c == '#';
    name += is_special ? fmt::format("%{:02X}", static_cast<unsigned char>(c)) : std::string(1, c);
  }
  std::error_code unknown;
  const auto log = std::filesystem::file_size(file.string() + "-wal", unknown);
  const bool is_written = !unknown && log > 0;
  return is_written ? name : name + "?immutable=1";
}

bool lies_on_network(const std::string& file) {
  struct statfs system {};
  return statfs(file.c_str(), &system) == 0 && is_network_file_system(static_cast<std::uint32_t>(system.f_type));
}

}  // namespace

bool is_network_file_system(std::uint32_t type) {
  // statfs(2): NFS, SMB, CIFS, SMB2, FUSE (sshfs, GlusterFS), Lustre, GPFS, BeeGFS, Ceph, AFS, GFS2, OCFS2, PanFS, 9P.
  constexpr std::array<std::uint32_t, 14> kTypes{0x6969,     0x517b,     0xff534d42, 0xfe534d42, 0x65735546,
                                                 0x0bd00bd0, 0x47504653, 0x19830326, 0x00c36400, 0x5346414f,
                                                 0x01161970, 0x7461636f, 0xaad7aaea, 0x01021997};
  return std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end();
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement::Statement(Database& database, const char* text) : database_(&database) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database.get(), text, -1, &statement, nullptr);
  statement_.reset(statement);
  check(code);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) database_->fail(code);
}

Statement& Statement::bind(const std::string& value) {
  check(sqlite3_bind_text(statement_.get(), ++bound_, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind(long value) {
  check(sqlite3_bind_int64(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(double value) {
  check(sqlite3_bind_double(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(const std::optional<double>& value) {
  if (value) return bind(*value);
  check(sqlite3_bind_null(statement_.get(), ++bound_));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) {
    sqlite3_reset(statement_.get());
    bound_ = 0;
    database_->fail(code);
  }
  reset();
  return false;
}

void Statement::run() {
  while (step()) continue;
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  bound_ = 0;
}

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return bytes == nullptr ? "" : std::string(bytes, sqlite3_column_bytes(statement_.get(), column));
}

long Statement::whole(int column) const { return sqlite3_column_int64(statement_.get(), column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }
bool Statement::is_null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }

int Statement::columns() const { return sqlite3_column_count(statement_.get()); }

std::optional<double> Statement::optional_real(int column) const {
  return is_null(column) ? std::nullopt : std::optional(real(column));
}

void Database::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Database::Database(const std::filesystem::path& file, Access access) : file_(file.string()) {
  // With its folder: SQLite means something else by ":memory:" and "file:...".
  std::string name = std::filesystem::absolute(file).string();
  int flags = SQLITE_OPEN_READWRITE;
  if (access == Access::write) {
    std::error_code unknown;
    // Nothing is replaced: a link is followed.
    const bool is_link = std::filesystem::is_symlink(file, unknown) && std::filesystem::exists(file, unknown);
    check_target(is_link ? std::filesystem::canonical(file) : file);
    make_folder(file.parent_path());
    flags |= SQLITE_OPEN_CREATE;
  } else {
    check_readable(file);
    is_writable_ = may_write_at(std::filesystem::canonical(file));
    if (!is_writable_) {
      name = read_only_name(std::filesystem::canonical(file));
      flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI;
    }
  }
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &database, flags, nullptr);
  database_.reset(database);
  if (code != SQLITE_OK) fail(code);
  sqlite3_busy_timeout(database, kPatienceMs);
  // Reads the head of the file: a file of another kind is refused before anything is written.
  static_cast<void>(pragma("schema_version"));
}

void Database::use_write_ahead_log() {
  constexpr int kTries = 100;
  const bool is_shared = lies_on_network(file_);
  const char* mode = is_shared ? "PRAGMA journal_mode = DELETE" : "PRAGMA journal_mode = WAL";
  for (int k = 0; k < kTries; ++k) {
    const int code = sqlite3_exec(database_.get(), mode, nullptr, nullptr, nullptr);
    if (code == SQLITE_OK) break;
    // Two programs that open a new file at once are not made to wait by SQLite.
    if (code != SQLITE_BUSY || k + 1 == kTries) fail(code);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  execute(is_shared ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
  execute("PRAGMA foreign_keys = ON");
}

void Database::execute(const std::string& text) {
  const int code = sqlite3_exec(database_.get(), text.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

long Database::pragma(const std::string& name) {
  Statement statement(*this, fmt::format("PRAGMA {}", name).c_str());
  const long value = statement.step() ? statement.whole(0) : 0;
  return value;
}

long Database::last_row() const { return sqlite3_last_insert_rowid(database_.get()); }

void Database::fail(int code) const {
  const std::string reason = database_ ? sqlite3_errmsg(database_.get()) : sqlite3_errstr(code);
  if ((code & 0xff) == SQLITE_NOTADB) throw InputError({file_, 0, 0}, "is no history: " + reason);
  throw DatabaseError(fmt::format("the history {} cannot be used: {}; what was stored before stays", file_, reason));
}

Transaction::Transaction(Database& database) : database_(&database) { database.execute("BEGIN IMMEDIATE"); }

Transaction::~Transaction() {
  if (is_open_) sqlite3_exec(database_->get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_->execute("COMMIT");
  is_open_ = false;
}

}  // namespace concord::compare::nightly
