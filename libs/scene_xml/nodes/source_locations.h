#pragma once

#include <string>

#include "kinome/error.h"

namespace kinome::loader {

/// Converts offsets to lines and columns. Offsets must increase, so that one pass is enough.
class SourceLocations {
 public:
  SourceLocations(const std::string& text, const std::string& file) : text_(text), file_(file) {
    if (text.starts_with("\xEF\xBB\xBF")) offset_ = 3;  // skips the byte order mark
  }

  Location at(size_t offset) {
    for (; offset_ < offset && offset_ < text_.size(); ++offset_) {
      const auto c = static_cast<unsigned char>(text_[offset_]);
      if (c == '\n') {
        ++line_;
        column_ = 1;
      } else if ((c & 0xc0) != 0x80) {  // the later bytes of a UTF-8 character don't count
        ++column_;
      }
    }
    return {file_, line_, column_};
  }

 private:
  const std::string& text_;
  const std::string& file_;
  size_t offset_ = 0;
  int line_ = 1;
  int column_ = 1;
};

}  // namespace kinome::loader
