// Tests of image files that `bitmap` reads without OpenImageIO: all kinds of PNG, JPEG and
// Radiance.
#include <cstdio>
// The next headers need size_t and FILE.
#include <jpeglib.h>
#include <zlib.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "kinome/texture.h"
#include "support/render.h"

namespace kinome::test::image_formats_test {
namespace {

std::string big_endian(uint32_t value) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<char>(value >> shift));
  return bytes;
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string checked = type + data;
  const auto* const begin = reinterpret_cast<const Bytef*>(checked.data());
  return big_endian(static_cast<uint32_t>(data.size())) + checked +
         big_endian(static_cast<uint32_t>(crc32(0, begin, static_cast<uInt>(checked.size()))));
}

/// Returns a PNG file; `rows` lack the filter byte. Types are PNG's: 0 grey, 2 RGB, 3 palette, 4
/// grey with alpha, 6 RGB with alpha.
std::string png(int width, int height, int depth, int type, const std::vector<std::string>& rows,
                const std::string& before_data = "", bool interlaced = false) {
  std::string raw;
  for (const std::string& row : rows) raw += '\0' + row;
  std::string packed(compressBound(raw.size()), '\0');
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
            reinterpret_cast<const Bytef*>(raw.data()), raw.size(), 9);
  packed.resize(size);
  const std::string kind{static_cast<char>(depth), static_cast<char>(type), 0, 0,
                         static_cast<char>(interlaced)};
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big_endian(static_cast<uint32_t>(width)) +
                           big_endian(static_cast<uint32_t>(height)) + kind) +
         before_data + chunk("IDAT", packed) + chunk("IEND", "");
}

std::string bytes_of(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) bytes.push_back(static_cast<char>(value));
  return bytes;
}

/// Returns a palette of the first of the colours 200 100 50, 10 20 30 and 0 255 0.
std::string palette(int colors) {
  return chunk("PLTE", bytes_of({200, 100, 50, 10, 20, 30, 0, 255, 0}).substr(0, 3 * colors));
}

