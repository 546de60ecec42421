#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>
#include <memory>

#include "allocation_watch.h"
#include "kinome/log.h"
#include "support/shape_helpers.h"

/// Mesh files for tests of their readers.
namespace kinome::test::mesh_files {

/// Appends values in either byte order.
class Bytes {
 public:
  explicit Bytes(bool swap) : swap_(swap) {}
  template <class T>
  Bytes& add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    text_.append(bytes, sizeof(T));
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  bool swap_;
  std::string text_;
};

class MeshFiles : public testing::Test {
 protected:
  std::shared_ptr<Shape> load(const std::string& name, const std::string& contents,
                              const std::string& attributes = "") {
    const std::string file = folder_.write(name, contents);
    return make<Shape>("<shape type='" + name.substr(name.rfind('.') + 1) +
                       "'><string name='filename' value='" + file + "'/>" + attributes +
                       "</shape>");
  }
  std::string error(const std::string& name, const std::string& contents) {
    return error_of([&] { load(name, contents); });
  }
  void expect_error(const std::string& name, const std::string& contents, const std::string& place,
                    const std::string& message) {
    reset_largest_allocation();
    const std::string text = error(name, contents);
    const std::string prefix = folder_.path(name) + place + ":";
    EXPECT_EQ(text.substr(0, prefix.size()), prefix) << text << "\nof:\n"
                                                     << contents.substr(0, 500);
    EXPECT_NE(text.find(message), std::string::npos) << text << "\nof:\n"
                                                     << contents.substr(0, 500);
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_LT(largest_allocation(), size_t{4} << 20) << text;
  }
  TemporaryFolder folder_;
};

/// Returns a square of two triangles at z = 2 with normals and uv. The file also has an unknown
/// property and unknown elements, as list and as scalar.
inline std::string binary_ply(bool swap) {
  std::string header = "ply\nformat binary_";
  header += (std::endian::native == std::endian::little) != swap ? "little" : "big";
  header +=
      "_endian 1.0\ncomment made by a test\nobj_info x y z\nelement camera 2\n"
      "property list ushort double lens\nproperty char mode\nelement vertex 4\n"
      "property double x\nproperty float y\nproperty uchar quality\nproperty short z\n"
      "property float nx\nproperty float ny\nproperty float nz\nproperty list uchar int extra\n"
      "property float s\nproperty float t\nelement face 1\nproperty ushort material\n"
      "property list uint ushort vertex_index\nelement edge 1\nproperty int a\nend_header\n";
  Bytes body(swap);
  for (int i = 0; i < 2; ++i) {
    body.add<uint16_t>(2).add(1.5).add(2.5).add<int8_t>(-7);
  }
  for (int i = 0; i < 4; ++i) {
    const float x = i == 1 || i == 2 ? 1.f : -1.f;
    const float y = i >= 2 ? 1.f : -1.f;
    body.add<double>(x).add(y).add<uint8_t>(200).add<int16_t>(2);
    body.add(0.f).add(0.f).add(-3.f);
    body.add<uint8_t>(1).add<int32_t>(99);
    body.add((x + 1) / 2).add((y + 1) / 4);
  }
  body.add<uint16_t>(5).add<uint32_t>(4);
  for (const uint16_t i : {0, 1, 2, 3}) body.add(i);
  body.add<int32_t>(1);
  return header + body.text();
}

}  // namespace kinome::test::mesh_files
