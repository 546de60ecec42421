#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include <glm/gtc/packing.hpp>

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
    using Self = BinarySource;
    // By PlyType.
    constexpr double (Self::*kReaders[])() = {
        &Self::read<int8_t>,  &Self::read<uint8_t>,  &Self::read<int16_t>, &Self::read<uint16_t>,
        &Self::read<int32_t>, &Self::read<uint32_t>, &Self::read<int64_t>, &Self::read<uint64_t>,
        &Self::read_half,     &Self::read<float>,    &Self::read<double>};
    return (this->*kReaders[static_cast<int>(type)])();
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(Location{file_, 0, 0},
                message + " (near byte " + std::to_string(offset_ + next_) + ")");
  }

 private:
  template <class T>
  double read() {
    return static_cast<double>(take<T>());
  }
  double read_half() { return double{glm::unpackHalf1x16(take<uint16_t>())}; }
  template <class T>
  T take() {
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