class ImageFormats : public testing::Test {
 protected:
  std::shared_ptr<Texture> load(const std::string& bytes) const {
    return make<Texture>("<texture type='bitmap'><string name='filename' value='" +
                         folder_.write("image.bin", bytes) +
                         "'/><boolean name='raw' value='true'/>"
                         "<string name='filter_type' value='nearest'/></texture>");
  }
  /// Returns the stored value of pixel (x, y), times 255.
  static Rgb texel(const Texture& texture, int x, int y = 0) {
    const auto size = texture.resolution();
    return 255.f * texture.eval(Vec2((static_cast<float>(x) + 0.5f) / static_cast<float>(size.x),
                                     (static_cast<float>(y) + 0.5f) / static_cast<float>(size.y)));
  }
  static void expect_row(const Texture& texture, const std::vector<Rgb>& row,
                         const std::string& what) {
    for (size_t x = 0; x < row.size(); ++x) {
      const Rgb found = texel(texture, static_cast<int>(x));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], row[x][c], 1e-3f) << what << " " << x;
    }
  }
  std::string error_of(const std::string& bytes) const {
    try {
      load(bytes);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

TEST_F(ImageFormats, EveryKindOfPng) {
  const Rgb a(200, 100, 50), b(10, 20, 30), green(0, 255, 0);
  const std::string transparent = chunk("tRNS", bytes_of({0, 128}));
  const struct {
    const char* what;
    std::string file;
    std::vector<Rgb> row;
  } cases[] = {
      {"1-bit grey",
       png(10, 1, 1, 0, {bytes_of({0b10110011, 0b10000000})}),
       {Rgb(255), Rgb(0), Rgb(255), Rgb(255), Rgb(0), Rgb(0), Rgb(255), Rgb(255), Rgb(255),
        Rgb(0)}},
      {"2-bit grey",
       png(5, 1, 2, 0, {bytes_of({0b00011011, 0b01000000})}),
       {Rgb(0), Rgb(85), Rgb(170), Rgb(255), Rgb(85)}},
      {"4-bit grey", png(3, 1, 4, 0, {bytes_of({0x0f, 0x70})}), {Rgb(0), Rgb(255), Rgb(119)}},
      {"8-bit grey", png(2, 1, 8, 0, {bytes_of({10, 200})}), {Rgb(10), Rgb(200)}},
      {"8-bit grey, one transparent",
       png(2, 1, 8, 0, {bytes_of({10, 200})}, chunk("tRNS", bytes_of({0, 10}))),
       {Rgb(10), Rgb(200)}},
      {"16-bit grey", png(1, 1, 16, 0, {bytes_of({0x80, 0})}), {Rgb(32768 / 257.f)}},
      {"8-bit grey with alpha", png(2, 1, 8, 4, {bytes_of({128, 7, 50, 0})}), {Rgb(128), Rgb(50)}},
      {"16-bit grey with alpha",
       png(1, 1, 16, 4, {bytes_of({128, 0, 0, 0})}),
       {Rgb(32768 / 257.f)}},
      {"8-bit RGB, with gamma",
       png(1, 1, 8, 2, {bytes_of({200, 100, 50})}, chunk("gAMA", big_endian(100000))),
       {a}},
      {"16-bit RGB",
       png(1, 1, 16, 2, {bytes_of({128, 0, 50, 255, 1, 2})}),
       {Rgb(32768, 13055, 258) / 257.f}},
      {"8-bit RGBA", png(1, 1, 8, 6, {bytes_of({200, 100, 50, 0})}), {a}},
      {"16-bit RGBA",
       png(1, 1, 16, 6, {bytes_of({128, 0, 50, 255, 1, 2, 0, 0})}),
       {Rgb(32768, 13055, 258) / 257.f}},
      {"1-bit palette",
       png(9, 1, 1, 3, {bytes_of({0b01010101, 0})}, palette(2)),
       {a, b, a, b, a, b, a, b, a}},
      {"2-bit palette", png(3, 1, 2, 3, {bytes_of({0b00011000})}, palette(3)), {a, b, green}},
      {"4-bit palette", png(3, 1, 4, 3, {bytes_of({0x01, 0x20})}, palette(3)), {a, b, green}},
      {"8-bit palette", png(3, 1, 8, 3, {bytes_of({0, 1, 2})}, palette(3)), {a, b, green}},
      {"8-bit palette, transparent",
       png(3, 1, 8, 3, {bytes_of({0, 1, 2})}, palette(3) + transparent),
       {a, b, green}},
      {"index beyond the palette", png(2, 1, 8, 3, {bytes_of({0, 9})}, palette(3)), {a, Rgb(0)}},
  };
  for (const auto& c : cases) expect_row(*load(c.file), c.row, c.what);
}

/// Adam7 stores the pixels of a 3 x 3 image in seven passes, in this order.
TEST_F(ImageFormats, InterlacedPng) {
  const auto texture = load(png(3, 3, 8, 0,
                                {bytes_of({1}), bytes_of({3}), bytes_of({7, 9}), bytes_of({2}),
                                 bytes_of({8}), bytes_of({4, 5, 6})},
                                "", true));
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      EXPECT_NEAR(texel(*texture, x, y).x, 3.f * static_cast<float>(y) + static_cast<float>(x) + 1,
                  1e-3f)
          << x << " " << y;
    }
  }
}

/// Such files compress about 8000 bits to a byte.
TEST_F(ImageFormats, PngOfASingleColour) {
  const std::vector<std::string> rows(2048, std::string(256, '\0'));
  for (const std::string& file :
       {png(2048, 2048, 1, 0, rows), png(2048, 2048, 1, 3, rows, palette(1)),
        png(512, 2048, 4, 3, rows, palette(1)), png(256, 2048, 8, 3, rows, palette(1))}) {
    const auto texture = load(file);
    EXPECT_EQ(texture->resolution().y, 2048u);
    EXPECT_TRUE(texture->max() == 0 || std::abs(texture->max() - 200 / 255.f) < 1e-6f);
  }
}

