#include "kinome/image_files.h"
#include "kinome/image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <half.h>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "support/image_helpers.h"
#include "kinome/color.h"
#include "support/png.h"

namespace kinome::test::image_test {
namespace {

namespace fs = std::filesystem;

TEST(Exr, FloatRoundTripIsExact) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const Image image =
      make_image(37, 21, {"R", "G", "B", "A", "albedo.B", "albedo.G", "albedo.R", "depth.Y"});
  write_exr(path, image, ExrNumber::kFloat, {});
  const Image back = read_exr(path);
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 21);
  EXPECT_EQ(back.channels, image.channels);
  EXPECT_EQ(back.data, image.data);
}

TEST(Exr, BytesAreThoseOfOneThread) {
  const TemporaryFolder folder;
  const Image image = make_image(701, 523, {"R", "G", "B"});  // large enough for threads
  const auto written = [&](unsigned threads, ExrNumber number) {
    set_image_file_threads(threads);
    write_exr(folder.path("a.exr"), image, number, {});
    return read_file(folder.path("a.exr"));
  };
  for (const ExrNumber number : {ExrNumber::kHalf, ExrNumber::kFloat}) {
    const std::string bytes = written(1, number);
    for (const unsigned threads : {2u, 5u, 0u}) EXPECT_EQ(written(threads, number), bytes);
  }
  EXPECT_EQ(read_exr(folder.path("a.exr")).data, image.data);
}

TEST(Exr, SmallHalvesAreZipped) {
  const TemporaryFolder folder;
  const auto compression_of = [&](int width, int height, ExrNumber number) {
    Image image{width, height, {"R", "G", "B"}, {}};
    image.data.assign(static_cast<size_t>(width) * height * 3, 0.5f);
    write_exr(folder.path("a.exr"), image, number, {});
    return Imf::InputFile(folder.path("a.exr").c_str()).header().compression();
  };
  EXPECT_EQ(compression_of(64, 48, ExrNumber::kHalf), Imf::ZIP_COMPRESSION);
  EXPECT_EQ(compression_of(512, 512, ExrNumber::kHalf), Imf::PIZ_COMPRESSION);
  EXPECT_EQ(compression_of(512, 512, ExrNumber::kFloat), Imf::ZIP_COMPRESSION);
}

TEST(Exr, HalfRoundTripRoundsToHalf) {
  const TemporaryFolder folder;
  const Image image = make_image(70, 45, {"R", "G", "B"});
  write_exr(folder.path("a.exr"), image, ExrNumber::kHalf, {});
  const Image back = read_exr(folder.path("a.exr"));
  for (size_t i = 0; i < image.data.size(); ++i) {
    ASSERT_EQ(back.data[i], static_cast<float>(half(image.data[i])));
  }
  const Image grey = make_image(5, 3, {"Y"});
  write_exr(folder.path("y.exr"), grey, ExrNumber::kFloat, {});
  EXPECT_EQ(read_exr(folder.path("y.exr")).data, grey.data);
}

TEST(Exr, HalfKeepsTheSunFinite) {
  const TemporaryFolder folder;
  Image image = make_image(4, 1, {"Y"});
  image.data = {65504.f, 65520.f, -1e30f, kInfinity};
  testing::internal::CaptureStderr();
  write_exr(folder.path("a.exr"), image, ExrNumber::kHalf, {});
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(read_exr(folder.path("a.exr")).data,
            (std::vector<float>{65504.f, 65504.f, -65504.f, kInfinity}));
  EXPECT_NE(log.find("2 values"), std::string::npos) << log;
}

TEST(Exr, MetadataAndWindows) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const ImageMetadata metadata{{"seed", "7"}, {"scene", "sha \xc3\xa9 \"quoted\""}};
  write_exr(path, make_image(11, 5, {"R", "G", "B"}), ExrNumber::kHalf, metadata, {7, 9}, {40, 30});
  ImageMetadata back;
  EXPECT_EQ(read_exr(path, {}, &back).width, 11);
  EXPECT_EQ(back["seed"], "7");
  EXPECT_EQ(back["scene"], metadata.at("scene"));
  const Imf::InputFile file(path.c_str());
  EXPECT_EQ(file.header().dataWindow(), Imath::Box2i(Imath::V2i(7, 9), Imath::V2i(17, 13)));
  EXPECT_EQ(file.header().displayWindow(), Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(39, 29)));
}

