#include "kinome/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace kinome {
namespace {

/// Replaces control characters by spaces: parser messages and quoted names may have line breaks.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return text;
}

/// Cuts the middle out of a long text, because messages may quote megabytes from a file.
std::string shortened(const std::string& text) {
  constexpr size_t kFirst = 700, kLast = 200;
  if (text.size() <= kFirst + kLast) return text;
  // Don't cut within a UTF-8 character.
  const auto is_inside = [&](size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80;
  };
  size_t first = kFirst, last = text.size() - kLast;
  while (first > kFirst - 4 && is_inside(first)) --first;
  while (last < text.size() - kLast + 4 && is_inside(last)) ++last;
  return text.substr(0, first) + " … " + text.substr(last);
}

std::string format_message(const Location& where, const std::string& message,
                           const std::vector<Location>& requesters) {
  std::string text = to_string(where);
  if (!text.empty()) text += ": ";
  text += shortened(message);
  for (size_t i = 0; i < requesters.size(); ++i) {
    text += (i == 0 ? " (referenced by " : ", referenced by ") + to_string(requesters[i]);
  }
  return one_line(requesters.empty() ? text : text + ")");
}

}  // namespace

std::string to_string(const Location& where) {
  if (where.file.empty() || where.line <= 0) return where.file;
  return where.file + ":" + std::to_string(where.line) + ":" + std::to_string(where.column);
}

std::string format_number(float number) {
  return fmt::format("{}", number);
}

Error::Error(const Location& where, const std::string& message, std::vector<Location> requesters)
    : std::runtime_error(format_message(where, message, requesters)),
      where_(where),
      message_(one_line(shortened(message))),
      requesters_(std::move(requesters)) {}

Error Error::requested_by(const Location& requester) const {
  std::vector<Location> requesters = requesters_;
  requesters.push_back(requester);
  return Error(where_, message_, std::move(requesters));
}

int edit_distance(const char* a, const char* b) {
  // Levenshtein distance, one row of the table at a time.
  const size_t columns = std::strlen(b);
  std::vector<int> row(columns + 1);
  for (size_t j = 0; j <= columns; ++j) row[j] = static_cast<int>(j);
  for (int i = 1; *a != '\0'; ++a, ++i) {
    int diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= columns; ++j) {
      const int replaced = diagonal + (*a != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[columns];
}

}  // namespace kinome