/// Returns an image of one colour by libjpeg at the best quality; `channels` is 1, 3 or 4 (CMYK).
std::string jpeg(int width, int height, const std::vector<uint8_t>& color, bool is_progressive) {
  jpeg_error_mgr errors;
  jpeg_compress_struct j;
  j.err = jpeg_std_error(&errors);
  jpeg_create_compress(&j);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&j, &data, &size);
  j.image_width = static_cast<JDIMENSION>(width);
  j.image_height = static_cast<JDIMENSION>(height);
  j.input_components = static_cast<int>(color.size());
  j.in_color_space = color.size() == 1 ? JCS_GRAYSCALE : color.size() == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&j);
  jpeg_set_quality(&j, 100, TRUE);
  if (is_progressive) jpeg_simple_progression(&j);
  jpeg_start_compress(&j, TRUE);
  std::vector<uint8_t> row;
  for (int x = 0; x < width; ++x) row.insert(row.end(), color.begin(), color.end());
  JSAMPROW line = row.data();
  for (int y = 0; y < height; ++y) jpeg_write_scanlines(&j, &line, 1);
  jpeg_finish_compress(&j);
  std::string bytes(reinterpret_cast<const char*>(data), size);
  jpeg_destroy_compress(&j);
  std::free(data);
  return bytes;
}

TEST_F(ImageFormats, Jpeg) {
  for (const bool is_progressive : {false, true}) {
    const auto grey = load(jpeg(20, 9, {100}, is_progressive));
    EXPECT_EQ(grey->resolution(), glm::uvec2(20, 9));
    EXPECT_EQ(texel(*grey, 3), Rgb(100.f));
    const Rgb rgb = texel(*load(jpeg(20, 9, {200, 100, 50}, is_progressive)), 19);
    EXPECT_NEAR(rgb.x, 200, 2);
    EXPECT_NEAR(rgb.y, 100, 2);
    EXPECT_NEAR(rgb.z, 50, 2);
    // Each value is the fraction of light that an ink leaves.
    const Rgb cmyk = texel(*load(jpeg(20, 9, {255, 128, 0, 200}, is_progressive)), 19);
    EXPECT_NEAR(cmyk.x, 200, 2);
    EXPECT_NEAR(cmyk.y, 100, 2);
    EXPECT_NEAR(cmyk.z, 0, 2);
    EXPECT_EQ(load(jpeg(2000, 1500, {7}, is_progressive))->max(), 7 / 255.f);
  }
}