TEST(Exr, ReadsTilesAndMixedChannelTypes) {
  const TemporaryFolder folder;
  const std::string path = folder.path("tiled.exr");
  constexpr int kWidth = 50;
  constexpr int kHeight = 33;
  std::vector<half> b(kWidth * kHeight);
  std::vector<float> g(kWidth * kHeight);
  std::vector<uint32_t> r(kWidth * kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    b[i] = half(i * 0.5f);
    g[i] = static_cast<float>(i) / 7;
    r[i] = static_cast<uint32_t>(3 * i);
  }
  {
    Imf::Header header(kWidth, kHeight);
    header.channels().insert("B", Imf::Channel(Imf::HALF));
    header.channels().insert("G", Imf::Channel(Imf::FLOAT));
    header.channels().insert("R", Imf::Channel(Imf::UINT));
    header.setTileDescription(Imf::TileDescription(16, 16, Imf::ONE_LEVEL));
    Imf::TiledOutputFile file(path.c_str(), header);
    Imf::FrameBuffer buffer;
    const auto slice = [](Imf::PixelType type, auto& data) {
      return Imf::Slice(type, reinterpret_cast<char*>(data.data()), sizeof(data[0]),
                        sizeof(data[0]) * kWidth);
    };
    buffer.insert("B", slice(Imf::HALF, b));
    buffer.insert("G", slice(Imf::FLOAT, g));
    buffer.insert("R", slice(Imf::UINT, r));
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  }
  const Image image = read_exr(path);
  ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
  for (int i = 0; i < kWidth * kHeight; ++i) {
    ASSERT_EQ(image.data[3 * i], static_cast<float>(3 * i));
    ASSERT_EQ(image.data[3 * i + 1], g[i]);
    ASSERT_EQ(image.data[3 * i + 2], static_cast<float>(b[i]));
  }
}

