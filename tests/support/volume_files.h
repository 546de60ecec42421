#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>

/// Files of voxels for tests.
namespace kinome::test {

/// Contents of a .vol file, with a value for each index.
struct VolFile {
  int32_t x = 4, y = 3, z = 2, channels = 3;
  float box[6] = {-1, -2, -3, 1, 2, 4};
  int32_t type = 1;
  char version = 3;

  std::string bytes(const std::function<float(int)>& value) const {
    std::string text = "VOL";
    text += version;
    for (const int32_t number : {type, x, y, z, channels}) append(text, number);
    for (const float number : box) append(text, number);
    for (int i = 0; i < x * y * z * channels; ++i) append(text, value(i));
    return text;
  }
  /// The header alone.
  std::string header() const {
    VolFile empty = *this;
    empty.x = 0;
    std::string text = empty.bytes({});
    std::memcpy(text.data() + 8, &x, sizeof x);
    return text;
  }

 private:
  template <class T>
  static void append(std::string& text, const T& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
};

/// Values between 0 and 1 without an order.
inline float mixed_value(int i) {
  return static_cast<float>((i * 37 + 11) % 101) / 101.f;
}

}  // namespace kinome::test
