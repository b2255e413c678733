#include "tests/layout/source_sizes.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <regex>
#include <sstream>

namespace concord::layout {

namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Goes through a source and leaves out what is not code.
class Blanker {
 public:
  explicit Blanker(std::string_view source) : source_(source), code_(source) {}

  std::string run() {
    while (at_ < source_.size()) {
      if (starts("//") || (source_[at_] == '#' && is_first_of_line())) {
        blank_line();
      } else if (starts("/*")) {
        blank_to(source_.find("*/", at_ + 2), 2);
      } else if (starts("R\"") && !follows_word()) {
        const std::size_t open = source_.find('(', at_);
        const std::string close = ")" + std::string(source_.substr(at_ + 2, open - at_ - 2)) + "\"";
        blank_to(source_.find(close, open), close.size());
      } else if (source_[at_] == '"' || (source_[at_] == '\'' && !follows_word())) {
        blank_quoted(source_[at_]);
      } else {
        ++at_;
      }
    }
    return std::move(code_);
  }

 private:
  [[nodiscard]] bool starts(std::string_view with) const { return source_.substr(at_, with.size()) == with; }
  /// A quote within a number separates its digits.
  [[nodiscard]] bool follows_word() const { return at_ > 0 && is_word(source_[at_ - 1]); }
  [[nodiscard]] bool is_first_of_line() const {
    const std::size_t end = source_.find_last_not_of(" \t", at_ == 0 ? 0 : at_ - 1);
    return at_ == 0 || end == std::string_view::npos || source_[end] == '\n';
  }

  void blank_one() {
    if (source_[at_] != '\n') code_[at_] = ' ';
    ++at_;
  }

  void blank_to(std::size_t last, std::size_t length) {
    const std::size_t end = last == std::string_view::npos ? source_.size() : last + length;
    while (at_ < end) blank_one();
  }

  /// To the end of the line, and of the next one after a backslash.
  void blank_line() {
    while (at_ < source_.size() && (source_[at_] != '\n' || source_[at_ - 1] == '\\')) blank_one();
  }

  void blank_quoted(char quote) {
    blank_one();
    while (at_ < source_.size() && source_[at_] != quote) {
      if (source_[at_] == '\\') blank_one();
      if (at_ < source_.size()) blank_one();
    }
    if (at_ < source_.size()) blank_one();
  }

  std::string_view source_;
  std::string code_;
  std::size_t at_ = 0;
};

/// What a pair of braces holds.
enum class Scope { names, function, other };

/// Goes through code and notes every function at its closing brace.
class Scanner {
 public:
  explicit Scanner(const std::string& code) : code_(code) {}

  std::vector<FunctionSize> run() {
    for (at_ = 0; at_ < code_.size(); ++at_) {
      const char c = code_[at_];
      if (c == '\n') ++line_;
      if (c == '(') ++parentheses_;
      if (c == ')') --parentheses_;
      if (c == '{') open();
      if (c == '}') close();
      if ((c == ';' && parentheses_ == 0) || (c == ':' && is_access(head()))) {
        begin_anew();
        continue;
      }
      if (head_line_ == 0 && std::isspace(static_cast<unsigned char>(c)) == 0 && c != '}' && c != '{') {
        head_line_ = line_;
        head_ = at_;
      }
    }
    std::sort(found_.begin(), found_.end(),
              [](const FunctionSize& a, const FunctionSize& b) { return a.first_line < b.first_line; });
    return std::move(found_);
  }

 private:
  struct Open {
    Scope scope;
    int parentheses;
    bool ends_head;  // whether what follows the closing brace is a new declaration
    FunctionSize function;
  };

  void begin_anew() { head_line_ = 0; }

  /// The declaration up to here.
  [[nodiscard]] std::string head() const { return head_line_ == 0 ? "" : code_.substr(head_, at_ - head_); }

  [[nodiscard]] bool holds_names() const { return open_.empty() || open_.back().scope == Scope::names; }

  void open() {
    Open one{Scope::other, parentheses_, false, {}};
    const int outer = open_.empty() ? 0 : open_.back().parentheses;
    if (holds_names() && parentheses_ == outer) {
      static const std::regex kNames(R"((^|[^\w])(namespace|class|struct|union|extern)\b)");
      const std::string text = head();
      const std::string plain = without_templates(text);
      if (text.find('(') != std::string::npos && !opens_initializer(plain)) {
        one = {Scope::function, parentheses_, true, {name_in(plain), head_line_, 0}};
      } else if (std::regex_search(plain, kNames) && text.find('(') == std::string::npos) {
        one = {Scope::names, parentheses_, true, {}};
      }
    }
    open_.push_back(one);
    if (one.ends_head) begin_anew();
  }

  void close() {
    if (open_.empty()) return;
    Open one = open_.back();
    open_.pop_back();
    parentheses_ = one.parentheses;
    if (one.scope == Scope::function) {
      one.function.lines = line_ - one.function.first_line + 1;
      found_.push_back(one.function);
    }
    if (one.ends_head) begin_anew();
  }

  /// "public" and the like, before its colon.
  static bool is_access(const std::string& head) {
    static const std::regex kAccess(R"(\s*(public|protected|private)\s*)");
    return std::regex_match(head, kAccess);
  }

  /// "Foo(int a) : a_" or "Foo(int a) : a_(a), b_": the brace is a member's; "Foo x = make(a)": a value's.
  static bool opens_initializer(const std::string& head) {
    static const std::regex kMember(R"(\)\s*(noexcept\s*)?:[^:].*[\w>]\s*$)");
    static const std::regex kValue(R"([^=!<>]=\s*[^=][^(]*\{?$|^[^(]*[^r=!<>(]=[^=])");
    static const std::regex kOperator(R"(operator\s*[^\s\w(]+)");
    std::string flat = std::regex_replace(head, kOperator, "operator");
    std::replace(flat.begin(), flat.end(), '\n', ' ');
    return std::regex_search(flat, kMember) || std::regex_search(flat, kValue);
  }

  static std::string without_templates(const std::string& head) {
    static const std::regex kTemplate(R"(^\s*template\s*<[^{}]*?>\s*(?=[\w\[]))");
    return std::regex_replace(head, kTemplate, "");
  }

  static std::string name_in(const std::string& head) {
    static const std::regex kName(R"((operator\s*[^\s\w(]+|operator\(\)|[\w:~]+)\s*\()");
    std::smatch match;
    return std::regex_search(head, match, kName) ? match[1].str() : "?";
  }

  const std::string& code_;
  std::size_t at_ = 0;
  int line_ = 1;
  int parentheses_ = 0;
  std::size_t head_ = 0;
  int head_line_ = 0;  // 0: no declaration has begun
  std::vector<Open> open_;
  std::vector<FunctionSize> found_;
};

}  // namespace

std::string without_texts(std::string_view source) { return Blanker(source).run(); }

std::vector<FunctionSize> function_sizes(std::string_view source) {
  const std::string code = without_texts(source);
  return Scanner(code).run();
}

int count_lines(std::string_view source) {
  const auto ends = static_cast<int>(std::count(source.begin(), source.end(), '\n'));
  return ends + (source.empty() || source.back() == '\n' ? 0 : 1);
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::map<std::string, std::string> sources(const std::filesystem::path& root) {
  namespace fs = std::filesystem;
  std::map<std::string, std::string> found;
  for (const char* folder : {"common", "cartesian", "relative", "compare"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".h") continue;
      found[fs::relative(entry.path(), root).generic_string()] = text_of(entry.path());
    }
  }
  return found;
}

}  // namespace concord::layout
