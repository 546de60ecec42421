#include "kinome/image_files.h"
#include "kinome/texture.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "support/render.h"

namespace kinome::test::texture_test {
namespace {

/// Returns bytes from hexadecimal digits.
std::string from_hex(const std::string& digits) {
  std::string bytes;
  for (size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// Small PNG files, made with Python's struct and zlib.
/// 2 x 1, 16-bit grey: 0x8000, 0xffff.
const std::string kGrey16 = from_hex(
    "89504e470d0a1a0a0000000d494844520000000200000001100000000081d9fc150000000d4944415478da636860f8"
    "ff1f000502027fc900d6750000000049454e44ae426082");
/// 1 x 1, RGBA: 200, 100, 50, and alpha 0.
const std::string kTransparent = from_hex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d4944415478da63389162"
    "c4000004b5015f7fd392c00000000049454e44ae426082");
/// 1 x 1, grey 128 with alpha 7.
const std::string kGreyAlpha = from_hex(
    "89504e470d0a1a0a0000000d4948445200000001000000010804000000b51c0c020000000b4944415478da63686007"
    "00010a0088c6e001e70000000049454e44ae426082");

/// 1 x 1 pixels with a palette, (200, 100, 50), interlaced. It has a text with a wrong checksum,
/// and more bytes after its end.
const std::string kPalette = from_hex(
    "89504e470d0a1a0a0000000d49484452000000010000000108030000015fcc042d0000000374455874610062dc49a2"
    "3a00000006504c5445000000c86432f39d81140000000a4944415478da6360040000030002e67da767000000004945"
    "4e44ae4260826d6f7265");
const std::string kNoPalette = from_hex(
    "89504e470d0a1a0a0000000d49484452000000010000000108030000015fcc042d0000000a4944415478da63600400"
    "00030002e67da7670000000049454e44ae426082");
/// The same, with a transparent colour whose alpha has a wrong checksum.
const std::string kWrongAlpha = from_hex(
    "89504e470d0a1a0a0000000d494844520000000100000001080300000028cb34bb00000003504c5445c86432f18005"
    "010000000174524e5307de824dc40000000a4944415478da6360000000020001e527defc0000000049454e44ae4260"
    "82");
/// Claims 100000 x 100000 pixels.
const std::string kHuge = from_hex(
    "89504e470d0a1a0a0000000d49484452000186a0000186a01000000000dda988570000000a4944415478da63600400"
    "00030002e67da7670000000049454e44ae426082");

class BitmapTest : public testing::Test {
 protected:
  /// Writes a 3 x 2 EXR of R = x + 10 y, G = .5, B = -.25 x.
  std::string colors() const {
    Image image{3, 2, {"R", "G", "B"}, {}};
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 3; ++x) {
        image.data.insert(image.data.end(), {static_cast<float>(x + 10 * y), 0.5f, -0.25f * x});
      }
    }
    return exr(image);
  }
  std::string exr(const Image& image) const {
    const std::string path = folder_.path("map.exr");
    write_exr(path, image, ExrSampleType::kFloat, {});
    return path;
  }
  static std::shared_ptr<Texture> load(const std::string& path, const std::string& children = "") {
    return make<Texture>("<texture type='bitmap'><string name='filename' value='" + path + "'/>" +
                         children + "</texture>");
  }
  static std::string error_of(const std::string& path, const std::string& children = "") {
    try {
      load(path, children);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

bool openimageio_is_loaded() {
  std::ifstream maps("/proc/self/maps");
  std::stringstream text;
  text << maps.rdbuf();
  return text.str().find("libOpenImageIO.so") != std::string::npos;
}

// Must be the first test of this file, because later ones load OpenImageIO.
TEST_F(BitmapTest, ExrAndPngNeedNoOpenImageIO) {
  ASSERT_FALSE(openimageio_is_loaded()) << "loaded by an earlier test of this process";
  load(colors());
  EXPECT_FALSE(openimageio_is_loaded());
  load(folder_.write("t.png", kGrey16));
  EXPECT_FALSE(openimageio_is_loaded());
  load(folder_.write("t.ppm", "P6 1 1 255\nabc"));
  EXPECT_TRUE(openimageio_is_loaded());
}

TEST_F(BitmapTest, TexelsAreCentred) {
  const auto map = load(colors());
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const Vec2 uv((static_cast<float>(x) + 0.5f) / 3, (static_cast<float>(y) + 0.5f) / 2);
      EXPECT_NEAR(map->eval(uv).x, x + 10 * y, 1e-5f) << "row 0 is v = 0";
    }
  }
  // Halfway between texels, in x and in both.
  EXPECT_NEAR(map->eval(Vec2(1 / 3.f, 0.25f)).x, 0.5f, 1e-5f);
  EXPECT_NEAR(map->eval(Vec2(2 / 3.f, 0.5f)).x, 6.5f, 1e-5f);
  EXPECT_NEAR(map->eval_1(Vec2(0.5f, 0.25f)), luminance(Rgb(1, 0.5f, -0.25f)), 1e-6f);
}

TEST_F(BitmapTest, ReportsItsResolution) {
  EXPECT_EQ(load(colors())->resolution(), glm::uvec2(3, 2));
  EXPECT_EQ(make<Texture>("<texture type='checkerboard'/>")->resolution(), glm::uvec2(1, 1));
}

TEST_F(BitmapTest, WrapModes) {
  const std::string path = colors();
  const auto r = [&](const char* mode, float u, float v) {
    return load(path,
                "<string name='filter_type' value='nearest'/>"
                "<string name='wrap_mode' value='" +
                    std::string(mode) + "'/>")
        ->eval(Vec2(u, v))
        .x;
  };
  EXPECT_EQ(r("repeat", 1.1f, 0.2f), 0);
  EXPECT_EQ(r("repeat", -0.1f, -0.2f), 12);
  EXPECT_EQ(r("mirror", 1.1f, 0.2f), 2);
  EXPECT_EQ(r("mirror", -0.1f, 1.9f), 0);
  EXPECT_EQ(r("clamp", 7.f, -3.f), 2);
  EXPECT_EQ(r("clamp", -7.f, 3.f), 10);
  // Between the last and the first texel: their mean (repeat), their mirrored neighbours, or the
  // last texel (clamp).
  const auto seam = [&](const char* mode) {
    return load(path, "<string name='wrap_mode' value='" + std::string(mode) + "'/>")
        ->eval(Vec2(1.f, 0.25f))
        .x;
  };
  EXPECT_NEAR(seam("repeat"), 1, 1e-5f);
  EXPECT_NEAR(seam("mirror"), 2, 1e-5f);
  EXPECT_NEAR(seam("clamp"), 2, 1e-5f);
}

TEST_F(BitmapTest, AnyCoordinateIsFinite) {
  const std::string path = colors();
  for (const char* mode : {"repeat", "mirror", "clamp"}) {
    const auto map = load(path, "<string name='wrap_mode' value='" + std::string(mode) + "'/>");
    for (const float u : {-1e-9f, 0.f, 1.f, 1e9f, -1e30f, kInfinity, -kInfinity, std::nanf("")}) {
      const Rgb c = map->eval(Vec2(u, -u));
      EXPECT_TRUE(is_finite(c) && c.x >= 0 && c.x <= 12) << mode << " at " << u;
    }
  }
}

TEST_F(BitmapTest, ToUvMapsSurfaceToImage) {
  const auto map = load(colors(),
                        "<string name='filter_type' value='nearest'/><transform name='to_uv'>"
                        "<scale x='2' y='1'/><translate x='.5'/></transform>");
  // u' = 2 u + .5 = .7: the last texel.
  EXPECT_EQ(map->eval(Vec2(0.1f, 0.2f)).x, 2);
}

TEST_F(BitmapTest, SlopesAreDifferencesOfHeights) {
  Image image{4, 4, {"R", "G", "B"}, {}};
  for (int i = 0; i < 48; ++i) image.data.push_back(static_cast<float>((i * 29) % 17) * 0.1f);
  const std::string path = exr(image);
  for (const char* wrap : {"repeat", "mirror", "clamp"}) {
    for (const char* to_uv :
         {"", "<transform name='to_uv'><scale x='-3' y='2'/></transform>",
          "<transform name='to_uv'><rotate z='1' angle='30'/><scale value='2'/></transform>"}) {
      const auto texture =
          load(path, "<string name='wrap_mode' value='" + std::string(wrap) + "'/>" + to_uv);
      // No position is within a step of the border of an interpolation cell.
      for (const Vec2 uv : {Vec2(0.33f, 0.47f), Vec2(1.33f, -0.41f), Vec2(0.02f, 0.98f)}) {
        constexpr float kStep = 1e-3f;
        const auto difference = [&](const Vec2& step) {
          return (texture->eval_1(uv + step) - texture->eval_1(uv - step)) / (2 * kStep);
        };
        const Vec2 slope = texture->eval_1_gradient(uv);
        EXPECT_NEAR(slope.x, difference({kStep, 0}), 1e-3f) << wrap << to_uv << uv.x;
        EXPECT_NEAR(slope.y, difference({0, kStep}), 1e-3f) << wrap << to_uv << uv.x;
      }
    }
  }
  const auto nearest = load(path, "<string name='filter_type' value='nearest'/>");
  EXPECT_EQ(nearest->eval_1_gradient(Vec2(0.3f)), Vec2(0));
}

/// Values of Mitsuba 3.9.1 for an image of unequal sides that to_uv rotates. Texel i of the 3 x 2
/// image has the height (7 i) mod 5.
TEST_F(BitmapTest, SlopesOfTurnedImagesAreMitsubas) {
  Image image{3, 2, {"Y"}, {}};
  for (int i = 0; i < 6; ++i) image.data.push_back(static_cast<float>((7 * i) % 5));
  const auto texture =
      load(exr(image),
           "<boolean name='raw' value='true'/><transform name='to_uv'><rotate z='1' "
           "angle='30'/><scale x='2' y='3'/></transform>");
  const Vec2 slope = texture->eval_1_gradient(Vec2(0.33f, 0.47f));
  EXPECT_NEAR(slope.x, 3.54087f, 1e-3f);
  EXPECT_NEAR(slope.y, -1.19902f, 1e-3f);
}

TEST_F(BitmapTest, StatisticsCoverTheTexels) {
  const auto map = load(colors());
  EXPECT_FLOAT_EQ(map->mean().x, 6);
  EXPECT_FLOAT_EQ(map->mean().z, -0.25f);
  EXPECT_FLOAT_EQ(map->max(), 12);
  EXPECT_FLOAT_EQ(map->min(), -0.5f);
  EXPECT_EQ(map->channel_max(), Rgb(12, 0.5f, 0));
  EXPECT_FALSE(map->is_uniform());
}

TEST_F(BitmapTest, OneChannelIsGrey) {
  const auto map =
      load(exr(Image{2, 1, {"Y"}, {0.25f, 3}}), "<string name='filter_type' value='nearest'/>");
  EXPECT_EQ(map->eval(Vec2(0.7f, 0.5f)), Rgb(3));
  EXPECT_EQ(map->eval_1(Vec2(0.2f, 0.5f)), 0.25f);
  EXPECT_FLOAT_EQ(map->mean().y, 1.625f);
  // Alpha next to colours is dropped, in any channel order.
  const auto rgba = load(exr(Image{1, 1, {"A", "B", "G", "R"}, {9, 3, 2, 1}}));
  EXPECT_EQ(rgba->eval(Vec2(0.5f)), Rgb(1, 2, 3));
}

TEST_F(BitmapTest, EightBitIsDecodedBeforeFiltering) {
  const std::string path = folder_.path("two.png");
  // Writes round(255 linear_to_srgb(v)): 0 and 255 are exact, .05 becomes 63.
  write_png(path, Image{2, 1, {"R", "G", "B"}, {0, 0.05f, 1, 1, 0.05f, 1}}, 0);
  const auto map = load(path);
  EXPECT_NEAR(map->eval(Vec2(0.5f)).x, 0.5f, 1e-6f) << "the mean of 0 and 1, decoded first";
  EXPECT_NEAR(map->eval(Vec2(0.25f, 0.5f)).y, srgb_to_linear(63 / 255.f), 1e-6f);
  EXPECT_NEAR(map->mean().x, 0.5f, 1e-6f);
  const auto raw = load(path, "<boolean name='raw' value='true'/>");
  EXPECT_NEAR(raw->eval(Vec2(0.25f, 0.5f)).y, 63 / 255.f, 1e-6f);
}

TEST_F(BitmapTest, SixteenBitAndAlpha) {
  const std::string nearest = "<string name='filter_type' value='nearest'/>";
  const auto grey = load(folder_.write("g.png", kGrey16), nearest);
  EXPECT_NEAR(grey->eval(Vec2(0.25f, 0.5f)).x, srgb_to_linear(32768 / 65535.f), 1e-5f);
  EXPECT_NEAR(grey->eval_1(Vec2(0.75f, 0.5f)), 1, 1e-6f);
  const auto clear = load(folder_.write("a.png", kTransparent));
  EXPECT_NEAR(clear->eval(Vec2(0.5f)).x, srgb_to_linear(200 / 255.f), 1e-6f)
      << "colours are not multiplied by alpha";
  const auto grey_alpha = load(folder_.write("ga.png", kGreyAlpha));
  EXPECT_NEAR(grey_alpha->eval(Vec2(0.5f)).z, srgb_to_linear(128 / 255.f), 1e-6f);
  const Rgb of_palette = load(folder_.write("p.png", kPalette))->eval(Vec2(0.5f));
  EXPECT_NEAR(of_palette.x, srgb_to_linear(200 / 255.f), 1e-6f);
  EXPECT_NEAR(of_palette.z, srgb_to_linear(50 / 255.f), 1e-6f);
}

TEST_F(BitmapTest, BadFilesAreErrorsOfOneLine) {
  const auto expect = [&](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.rfind(folder_.folder(), 0), 0u) << message;
    EXPECT_NE(message.find(" (referenced by test.xml:1:"), std::string::npos) << message;
  };
  const std::string missing = error_of("nowhere.png");
  EXPECT_EQ(missing.rfind("test.xml:1:", 0), 0u) << missing;
  EXPECT_NE(missing.find("there is no file 'nowhere.png'"), std::string::npos) << missing;
  expect(error_of(folder_.write("text.png", "Not a picture.\n")), "can't be read as an image");
  expect(error_of(folder_.write("empty.png", "")), "can't be read as an image");
  for (const size_t bytes : {10, 40, 60}) {
    expect(error_of(folder_.write("cut.png", kGrey16.substr(0, bytes))), "can't be read");
  }
  std::string damaged = kGrey16;
  damaged[damaged.size() - 20] ^= 1;
  expect(error_of(folder_.write("damaged.png", damaged)), "libpng: IDAT");
  expect(error_of(folder_.write("no_palette.png", kNoPalette)), "Missing PLTE");
  // Alpha is not used, so that its wrong checksum is ignored.
  EXPECT_EQ(error_of(folder_.write("wrong_alpha.png", kWrongAlpha)), "");
  // 100000 x 100000 pixels in 67 bytes are rejected without an allocation.
  expect(error_of(folder_.write("huge.png", kHuge)), "can't hold 100000 x 100000");
  expect(error_of(exr(Image{1, 1, {"depth.Z", "id"}, {1, 1}})), "it has the channels depth.Z, id, expected R, G, B,");
  const std::string choice = error_of(colors(), "<string name='wrap_mode' value='mirrored'/>");
  EXPECT_NE(choice.find("did you mean 'mirror'"), std::string::npos) << choice;
}

TEST_F(BitmapTest, NonFiniteTexelsAreReplacedWithAWarning) {
  const float nan = std::nanf("");
  const std::string nearest = "<string name='filter_type' value='nearest'/>";
  const std::string path =
      exr(Image{3, 1, {"R", "G", "B"}, {1, nan, 3, nan, nan, nan, kInfinity, 1, -kInfinity}});
  testing::internal::CaptureStderr();
  const auto map = load(path, nearest);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "kinome: warning: " + path + ": 2 texels with NaN, which becomes 0\n" +
                "kinome: warning: " + path + ": 1 texel with infinity, which becomes 65504\n" +
                "kinome: warning: " + path +
                ": 1 texel is negative, with 50 % of the image's energy, and is kept\n");
  EXPECT_EQ(map->eval(Vec2(0.2f, 0.5f)), Rgb(1, 0, 3));
  EXPECT_EQ(map->eval(Vec2(0.5f, 0.5f)), Rgb(0));
  EXPECT_EQ(map->eval(Vec2(0.8f, 0.5f)), Rgb(65504, 1, -65504));
  EXPECT_EQ(map->max(), 65504);
  EXPECT_EQ(load(exr(Image{2, 1, {"Y"}, {kInfinity, 1e6f}}))->max(), 1e6f);
}