/// x and y of red, green, blue and white.
using Chromaticities = std::array<float, 8>;
constexpr Chromaticities kRec709{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
constexpr Chromaticities kDisplayP3{0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
constexpr Chromaticities kAcesAp0{0.7347f, 0.2653f, 0.f, 1.f, 0.0001f, -0.077f, 0.32168f, 0.33767f};
constexpr Chromaticities kXyz{1.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f / 3, 1.f / 3};

void write_with(const Chromaticities& c, const std::string& path, const Image& image) {
  Imf::Header header(image.width, image.height);
  Imf::addChromaticities(header, {{c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}});
  Imf::FrameBuffer buffer;
  const size_t pixel = image.channels.size() * sizeof(float);
  for (size_t i = 0; i < image.channels.size(); ++i) {
    header.channels().insert(image.channels[i], Imf::Channel(Imf::FLOAT));
    char* const base = const_cast<char*>(reinterpret_cast<const char*>(&image.data[i]));
    buffer.insert(image.channels[i], Imf::Slice(Imf::FLOAT, base, pixel, pixel * image.width));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(image.height);
}

/// Returns the matrix whose columns are the XYZ of red, green and blue. Their sum is a white of Y =
/// 1.
glm::dmat3 rgb_to_xyz(const Chromaticities& c) {
  const auto xyz = [&c](int i) {
    return glm::dvec3(c[2 * i], c[2 * i + 1], 1. - c[2 * i] - c[2 * i + 1]);
  };
  const glm::dmat3 primaries(xyz(0), xyz(1), xyz(2));
  const glm::dvec3 amounts = glm::inverse(primaries) * (xyz(3) / double{c[7]});
  return {primaries[0] * amounts.x, primaries[1] * amounts.y, primaries[2] * amounts.z};
}

TEST(Exr, ChromaticitiesBecomeRec709) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const Image image = make_image(9, 5, {"R", "G", "B", "A", "depth.Z"});
  for (const Chromaticities& c : {kDisplayP3, kAcesAp0, kXyz}) {
    write_with(c, path, image);
    const Image back = read_exr(path);
    ASSERT_EQ(back.channels, image.channels);
    const glm::dmat3 matrix = glm::inverse(rgb_to_xyz(kRec709)) * rgb_to_xyz(c);
    for (size_t i = 0; i < image.data.size(); i += 5) {
      const glm::dvec3 color(image.data[i], image.data[i + 1], image.data[i + 2]);
      const glm::dvec3 expected = matrix * color;
      // Tolerance: a single-precision matrix with entries up to 3, and texels up to 90.
      for (int k = 0; k < 3; ++k) ASSERT_NEAR(back.data[i + k], expected[k], 2e-4) << i << " " << k;
      ASSERT_EQ(back.data[i + 3], image.data[i + 3]);
      ASSERT_EQ(back.data[i + 4], image.data[i + 4]);
    }
  }
}

/// Values of mi.Bitmap("a.exr") in Mitsuba 3.9.1; its `bitmap` (also with raw), `envmap` and
/// `projector` have the same ones. For XYZ it uses a matrix that is rounded to six digits.
TEST(Exr, ConvertsAsMitsubaDoes) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const Image image{1, 1, {"R", "G", "B"}, {0.8f, 0.5f, 0.2f}};
  const struct {
    Chromaticities chromaticities;
    float rgb[3];
    float tolerance;
  } cases[] = {{kDisplayP3, {0.86748195f, 0.48738286f, 0.16462663f}, 1e-6f},
               {kAcesAp0, {1.4086108f, 0.44192186f, 0.12820251f}, 2e-6f},
               {kXyz, {1.7241012f, 0.17090188f, 0.15395911f}, 4e-4f}};
  for (const auto& c : cases) {
    write_with(c.chromaticities, path, image);
    const Image back = read_exr(path);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(back.data[k], c.rgb[k], c.tolerance);
  }
}

/// Images with Rec.709 primaries within 0.001, as writers round them, and images without colours.
TEST(Exr, KeepsWhatNeedsNoConversion) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const Image image = make_image(9, 5, {"R", "G", "B", "A"});
  Chromaticities rounded = kRec709;
  rounded[6] += 0.0006f;
  rounded[7] -= 0.0006f;
  for (const Chromaticities& c : {kRec709, rounded}) {
    write_with(c, path, image);
    EXPECT_EQ(read_exr(path).data, image.data);
  }
  rounded[7] -= 0.0006f;
  write_with(rounded, path, image);
  EXPECT_NE(read_exr(path).data, image.data);
  for (const std::vector<std::string>& channels :
       {std::vector<std::string>{"Y"}, {"G", "R"}, {"n.X", "n.Y", "n.Z"}, {"X.B", "X.R"}}) {
    const Image other = make_image(4, 3, channels);
    write_with(kDisplayP3, path, other);
    EXPECT_EQ(read_exr(path).data, other.data) << channels[0];
  }
}

TEST(Exr, RefusesChromaticitiesOfNoColours) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const auto with = [](size_t i, float value) {
    Chromaticities c = kRec709;
    c[i] = value;
    return c;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Chromaticities bad[] = {
      {},
      {0.6f, 0.3f, 0.4f, 0.3f, 0.2f, 0.3f, 0.3127f, 0.329f},    // all on one line
      {0.64f, 0.33f, 0.64f, 0.33f, 0.15f, 0.06f, 0.3f, 0.33f},  // red is green
      with(7, 0.f),
      with(0, nan),
      with(6, nan),
      with(7, nan),
      with(3, kInfinity),
      with(6, -kInfinity),
      with(2, 1e30f),
      with(6, 1e38f),
  };
  for (const Chromaticities& c : bad) {
    write_with(c, path, make_image(3, 2, {"R", "G", "B"}));
    const std::string error = expect_error(
        [&] {
          read_exr(path, {"scene.xml", 3, 4});
        },
        "a.exr", "'chromaticities'");
    EXPECT_NE(error.find(" (referenced by scene.xml:3:4)"), std::string::npos) << error;
  }
}

