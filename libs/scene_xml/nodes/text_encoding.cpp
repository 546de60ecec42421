#include "scene_xml/nodes/text_encoding.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string_view>

namespace kinome::loader {
namespace {

constexpr uint32_t kReplacement = 0xfffd;  ///< replaces invalid characters

struct Encoding {
  size_t unit = 1;  ///< bytes per code unit
  bool is_big_endian = false;
  size_t mark = 0;  ///< size of the byte order mark in bytes
};

void append_utf8(uint32_t code, std::string& out) {
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  if (code > 0x10ffff || is_surrogate) code = kReplacement;
  const auto byte = [&](uint32_t bits) { out += static_cast<char>(bits); };
  if (code < 0x80) return byte(code);
  if (code < 0x800) {
    byte(0xc0 | code >> 6);
  } else {
    if (code < 0x10000) {
      byte(0xe0 | code >> 12);
    } else {
      byte(0xf0 | code >> 18);
      byte(0x80 | (code >> 12 & 0x3f));
    }
    byte(0x80 | (code >> 6 & 0x3f));
  }
  byte(0x80 | (code & 0x3f));
}

Encoding encoding_of(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xFF\xFE\0\0"sv)) return {4, false, 4};
  if (bytes.starts_with("\0\0\xFE\xFF"sv)) return {4, true, 4};
  if (bytes.starts_with("\xFF\xFE"sv)) return {2, false, 2};
  if (bytes.starts_with("\xFE\xFF"sv)) return {2, true, 2};
  if (bytes.starts_with("<\0\0\0"sv)) return {4, false, 0};
  if (bytes.starts_with("\0\0\0<"sv)) return {4, true, 0};
  if (bytes.starts_with("<\0"sv)) return {2, false, 0};
  if (bytes.starts_with("\0<"sv)) return {2, true, 0};
  return {};
}

bool declares_latin1(std::string_view bytes) {
  if (!bytes.starts_with("<?xml")) return false;
  std::string declaration(bytes.substr(0, bytes.find("?>")));
  std::transform(declaration.begin(), declaration.end(), declaration.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const size_t at = declaration.find("encoding");
  if (at == std::string::npos) return false;
  const std::string_view rest = std::string_view(declaration).substr(at);
  return rest.find("iso-8859-1") != rest.npos || rest.find("latin1") != rest.npos;
}

}  // namespace

std::string as_utf8(std::string bytes) {
  const auto byte_at = [&](size_t i) { return uint32_t{static_cast<unsigned char>(bytes[i])}; };
  const Encoding encoding = encoding_of(bytes);
  std::string text;
  if (encoding.unit == 1) {
    if (!declares_latin1(bytes)) return bytes;
    for (size_t i = 0; i < bytes.size(); ++i) append_utf8(byte_at(i), text);
    return text;
  }
  const size_t unit = encoding.unit;
  const auto unit_at = [&](size_t i) {
    uint32_t value = 0;
    for (size_t k = 0; k < unit; ++k) {
      value = value << 8 | byte_at(encoding.is_big_endian ? i + k : i + unit - 1 - k);
    }
    return value;
  };
  for (size_t i = encoding.mark; i + unit <= bytes.size(); i += unit) {
    uint32_t code = unit_at(i);
    const bool may_be_pair = unit == 2 && code >= 0xd800 && code < 0xdc00;
    if (may_be_pair && i + 4 <= bytes.size()) {
      const uint32_t low = unit_at(i + 2);
      if (low >= 0xdc00 && low < 0xe000) {
        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
        i += 2;
      }
    }
    append_utf8(code, text);
  }
  if ((bytes.size() - encoding.mark) % unit != 0) append_utf8(kReplacement, text);
  return text;
}

}  // namespace kinome::loader
