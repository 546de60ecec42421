#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

namespace kinome {

/// What a zlib stream holds, from its beginning on. Not thread-safe.
class InflatedBytes {
 public:
  /// `compressed` must outlive this.
  explicit InflatedBytes(std::string_view compressed) : rest_(compressed) {
    is_open_ = inflateInit(&stream_) == Z_OK;
    if (!is_open_) why_ = "there is no memory to decompress it";
  }
  ~InflatedBytes() {
    if (is_open_) inflateEnd(&stream_);
  }
  InflatedBytes(const InflatedBytes&) = delete;
  InflatedBytes& operator=(const InflatedBytes&) = delete;

  /// The next `size` bytes; false where there aren't as many, which why() explains.
  bool read(void* out, size_t size) {
    constexpr size_t kStep = size_t{1} << 30;  // zlib counts by 32 bits
    auto* next = static_cast<Bytef*>(out);
    while (is_open_ && size > 0) {
      const size_t step = std::min(size, kStep);
      stream_.next_out = next;
      stream_.avail_out = static_cast<uInt>(step);
      if (stream_.avail_in == 0) feed();
      const int result = inflate(&stream_, Z_NO_FLUSH);
      const size_t made = step - stream_.avail_out;
      next += made;
      size -= made;
      if (result == Z_OK && (made > 0 || stream_.avail_in > 0 || !rest_.empty())) continue;
      if (size == 0) break;
      why_ = result == Z_STREAM_END || result == Z_BUF_ERROR || result == Z_OK
                 ? "the mesh ends too early"
                 : "what is compressed in it is broken";
      return false;
    }
    return is_open_;
  }
  const std::string& why() const { return why_; }
  /// No more bytes than these can follow.
  uint64_t most_left() const {
    constexpr uint64_t kMostRatio = 1032;  // of deflate
    return (rest_.size() + stream_.avail_in) * kMostRatio + kMostWaiting;
  }

 private:
  static constexpr uint64_t kMostWaiting = 1 << 16;  // zlib's window: inflated, but not yet read

  void feed() {
    const size_t step = std::min<size_t>(rest_.size(), size_t{1} << 30);
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));
    stream_.avail_in = static_cast<uInt>(step);
    rest_.remove_prefix(step);
  }

  z_stream stream_{};
  std::string_view rest_;
  bool is_open_ = false;
  std::string why_;
};

}  // namespace kinome