TEST(Exr, RefusesWhatIsNoWholeFile) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  expect_error([&] { read_exr(path, {"scene.xml", 3, 4}); }, "a.exr", "no such file");
  EXPECT_EQ(expect_error(
                [&] {
                  read_exr(path, {"scene.xml", 3, 4});
                },
                "a.exr", ""),
            path + ": can't be read: no such file (referenced by scene.xml:3:4)");
  expect_error([&] { read_exr(folder.folder()); }, folder.folder(), "not a file");
  expect_error([&] { read_exr(folder.write("b.exr", "")); }, "b.exr", "not an OpenEXR file");
  expect_error([&] { read_exr(folder.write("c.exr", "P6\n1 1\n255\nabc")); }, "c.exr",
               "not an OpenEXR file");
  for (const bool as_half : {false, true}) {
    write_exr(path, make_image(64, 64, {"R", "G", "B"}),
              as_half ? ExrNumber::kHalf : ExrNumber::kFloat, {{"k", "v"}});
    const std::string whole = read_file(path);
    for (size_t length = 4; length < whole.size(); length += 1 + length / 16) {
      const std::string cut = folder.write("cut.exr", whole.substr(0, length));
      expect_error([&] { read_exr(cut); }, "cut.exr", "truncated");
    }
  }
}

