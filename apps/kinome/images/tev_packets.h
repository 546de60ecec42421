#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "kinome/math.h"

/// Messages of the network protocol of the viewer tev:
/// https://github.com/Tom94/tev#over-the-network. Each begins with its length in bytes (including
/// these four) and its kind (one byte). Numbers are little-endian, strings zero-terminated.
namespace kinome::app {

using Packet = std::vector<char>;

// Numbers are copied without conversion.
static_assert(std::endian::native == std::endian::little);

inline constexpr char kCreateImage = 4, kUpdateImageV3 = 6;

/// Writes the values of a message.
class PacketWriter {
 public:
  explicit PacketWriter(char kind) { packet_[4] = kind; }
  template <class Number>
  void put(Number number) {
    put_bytes(&number, sizeof number);
  }
  void put(const std::string& text) { put_bytes(text.c_str(), text.size() + 1); }
  void put(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) put(text);
  }
  void put_bytes(const void* bytes, size_t count) {
    const auto* const first = static_cast<const char*>(bytes);
    packet_.insert(packet_.end(), first, first + count);
  }
  Packet finish() {
    const auto length = static_cast<uint32_t>(packet_.size());
    std::memcpy(packet_.data(), &length, sizeof length);
    return std::move(packet_);
  }

 private:
  Packet packet_ = Packet(5);  // begins with the length, which finish() fills in, and the kind
};

/// Returns a "CreateImage" message: creates and shows a black image, which replaces one of the same
/// name.
inline Packet create_image(const std::string& name, int width, int height,
                           const std::vector<std::string>& channels) {
  PacketWriter writer(kCreateImage);
  writer.put(char{1});  // the viewer selects the image
  writer.put(name);
  writer.put(int32_t{width});
  writer.put(int32_t{height});
  writer.put(static_cast<int32_t>(channels.size()));
  writer.put(channels);
  return writer.finish();
}

/// Returns an "UpdateImage" message, version 3. `data` is row by row with interleaved channels.
inline Packet update_image(const std::string& name, const Rect& pixels,
                           const std::vector<std::string>& channels, const std::vector<float>& data) {
  PacketWriter writer(kUpdateImageV3);
  writer.put(char{0});
  writer.put(name);
  writer.put(static_cast<int32_t>(channels.size()));
  writer.put(channels);
  for (const int number : {pixels.x0, pixels.y0, pixels.width(), pixels.height()}) {
    writer.put(int32_t{number});
  }
  // Offset of each channel's first value in `data`, then the stride of each channel.
  for (size_t c = 0; c < channels.size(); ++c) writer.put(static_cast<int64_t>(c));
  for (size_t c = 0; c < channels.size(); ++c) writer.put(static_cast<int64_t>(channels.size()));
  writer.put_bytes(data.data(), data.size() * sizeof(float));
  return writer.finish();
}

}  // namespace kinome::app
