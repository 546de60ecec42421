#pragma once

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string>

namespace kinome::app {

/// Quotes a word for a shell's command line.
inline std::string quoted(const std::string& word) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) || std::strchr("_/.-+,:@%=", c);
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace kinome::app
