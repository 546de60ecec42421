// Tests of EXR files that claim more memory than their data can fill, and of similar valid files.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <half.h>
#include <cstring>

#include "support/image_helpers.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test::image_exr_check_test {
namespace {

std::string as_bytes(int32_t v) {
  return std::string(reinterpret_cast<const char*>(&v), sizeof v);
}
std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + as_bytes(static_cast<int32_t>(value.size())) + value;
}
std::string tiles(int width, int height) {
  return attribute("tiles", "tiledesc", as_bytes(width) + as_bytes(height) + '\0');
}

/// Bytes of a small file, to be modified.
class Bytes {
 public:
  Bytes() {
    const std::string path = folder_.path("a.exr");
    write_exr(path, make_image(8, 8, {"Y"}), ExrSampleType::kFloat, {});
    text = read_file(path);
  }
  void set(const std::string& name, const std::string& type, const std::string& value) {
    text.replace(text.find(name + '\0' + type + '\0') + name.size() + type.size() + 6, value.size(),
                 value);
  }
  void set_size(int width, int height) {
    set("dataWindow", "box2i",
        as_bytes(0) + as_bytes(0) + as_bytes(width - 1) + as_bytes(height - 1));
  }
  void set_compression(Imf::Compression compression) {
    set("compression", "compression", std::string(1, static_cast<char>(compression)));
  }
  void add(const std::string& attribute) { text.insert(8, attribute); }
  void expect_error_with(const std::string& part) const {
    const std::string path = folder_.write("b.exr", text);
    expect_error([&] { read_exr(path); }, "b.exr", part);
  }
  std::string text;

 private:
  TemporaryFolder folder_;
};

TEST(ExrCheck, SizesThatTheFileCannotHold) {
  Bytes bytes;
  bytes.set_size(100000, 100000);
  bytes.expect_error_with("truncated");
  bytes.set_size(2000000000, 2000000000);
  bytes.expect_error_with("invalid or too large");
}

TEST(ExrCheck, BlocksLargerThanTheImage) {
  // One row of many pixels is small. 256 of them, which DWAB compresses together, are too large.
  Bytes rows;
  rows.set_size(131072, 1);
  rows.set_compression(Imf::DWAB_COMPRESSION);
  std::string channels;
  for (const char name : {'A', 'B', 'C', 'D'}) {
    channels += std::string(1, name) + '\0' + as_bytes(2) + as_bytes(0) + as_bytes(1) + as_bytes(1);
  }
  const size_t begin = rows.text.find("channels");
  const size_t old = attribute("channels", "chlist", std::string(19, ' ')).size();
  rows.text.replace(begin, old, attribute("channels", "chlist", channels + '\0'));
  rows.expect_error_with("claims blocks of 131072 x 256 pixels, which would need 512 MB");
  // The attribute belongs to tiled files and is ignored.
  rows.add(tiles(1, 1));
  rows.expect_error_with("claims blocks of 131072 x 256 pixels");
}

TEST(ExrCheck, TilesOfMoreBytesThanTheImage) {
  for (const auto& [side, message] : {std::pair(100000, "claims blocks of 100000 x 100000"),
                                      {2000000000, "tile size in its header is too large"}}) {
    Bytes large;
    large.text[5] = 2;  // the flag for tiles
    large.add(tiles(side, side));
    large.expect_error_with(message);
  }
  // A whole row of tiles is in memory, even if each tile is narrow.
  Bytes tall;
  tall.text[5] = 2;
  tall.add(tiles(128, 32767));
  tall.set_size(131072, 1);
  tall.expect_error_with("claims blocks of 131072 x 32767");
  Bytes none;
  none.text[5] = 2;
  none.expect_error_with("the tile size is missing");
}

TEST(ExrCheck, SecondPartsAndOtherKinds) {
  Bytes parts;
  parts.text[5] = 0x10;
  const std::string first = parts.text.substr(8);
  const size_t end = parts.text.find(std::string("screenWindowWidth"));
  ASSERT_NE(end, std::string::npos);
  parts.text.resize(8);
  parts.text += attribute("name", "string", "a") + attribute("type", "string", "scanlineimage") +
                attribute("chunkCount", "int", as_bytes(1)) +
                first.substr(0, first.find("screenWindowWidth"));
  parts.text += attribute("screenWindowWidth", "float", as_bytes(0x3f800000)) + '\0';
  parts.text += std::string("comment\0string\0", 15) + as_bytes(2000000000) + "abc";
  parts.expect_error_with("an attribute of its header extends beyond the file");
  Bytes deep;
  deep.text[5] = 8;
  deep.expect_error_with("deep data");
  Bytes manifest;
  manifest.add(attribute("idManifest", "idmanifest", "abcdefgh"));
  manifest.expect_error_with("ID manifest");
}

/// DWA compresses a single colour to 20,000 and more pixels per byte.
TEST(ExrCheck, OneColourInFewBytesIsRead) {
  const TemporaryFolder folder;
  const std::string path = folder.path("sky.exr");
  constexpr int kWidth = 4096, kHeight = 1024;
  const std::vector<half> values(static_cast<size_t>(kWidth) * kHeight, half(0.5f));
  for (const Imf::Compression compression : {Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION}) {
    Imf::Header header(kWidth, kHeight);
    header.compression() = compression;
    Imf::FrameBuffer buffer;
    for (const char* const name : {"R", "G", "B"}) {
      header.channels().insert(name, Imf::Channel(Imf::HALF));
      buffer.insert(name,
                    Imf::Slice(Imf::HALF, reinterpret_cast<char*>(const_cast<half*>(values.data())),
                               sizeof(half), sizeof(half) * kWidth));
    }
    {
      Imf::OutputFile file(path.c_str(), header);
      file.setFrameBuffer(buffer);
      file.writePixels(kHeight);
    }
    EXPECT_LT(read_file(path).size(), 10000u);
    const Image image = read_exr(path);
    EXPECT_EQ(image.width, kWidth);
    EXPECT_NEAR(image.at(4000, 1000, 2), 0.5f, 0.01f);
  }
}

TEST(ExrCheck, TilesLargerThanTheImageAreRead) {
  const TemporaryFolder folder;
  const std::string path = folder.path("tiles.exr");
  const std::vector<float> values(64 * 48, 0.25f);
  Imf::Header header(64, 48);
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  header.setTileDescription(Imf::TileDescription(4096, 4096, Imf::ONE_LEVEL));
  Imf::FrameBuffer buffer;
  buffer.insert("Y",
                Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values.data())),
                           sizeof(float), sizeof(float) * 64));
  {
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writeTile(0, 0);
  }
  EXPECT_EQ(read_exr(path).at(63, 47, 0), 0.25f);
}

}  // namespace
}  // namespace kinome::test::image_exr_check_test