TEST_F(ImageFormats, CutFilesAreTruncated) {
  const std::string whole[] = {
      jpeg(40, 30, {200, 100, 50}, false), jpeg(40, 30, {200, 100, 50}, true),
      png(2, 2, 8, 2, {bytes_of({1, 2, 3, 4, 5, 6}), bytes_of({1, 2, 3, 4, 5, 6})}),
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 3\n" + std::string(12, 'x')};
  for (const std::string& file : whole) {
    ASSERT_EQ(error_of(file), "");
    // A JPEG without its end marker is complete.
    for (size_t length = 12; length + 2 < file.size(); length += 1 + length / 16) {
      const std::string error = error_of(file.substr(0, length));
      EXPECT_NE(error.find("truncated"), std::string::npos)
          << error << " of " << length << " / " << file.size();
    }
  }
}

TEST_F(ImageFormats, JpegWithoutItsEndMarker) {
  const std::string whole = jpeg(40, 30, {200, 100, 50}, false);
  const Rgb color = texel(*load(whole.substr(0, whole.size() - 2)), 39, 29);
  EXPECT_EQ(color, texel(*load(whole), 39, 29));
}

/// Returns 3 x 2 pixels whose greens are 1 to 6 in file order.
std::string radiance(const std::string& size) {
  std::string file = "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n";
  for (int i = 1; i <= 6; ++i) file += bytes_of({0, i, 0, 128 + 8});
  return file;
}

TEST_F(ImageFormats, RadianceOfAnyOrientation) {
  const struct {
    const char* size;
    std::vector<int> pixels;  ///< rows from the top
  } cases[] = {
      {"-Y 2 +X 3", {1, 2, 3, 4, 5, 6}}, {"+Y 2 +X 3", {4, 5, 6, 1, 2, 3}},
      {"-Y 2 -X 3", {3, 2, 1, 6, 5, 4}}, {"+Y 2 -X 3", {6, 5, 4, 3, 2, 1}},
      {"+X 3 -Y 2", {1, 3, 5, 2, 4, 6}}, {"+X 3 +Y 2", {2, 4, 6, 1, 3, 5}},
      {"-X 3 -Y 2", {5, 3, 1, 6, 4, 2}}, {"-X 3 +Y 2", {6, 4, 2, 5, 3, 1}},
  };
  for (const auto& c : cases) {
    const auto texture = load(radiance(c.size));
    ASSERT_EQ(texture->resolution(), glm::uvec2(3, 2)) << c.size;
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(texel(*texture, i % 3, i / 3).y / 255, static_cast<float>(c.pixels[i]))
          << c.size << " " << i;
    }
  }
}

TEST_F(ImageFormats, RadianceRunsAndXyz) {
  // Runs of each channel: 10 pixels of 1, 2, 3 (3 of them literal), exponent 129.
  const std::string header = "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 10\r\n";
  const auto runs =
      load(header + bytes_of({2, 2, 0, 10, 138, 128, 138, 64, 3, 5, 6, 7, 135, 32, 138, 129}));
  EXPECT_EQ(texel(*runs, 0) / 255.f, Rgb(1, 0.5f, 5 / 128.f));
  EXPECT_EQ(texel(*runs, 9) / 255.f, Rgb(1, 0.5f, 0.25f));
  // Runs of pixels: 1 + 2 + 256 x 1.
  const auto old =
      load("#?RGBE\n\n-Y 1 +X 259\n" + bytes_of({128, 64, 32, 129, 1, 1, 1, 2, 1, 1, 1, 1}));
  EXPECT_EQ(texel(*old, 258) / 255.f, Rgb(1, 0.5f, 0.25f));
  const Rgb xyz =
      texel(*load("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + bytes_of({2, 2, 2, 135})),
            0) /
      255.f;
  // XYZ = (1, 1, 1) in Rec.709.
  EXPECT_NEAR(xyz.x, 1.2048f, 1e-3f);
  EXPECT_NEAR(xyz.y, 0.9483f, 1e-3f);
  EXPECT_NEAR(xyz.z, 0.9089f, 1e-3f);
  const auto part_of_error = [&](const std::string& file) { return error_of(file); };
  EXPECT_NE(part_of_error("#?RADIANCE\n\n-Y 1 -Y 1\nabcd").find("must have a size"),
            std::string::npos);
  EXPECT_NE(part_of_error("#?RADIANCE\n\n-Y 1 +X 2\n" + bytes_of({1, 1, 1, 1, 1, 1, 1, 1}))
                .find("a different length"),
            std::string::npos);
  EXPECT_NE(part_of_error(header + bytes_of({2, 2, 0, 10, 138, 128, 138, 64, 0, 5})).find("length"),
            std::string::npos);
  EXPECT_NE(part_of_error("#?RADIANCE\n\n-Y 100000 +X 100000\nabcd").find("can't hold"),
            std::string::npos);
}

}  // namespace
}  // namespace kinome::test::image_formats_test