TEST_F(BitmapTest, NegativeTexelsMatterFromAThousandthOfTheEnergy) {
  const auto warning_of = [&](float value) {
    testing::internal::CaptureStderr();
    load(exr(Image{2, 1, {"Y"}, {1, value}}));
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(warning_of(-0.0009f), "");
  EXPECT_NE(warning_of(-0.0012f).find("1 texel is negative, with 0.12 % of the image's energy"),
            std::string::npos);
}

TEST_F(BitmapTest, ReflectancesAboveOneAreClamped) {
  const std::string map =
      "<texture type='bitmap' name='reflectance'><string name='filename' value='" + colors() +
      "'/><string name='filter_type' value='nearest'/></texture>";
  testing::internal::CaptureStderr();
  const auto bsdf = make<Bsdf>("<bsdf type='diffuse'>" + map + "</bsdf>");
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(
      log.find("'reflectance' must be between 0 and 1, but its texture has values up to 12: "
               "they are clamped to that range"),
      std::string::npos)
      << log;
  SurfaceInteraction si;
  si.uv = Vec2(0.5f, 0.75f);  // (11, .5, -.25)
  si.wi = Vec3(0, 0, 1);
  const Rgb f = bsdf->eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)).f;
  EXPECT_NEAR(f.x * kPi, 1, 1e-6f);
  EXPECT_NEAR(f.y * kPi, 0.5f, 1e-6f);
  EXPECT_EQ(f.z, 0);
}

