#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/error.h"
#include "mesh_file.h"

/// Header of a PLY file: its elements and their properties.
namespace kinome {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
enum class PlyType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat16,
  kFloat32,
  kFloat64
};

inline size_t size_of(PlyType type) {
  constexpr size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  return kSizes[static_cast<int>(type)];
}

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Index of a property, or -1.
  int find_scalar(std::string_view property) const { return find(property, false); }
  int find_list(std::string_view property) const { return find(property, true); }

 private:
  int find(std::string_view property, bool is_list) const {
    for (size_t i = 0; i < properties.size(); ++i) {
      if (properties[i].is_list == is_list && properties[i].name == property) {
        return static_cast<int>(i);
      }
    }
    return -1;
  }
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  int lines = 0;     ///< number of lines
  size_t bytes = 0;  ///< offset of the body

  const PlyElement* find(std::string_view name) const {
    const auto found = std::find_if(elements.begin(), elements.end(),
                                    [&](const PlyElement& e) { return e.name == name; });
    return found == elements.end() ? nullptr : &*found;
  }
};

class PlyHeaderReader {
 public:
  PlyHeaderReader(const std::string& file, std::string_view bytes)
      : size_(bytes.size()), cursor_(file, bytes) {}

  PlyHeader read() {
    if (cursor_.word() != "ply" || !cursor_.at_line_end()) {
      cursor_.fail("not a PLY file: expected 'ply' as its first line");
    }
    bool has_format = false;
    while (true) {
      cursor_.next_line();
      if (!cursor_.skip_blank_lines()) cursor_.fail("the header has no 'end_header'");
      const std::string_view keyword = cursor_.word();
      if (keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "end_header") break;
      if (keyword == "format") {
        read_format();
        has_format = true;
      } else if (keyword == "element") {
        read_element();
      } else if (keyword == "property") {
        read_property();
      } else {
        cursor_.fail("unknown keyword '" + TextCursor::shorten(keyword) +
                     "' in the header, expected format, element, property or end_header");
      }
      if (!cursor_.at_line_end()) {
        cursor_.fail("unexpected '" + TextCursor::shorten(cursor_.word()) + "'");
      }
    }
    if (!has_format) cursor_.fail("the header has no 'format'");
    header_.lines = cursor_.line();
    cursor_.next_line();
    header_.bytes = size_ - cursor_.bytes_left();
    return std::move(header_);
  }

 private:
  void read_format() {
    const std::string_view format = cursor_.word();
    if (format == "ascii") {
      header_.format = PlyFormat::kAscii;
    } else if (format == "binary_little_endian") {
      header_.format = PlyFormat::kLittleEndian;
    } else if (format == "binary_big_endian") {
      header_.format = PlyFormat::kBigEndian;
    } else {
      cursor_.fail("unknown format '" + TextCursor::shorten(format) +
                   "', expected ascii, binary_little_endian or binary_big_endian");
    }
    if (cursor_.word() != "1.0") cursor_.fail("unknown format version, expected 1.0");
  }

  void read_element() {
    PlyElement element;
    element.name = cursor_.word();
    const std::string_view text = cursor_.word();
    const auto [rest, error] =
        std::from_chars(text.data(), text.data() + text.size(), element.count);
    if (element.name.empty() || text.empty() || error != std::errc() ||
        rest != text.data() + text.size()) {
      cursor_.fail("expected 'element NAME COUNT', got count '" + TextCursor::shorten(text) + "'");
    }
    if (header_.find(element.name)) {
      cursor_.fail("there are two elements '" + TextCursor::shorten(element.name) + "'");
    }
    header_.elements.push_back(std::move(element));
  }

  void read_property() {
    if (header_.elements.empty()) cursor_.fail("a property comes before any element");
    PlyProperty property;
    std::string_view type = cursor_.word();
    if (type == "list") {
      property.is_list = true;
      property.count_type = read_type(cursor_.word());
      type = cursor_.word();
    }
    property.type = read_type(type);
    property.name = cursor_.word();
    if (property.name.empty()) cursor_.fail("a property has no name");
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType read_type(std::string_view name) const {
    constexpr std::string_view kNames[] = {
        "char", "int8",    "uchar", "uint8",   "short",  "int16",  "ushort", "uint16",
        "int",  "int32",   "uint",  "uint32",  "int64",  "int64",  "uint64", "uint64",
        "half", "float16", "float", "float32", "double", "float64"};
    const auto* const found = std::find(std::begin(kNames), std::end(kNames), name);
    if (found == std::end(kNames)) {
      cursor_.fail("unknown type '" + TextCursor::shorten(name) +
                   "', expected char, uchar, short, ushort, int, uint, int64, uint64, half, "
                   "float or double");
    }
    return static_cast<PlyType>((found - std::begin(kNames)) / 2);
  }

  size_t size_;
  TextCursor cursor_;
  PlyHeader header_;
};

inline PlyHeader read_ply_header(const std::string& file, std::string_view bytes) {
  return PlyHeaderReader(file, bytes).read();
}

}  // namespace kinome