TEST(Exr, DamagedFilesAreErrorsOrImages) {
  const TemporaryFolder folder;
  write_exr(folder.path("a.exr"), make_image(40, 24, {"R", "G", "B"}), ExrNumber::kFloat, {});
  const std::string whole = read_file(folder.path("a.exr"));
  int errors = 0;
  for (uint64_t trial = 0; trial < 400; ++trial) {
    std::string bytes = whole;
    // Most changes are in the header, which has the sizes and types.
    const size_t range = trial % 4 == 0 ? bytes.size() : 360;
    for (uint64_t k = 0; k < 1 + trial % 3; ++k) {
      const uint64_t h = hash_words(trial, k);
      bytes[8 + h % (range - 8)] = static_cast<char>(h >> 40);
    }
    try {
      const Image image = read_exr(folder.write("d.exr", bytes));
      EXPECT_EQ(image.data.size(),
                static_cast<size_t>(image.width) * image.height * image.channels.size());
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 20);
}

TEST(Exr, RefusesChannelsOfOneName) {
  const TemporaryFolder folder;
  expect_error(
      [&] {
        write_exr(folder.path("a.exr"), make_image(2, 2, {"R", "G", "R"}), ExrNumber::kHalf, {});
      },
      "a.exr", "two channels are named 'R'");
  expect_error([&] { write_exr(folder.path("a.exr"), Image{}, ExrNumber::kHalf, {}); }, "a.exr",
               "empty");
  EXPECT_EQ(file_count(folder.folder()), 0);
}

TEST(Pfm, RoundTrip) {
  const TemporaryFolder folder;
  const Image image = make_image(13, 7, {"R", "G", "B"});
  write_pfm(folder.path("a.pfm"), image);
  const Image back = read_pfm(folder.path("a.pfm"));
  EXPECT_EQ(back.channels, image.channels);
  EXPECT_EQ(back.data, image.data);
  const Image two = make_image(3, 2, {"Y", "A"});
  write_pfm(folder.path("y.pfm"), two);
  const Image grey = read_pfm(folder.path("y.pfm"));
  ASSERT_EQ(grey.channels, (std::vector<std::string>{"Y"}));
  EXPECT_EQ(grey.at(2, 1, 0), two.at(2, 1, 0));
  const Image layers = make_image(3, 2, {"Y", "depth.T", "uv.U", "uv.V"});
  write_pfm(folder.path("layers.pfm"), layers);
  const Image luminance = read_pfm(folder.path("layers.pfm"));
  ASSERT_EQ(luminance.channels, (std::vector<std::string>{"Y"}));
  EXPECT_EQ(luminance.at(2, 1, 0), layers.at(2, 1, 0));
  // Big-endian, scale 2, bottom row first.
  const std::string big("Pf\n1 2\n2.0\n\x3f\x80\x00\x00\x40\x00\x00\x00", 19);
  EXPECT_EQ(read_pfm(folder.write("b.pfm", big)).data, (std::vector<float>{4.f, 2.f}));
  // Lines may end in "\r\n". A line that ends in "\r" may be followed by data that start with "\n".
  const std::string data("\n\0\x80\x3f", 4);
  const float value = std::bit_cast<float>(0x3f80000a);
  for (const char* const end : {"\n", "\r\n", "\r"}) {
    const std::string file = "Pf\n1 1\n-1" + std::string(end) + data;
    EXPECT_EQ(read_pfm(folder.write("c.pfm", file)).data, std::vector<float>{value});
  }
}

TEST(Pfm, RefusesWhatIsNoWholeFile) {
  const TemporaryFolder folder;
  expect_error([&] { read_pfm(folder.path("none.pfm")); }, "none.pfm", "no such file");
  expect_error([&] { read_pfm(folder.write("a.pfm", "P6\n1 1\n255\nabc")); }, "a.pfm", "PFM");
  expect_error([&] { read_pfm(folder.write("a.pfm", "PF\n2 2\n-1\nabc")); }, "a.pfm", "truncated");
  expect_error([&] { read_pfm(folder.write("a.pfm", "PF\n2 2\n-1")); }, "a.pfm",
               "need 48 bytes, got 0");
  expect_error([&] { read_pfm(folder.write("a.pfm", "PF\n-2 2\n-1\n")); }, "a.pfm", "too large");
  expect_error([&] { read_pfm(folder.write("a.pfm", "PF\n2000000 2\n-1\n")); }, "a.pfm",
               "too large");
  expect_error([&] { read_pfm(folder.write("a.pfm", "PF\n100000 100000\n-1\nabcd")); }, "a.pfm",
               "truncated");
}

TEST(Png, EncodesSrgbAndSurvivesAnything) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Image image{
      3, 1, {"R", "G", "B"}, {0.f, 0.5f, 1.f, nan, -kInfinity, kInfinity, 0.18f, 2.f, -1.f}};
  write_png(folder.path("a.png"), image, 0);
  const auto byte = [](double linear) {
    return static_cast<png_byte>(std::lround(255 * linear_to_srgb(static_cast<float>(linear))));
  };
  EXPECT_EQ(read_png(folder.path("a.png")).rgba,
            (std::vector<png_byte>{0, 188, 255, 255, 0, 0, 255, 255, byte(0.18), 255, 0, 255}));
  write_png(folder.path("a.png"), image, -1);
  EXPECT_EQ(read_png(folder.path("a.png")).rgba[2], 188);
}

TEST(Png, AlphaAndGrey) {
  const TemporaryFolder folder;
  // Colours are premultiplied: .25 at coverage .5 becomes .5.
  write_png(folder.path("a.png"), {1, 1, {"R", "G", "B", "A"}, {0.25f, 0.5f, 0, 0.5f}}, 0);
  EXPECT_EQ(read_png(folder.path("a.png")).rgba, (std::vector<png_byte>{188, 255, 0, 128}));
  write_png(folder.path("y.png"), {1, 1, {"Y"}, {0.5f}}, 0);
  EXPECT_EQ(read_png(folder.path("y.png")).rgba, (std::vector<png_byte>{188, 188, 188, 255}));
  write_png(folder.path("ya.png"), {1, 1, {"Y", "A", "depth"}, {0.5f, 1.f, 9.f}}, 0);
  EXPECT_EQ(read_png(folder.path("ya.png")).rgba, (std::vector<png_byte>{188, 188, 188, 255}));
}

}  // namespace
}  // namespace kinome::test::image_test
