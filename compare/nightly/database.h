#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

/// SQLite with errors as exceptions.
namespace concord::compare::nightly {

/// The file cannot be read or written any more: a full disk, a lock that does not end, damage. What was stored before
/// stays.
class DatabaseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Database;

/// One statement, used again and again: bind all its parameters in their order, then step.
class Statement {
 public:
  Statement(Database& database, const char* text);

  Statement& bind(const std::string& value);
  Statement& bind(long value);
  Statement& bind(int value) { return bind(static_cast<long>(value)); }
  Statement& bind(double value);
  Statement& bind(const std::optional<double>& value);

  /// The next row, if there is one; without one the statement is ready to be bound again.
  bool step();
  /// Runs a statement that has no rows.
  void run();
  /// Forgets rows that were not read.
  void reset();

  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] long whole(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::optional<double> optional_real(int column) const;
  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] int columns() const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  void check(int code) const;

  Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int bound_ = 0;
};

/// What a file is opened for: only to be read, it must be there, and nothing is made beside it where the reader may not
/// write: what SQLite leaves there would keep its owner from writing.
enum class Access { write, read };

class Database {
 public:
  /// Opens the file; to be written, creates it if it is not there. Throws InputError if it is something else than a
  /// SQLite file, DatabaseError if it cannot be used.
  explicit Database(const std::filesystem::path& file, Access access = Access::write);

  /// Whether changes can be stored.
  [[nodiscard]] bool is_writable() const { return is_writable_; }

  /// Every change is on its way to the disk when a transaction ends, and a write-ahead log lets others read meanwhile;
  /// on a network's file system, where computers cannot share such a log, a rollback journal.
  /// Changes the head of the file: to be called when it is known to be ours.
  void use_write_ahead_log();

  void execute(const std::string& text);
  [[nodiscard]] long pragma(const std::string& name);
  [[nodiscard]] long last_row() const;

  [[nodiscard]] sqlite3* get() const { return database_.get(); }
  [[noreturn]] void fail(int code) const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::string file_;
  bool is_writable_ = true;
  std::unique_ptr<sqlite3, Close> database_;
};

/// Whether statfs(2) gives this type to a file system that other computers may write at the same time.
bool is_network_file_system(std::uint32_t type);

/// All or nothing: rolled back unless committed. Waits for other programs that write.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();

 private:
  Database* database_;
  bool is_open_ = true;
};

}  // namespace concord::compare::nightly
