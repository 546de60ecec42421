#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "kinome/error.h"
#include "mesh_file.h"
#include "ply_header.h"

/// Sequential readers of the values of a PLY file's elements.
namespace kinome {

/// Reads values of an ascii file. An item may span several lines, and a line may have several
/// items.
class AsciiSource {
 public:
  AsciiSource(const std::string& file, const PlyHeader& header, std::string_view body)
      : cursor_(file, body, header.lines + 1) {}
  size_t bytes_left() const { return cursor_.bytes_left(); }
  /// Minimum number of bytes of a value: one digit.
  static size_t min_size(PlyType) { return 1; }
  /// Ends an item. Stores the first value that follows on the same line: if the rest of the file
  /// contradicts the header, that value is the likely cause.
  void end_item() {
    if (cursor_.at_line_end()) {
      cursor_.next_line();
      return;
    }
    if (surplus_) return;
    TextCursor ahead = cursor_;
    const std::string word = TextCursor::shorten(ahead.word());
    surplus_ = ahead.error_here("unexpected '" + word + "' at the end of the line");
  }
  double next(PlyType) {
    std::string_view word = cursor_.word();
    if (word.empty()) {
      if (!cursor_.skip_blank_lines()) cursor_.fail("the file ends too early");
      word = cursor_.word();
    }
    return cursor_.number(word, "a number");
  }
  /// Must be called after the last element.
  void finish() {
    if (surplus_ && cursor_.skip_blank_lines()) throw Error(*surplus_);
  }
  [[noreturn]] void fail(const std::string& message) const { cursor_.fail(message); }
  /// After an error, throws the likely cause instead, if there is one.
  void throw_cause() const {
    if (surplus_) throw Error(*surplus_);
  }

 private:
  TextCursor cursor_;
  std::optional<Error> surplus_;
};

/// Converts a half-precision number (IEEE 754, binary16).
inline double from_half(uint16_t bits) {
  const int exponent = bits >> 10 & 31, fraction = bits & 1023;
  double value =
      exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
  if (exponent == 31) value = fraction == 0 ? HUGE_VAL : NAN;
  return bits & 0x8000 ? -value : value;
}

/// Reads values of a binary file. `swap` is true if its byte order differs from this machine's.
template <bool swap>
class BinarySource {
 public:
  BinarySource(const std::string& file, const PlyHeader& header, std::string_view body)
      : file_(file), offset_(header.bytes), body_(body) {}
  size_t bytes_left() const { return body_.size() - next_; }
  static size_t min_size(PlyType type) { return size_of(type); }
  static void end_item() {}
  static void finish() {}
  static void throw_cause() {}
  double next(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return read<int8_t>();
      case PlyType::kUint8:
        return read<uint8_t>();
      case PlyType::kInt16:
        return read<int16_t>();
      case PlyType::kUint16:
        return read<uint16_t>();
      case PlyType::kInt32:
        return read<int32_t>();
      case PlyType::kUint32:
        return read<uint32_t>();
      case PlyType::kInt64:
        return static_cast<double>(read<int64_t>());
      case PlyType::kUint64:
        return static_cast<double>(read<uint64_t>());
      case PlyType::kFloat16:
        return from_half(read<uint16_t>());
      case PlyType::kFloat32:
        return static_cast<double>(read<float>());
      case PlyType::kFloat64:
        return read<double>();
    }
    return 0;
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(Location{file_, 0, 0},
                message + " (near byte " + std::to_string(offset_ + next_) + ")");
  }

 private:
  template <class T>
  T read() {
    if (bytes_left() < sizeof(T)) fail("the file ends too early");
    char bytes[sizeof(T)];
    std::memcpy(bytes, body_.data() + next_, sizeof(T));
    if constexpr (swap) std::reverse(bytes, bytes + sizeof(T));
    next_ += sizeof(T);
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  std::string file_;
  size_t offset_;
  std::string_view body_;
  size_t next_ = 0;
};

}  // namespace kinome
