#include "scene_xml/nodes/unclosed.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace kinome::loader {
namespace {

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

size_t next_tag(const std::string& text, size_t at) {
  constexpr std::pair<std::string_view, std::string_view> kOthers[] = {
      {"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}, {"<!", ">"}};
  while ((at = text.find('<', at)) != std::string::npos) {
    const auto* const other = std::ranges::find_if(kOthers, [&](const auto& one) {
      return text.compare(at, one.first.size(), one.first) == 0;
    });
    if (other == std::end(kOthers)) return at;
    const size_t end = text.find(other->second, at + other->first.size());
    if (end == std::string::npos) break;
    at = end + other->second.size();
  }
  return std::string::npos;
}

std::optional<UnclosedElement> innermost_open_element(const std::string& text, size_t end) {
  std::vector<UnclosedElement> open;
  for (size_t at = next_tag(text, 0); at < end && at != std::string::npos;
       at = next_tag(text, at)) {
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
