#include "scene_xml/unclosed.h"

#include <string_view>
#include <vector>

namespace kinome::loader {
namespace {

/// Returns the offset after the markup that begins at `at` with `begin` and ends with `end`; `at`
/// if there is no such markup.
size_t skip(const std::string& text, size_t at, std::string_view begin, std::string_view end) {
  if (text.compare(at, begin.size(), begin) != 0) return at;
  const size_t found = text.find(end, at + begin.size());
  return found == std::string::npos ? text.size() : found + end.size();
}

/// Returns the offset of the '>' that closes the tag at `at`, past quoted values.
size_t end_of_tag(const std::string& text, size_t at) {
  for (; at < text.size() && text[at] != '>'; ++at) {
    if (text[at] != '"' && text[at] != '\'') continue;
    at = text.find(text[at], at + 1);
    if (at == std::string::npos) return text.size();
  }
  return at;
}

}  // namespace

std::optional<UnclosedElement> innermost_open_element(const std::string& text, size_t end) {
  std::vector<UnclosedElement> open;
  for (size_t at = text.find('<'); at < end && at != std::string::npos; at = text.find('<', at)) {
    size_t behind = skip(text, at, "<!--", "-->");
    if (behind == at) behind = skip(text, at, "<![CDATA[", "]]>");
    if (behind == at) behind = skip(text, at, "<?", "?>");
    if (behind == at) behind = skip(text, at, "<!", ">");
    if (behind != at) {
      at = behind;
      continue;
    }
    if (text.compare(at, 2, "</") == 0) {
      const size_t name_end = text.find_first_of(" \t\r\n>", at);
      // The end tag at which the parser stopped doesn't close anything.
      if (name_end == std::string::npos || name_end > end) break;
      const std::string tag = text.substr(at + 2, name_end - at - 2);
      if (open.empty() || open.back().tag != tag) break;
      open.pop_back();
      at = name_end;
      continue;
    }
    const size_t close = end_of_tag(text, at + 1);
    if (close >= text.size()) break;
    const size_t name_end = text.find_first_of(" \t\r\n/>", at + 1);
    if (text[close - 1] != '/') open.push_back({text.substr(at + 1, name_end - at - 1), at});
    at = close;
  }
  if (open.empty()) return std::nullopt;
  return open.back();
}

}  // namespace kinome::loader