TEST(Checkerboard, SwapsItsColorsAsANumber) {
  const auto map = make<Texture>("<texture type='checkerboard'/>");
  EXPECT_EQ(map->eval(Vec2(0.2f, 0.3f)), Rgb(0.4f));
  EXPECT_EQ(map->eval(Vec2(0.7f, 0.3f)), Rgb(0.2f));
  EXPECT_EQ(map->eval(Vec2(-0.2f, 0.9f)), Rgb(0.4f));
  EXPECT_EQ(map->eval_1(Vec2(0.2f, 0.3f)), 0.2f);
  EXPECT_EQ(map->eval_1(Vec2(0.7f, 0.3f)), 0.4f);
  EXPECT_FLOAT_EQ(map->mean().x, 0.3f);
  EXPECT_FLOAT_EQ(map->max(), 0.4f);
  EXPECT_FLOAT_EQ(map->min(), 0.2f);
  const auto scaled = make<Texture>(
      "<texture type='checkerboard'><rgb name='color0' value='1 0 0'/>"
      "<transform name='to_uv'><scale value='10'/></transform></texture>");
  EXPECT_EQ(scaled->eval(Vec2(0.02f, 0.03f)), Rgb(1, 0, 0));
  EXPECT_EQ(scaled->eval(Vec2(0.07f, 0.03f)), Rgb(0.2f));
}

}  // namespace
}  // namespace kinome::test::texture_test
