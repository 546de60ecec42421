#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

namespace kinome {

/// Decompresses a zlib stream in steps. Not thread-safe.
class InflatedBytes {
 public:
  /// `compressed` must outlive this object.
  explicit InflatedBytes(std::string_view compressed) : rest_(compressed) {
    is_open_ = inflateInit(&stream_) == Z_OK;
    if (!is_open_) why_ = "not enough memory to decompress the mesh";
  }
  ~InflatedBytes() {
    if (is_open_) inflateEnd(&stream_);
  }
  InflatedBytes(const InflatedBytes&) = delete;
  InflatedBytes& operator=(const InflatedBytes&) = delete;

  /// Reads the next `size` bytes. Returns false if there aren't as many; why() is then the reason.
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
                 : "the compressed data is damaged";
      return false;
    }
    return is_open_;
  }
  const std::string& why() const { return why_; }
  /// Upper bound of the number of bytes that can follow.
  uint64_t max_bytes_left() const {
    constexpr uint64_t kMaxRatio = 1032;  // compression ratio of deflate
    return (rest_.size() + stream_.avail_in) * kMaxRatio + kMaxBuffered;
  }

 private:
  static constexpr uint64_t kMaxBuffered = 1 << 16;  // zlib's window: inflated, but not yet read

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
