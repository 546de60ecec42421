#pragma once

#include <string_view>

namespace kinome {

/// Returns true if objects and arrays of a JSON text are nested more than 500 deep, for which
/// recursive parsers may overflow the stack.
inline bool is_nested_too_deeply(std::string_view json) {
  constexpr int kMaxDepth = 500;
  int depth = 0;
  bool is_text = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (is_text) {
      if (c == '\\') ++i;
      is_text = c != '"';
    } else if (c == '"') {
      is_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxDepth) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

}  // namespace kinome
