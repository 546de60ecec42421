#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/read_files.h"

/// Helpers that readers of mesh files share.
namespace kinome {

/// Formats an index from a file; whole numbers have no decimals.
inline std::string format_index(double index) {
  return std::abs(index) < 1e15 && index == std::floor(index)
             ? std::to_string(static_cast<int64_t>(index))
             : std::to_string(index);
}

/// Replaces line ends '\r' (Mac OS before X) by '\n'. Other text is unchanged.
inline std::string with_newlines(std::string text) {
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  return text;
}

/// Warns that a mesh has no faces and is thus invisible.
inline void warn_of_no_faces(const std::string& file) {
  log_warn(Error(Location{file, 0, 0}, "the file has no faces: the shape is invisible").what());
}

/// Reads text line by line and word by word, and keeps the position for error messages.
class TextCursor {
 public:
  /// With `has_comments`, '#' begins a comment that ends with the line.
  TextCursor(std::string file, std::string_view text, int line = 1, bool has_comments = false)
      : file_(std::move(file)),
        next_(text.data()),
        end_(text.data() + text.size()),
        line_start_(next_),
        word_(next_),
        line_(line),
        has_comments_(has_comments) {}

  int line() const { return line_; }
  size_t bytes_left() const { return static_cast<size_t>(end_ - next_); }
  bool at_end() const { return next_ == end_; }
  /// Skips blanks, and a backslash that continues the line. A comment counts as the line's end.
  bool at_line_end() {
    while (next_ != end_) {
      if (*next_ == ' ' || *next_ == '\t' || *next_ == '\r') {
        ++next_;
      } else if (*next_ == '\\' && continues_line()) {
        next_ += next_[1] == '\r' ? 3 : 2;
        start_line();
      } else {
        return ends_line(*next_);
      }
    }
    return true;
  }
  void next_line() {
    while (next_ != end_ && *next_ != '\n') ++next_;
    if (next_ != end_) {
      ++next_;
      start_line();
    }
  }
  /// Moves to the first line that isn't blank. Returns false at the end of the text.
  bool skip_blank_lines() {
    while (at_line_end()) {
      if (at_end()) return false;
      next_line();
    }
    return true;
  }
  /// Returns the next word of the line; empty at its end.
  std::string_view word() {
    const bool is_end = at_line_end();
    word_ = next_;
    if (is_end) return {};
    // Only characters up to '#', and '\\', can end a word.
    while (next_ != end_ &&
           !((static_cast<unsigned char>(*next_) <= '#' || *next_ == '\\') && ends_word())) {
      ++next_;
    }
    return {word_, static_cast<size_t>(next_ - word_)};
  }
  /// Reads the next word as a number. `what` is the expected quantity, for error messages.
  double number(const char* what) { return number(word(), what); }
  /// Returns the value of the last word read.
  double number(std::string_view text, const char* what) const {
    if (text.empty()) fail(std::string("expected ") + what + ", but the line ends");
    if (text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (rest == text.data() + text.size() && error == std::errc()) return value;
    if (error == std::errc::result_out_of_range) return extreme_number(text, what);
    // Non-finite numbers as written by Microsoft's C library: 1.#QNAN, -1.#IND00, 1.#INF.
    if (text.find(".#") != std::string_view::npos) return NAN;
    fail(std::string("expected ") + what + ", got '" + shorten(text) + "'");
  }
  /// Throws Error at the last word read.
  [[noreturn]] void fail(const std::string& message) const { throw error_here(message); }
  Error error_here(const std::string& message) const {
    return Error(Location{file_, line_,
                          1 + static_cast<int>(std::max(word_ - line_start_, std::ptrdiff_t{0}))},
                 message);
  }
  Error error_at(int line, const std::string& message) const {
    return Error(Location{file_, line, 1}, message);
  }
  [[noreturn]] void fail_at(int line, const std::string& message) const {
    throw error_at(line, message);
  }
  /// Returns at most 40 printable characters: words of a damaged file may be megabytes of any
  /// bytes.
  static std::string shorten(std::string_view text) {
    std::string clean;
    for (const char c : text.substr(0, 40)) clean += c >= ' ' && c <= '~' ? c : '?';
    return text.size() > 40 ? clean + "…" : clean;
  }

 private:
  /// True at the '#' in "1.#QNAN", which doesn't begin a comment.
  bool is_within_number() const { return *next_ == '#' && next_ != word_ && next_[-1] == '.'; }
  bool ends_line(char c) const { return c == '\n' || (c == '#' && has_comments_); }
  bool ends_word() const {
    const char c = *next_;
    return c == ' ' || c == '\t' || c == '\r' || (ends_line(c) && !is_within_number()) ||
           (c == '\\' && continues_line());
  }

  /// Returns the value of a number that is too small for double: about 0. Throws if it is too
  /// large.
  double extreme_number(std::string_view text, const char* what) const {
    long double value = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (rest != text.data() + text.size() || error != std::errc() || std::abs(value) > 1) {
      fail(std::string(what) + " is out of range: '" + shorten(text) + "'");
    }
    return static_cast<double>(value);
  }

  bool continues_line() const {
    return (end_ - next_ >= 2 && next_[1] == '\n') ||
           (end_ - next_ >= 3 && next_[1] == '\r' && next_[2] == '\n');
  }

  void start_line() {
    ++line_;
    line_start_ = next_;
    word_ = next_;
  }

  std::string file_;
  const char* next_;
  const char* end_;
  const char* line_start_;
  const char* word_;  ///< start of the last word read
  int line_;
  bool has_comments_;
};

}  // namespace kinome
