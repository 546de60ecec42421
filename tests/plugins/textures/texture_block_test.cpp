// Tests that textures have the same colours for blocks of positions as for single positions.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <png.h>

#include <bit>
#include <cmath>
#include <random>
#include <tuple>

#include "kinome/image_files.h"
#include "kinome/image.h"
#include "kinome/texture.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

namespace kinome::test::texture_block_test {
namespace {

/// Writes an image of w x h pixels: an EXR of floats, or a PNG of bytes.
std::string write_image(const TemporaryFolder& folder, const std::string& kind, int w, int h) {
  std::mt19937 rng(7);
  const bool is_grey = kind == "grey_exr" || kind == "grey_png";
  const size_t channels = is_grey ? 1 : 3;
  const std::string path = folder.path(kind + ".image");
  if (kind == "exr" || kind == "grey_exr") {
    Image image{w, h, {"R", "G", "B"}, {}};
    if (is_grey) image.channels = {"Y"};
    for (size_t i = 0; i < channels * w * h; ++i) {
      image.data.push_back(static_cast<float>(rng() % 1000) * 0.01f);
    }
    write_exr(path, image, ExrSampleType::kFloat, {});
    return path;
  }
  std::vector<png_byte> bytes(channels * w * h);
  for (png_byte& b : bytes) b = static_cast<png_byte>(rng() % 256);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = w, image.height = h;
  image.format = is_grey ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  EXPECT_TRUE(png_image_write_to_file(&image, path.c_str(), 0, bytes.data(), 0, nullptr));
  return path;
}

bool same(float a, float b) {
  return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b);
}

/// Returns positions in and far around the unit square, at edges of texels, infinite ones and NaN.
std::vector<Vec2> places(size_t count) {
  std::vector<Vec2> uv;
  const float ends[] = {0,  -0.f, 1,      0.5f,      -1e-9f, kOneMinusEpsilon,
                        -3, 1e9f, -1e30f, kInfinity, NAN};
  for (const float u : ends) {
    for (const float v : ends) uv.push_back({u, v});
  }
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> unit(-2, 3);
  while (uv.size() < count) uv.push_back({unit(rng), unit(rng)});
  uv.resize(count);
  return uv;
}

void expect_same(const Texture& texture, const std::string& what) {
  for (const size_t count :
       {size_t(1), size_t(15), size_t(16), size_t(17), size_t(33), size_t(1000)}) {
    const auto uv = places(count);
    BlockMemory columns(count);
    const Columns2 at = columns.two();
    const Columns3 color = columns.three();
    float* const number = columns.one();
    const Columns2 slope = columns.two();
    for (size_t i = 0; i < count; ++i) at.set(i, uv[i]);
    texture.eval_block(at, count, color);
    texture.eval_1_block(at, count, number);
    texture.eval_1_gradient_block(at, count, slope);
    for (size_t i = 0; i < count; ++i) {
      const Rgb c = texture.eval(uv[i]);
      EXPECT_TRUE(same(color.x[i], c.x) && same(color.y[i], c.y) && same(color.z[i], c.z) &&
                  same(number[i], texture.eval_1(uv[i])))
          << what << " at " << uv[i].x << ' ' << uv[i].y << ": " << color.x[i] << ' ' << color.y[i]
          << ' ' << color.z[i] << " instead of " << c.x << ' ' << c.y << ' ' << c.z;
      const Vec2 s = texture.eval_1_gradient(uv[i]);
      EXPECT_TRUE(same(slope.x[i], s.x) && same(slope.y[i], s.y))
          << what << " at " << uv[i].x << ' ' << uv[i].y << ": slopes " << slope.x[i] << ' '
          << slope.y[i] << " instead of " << s.x << ' ' << s.y;
    }
  }
}

class TextureBlocks : public testing::TestWithParam<InstructionSet> {};

TEST_P(TextureBlocks, MatchSinglePositions) {
  const TemporaryFolder folder;
  for (const char* kind : {"exr", "grey_exr", "png", "grey_png"}) {
    for (const int size : {1, 5}) {
      const std::string path = write_image(folder, kind, size, size == 1 ? 1 : 3);
      for (const char* wrap : {"repeat", "mirror", "clamp"}) {
        for (const char* filter : {"bilinear", "nearest"}) {
          for (const char* to_uv :
               {"", "<transform name='to_uv'><scale x='3' y='-2'/></transform>"}) {
            const auto texture = make_for<Texture>(
                GetParam(),
                fmt::format("<texture type='bitmap'><string name='filename' value='{}'/>"
                            "<string name='wrap_mode' value='{}'/>"
                            "<string name='filter_type' value='{}'/>{}</texture>",
                            path, wrap, filter, to_uv));
            expect_same(*texture, fmt::format("{} {} {} {} {}", kind, size, wrap, filter, to_uv));
          }
        }
      }
    }
  }
}

TEST_P(TextureBlocks, OfCheckersMatchTheirSquares) {
  expect_same(
      *make_for<Texture>(GetParam(),
                         "<texture type='checkerboard'><rgb name='color0' value='.1 .2 .3'/>"
                         "<rgb name='color1' value='.7 .1 .9'/></texture>"),
      "two colours");
  expect_same(
      *make_for<Texture>(
          GetParam(),
          "<texture type='checkerboard'><rgb name='color0' value='.1 .2 .3'/>"
          "<texture name='color1' type='checkerboard'><float name='color0' value='.3'/></texture>"
          "<transform name='to_uv'><matrix value='4 1 0 0  1 3 0 .25  0 0 1 0  0 0 0 1'/>"
          "</transform></texture>"),
      "nested, sheared");
}

TEST_P(TextureBlocks, OfOneColourAreThat) {
  expect_same(*make_uniform_texture(Rgb(0.25f, 0.5f, 0.75f)), "a colour");
  expect_same(*make_uniform_texture(Rgb(0.3f)), "a number");
}

INSTANTIATE_TEST_SUITE_P(All, TextureBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace
}  // namespace kinome::test::texture_block_test
