#include "kinome/image.h"
#include "kinome/image_files.h"

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

#include "kinome/color.h"
#include "support/image_helpers.h"
#include "support/png.h"

/// Tests the colours of EXR files, and damaged files.
namespace kinome::test::exr_files_test {
namespace {

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
TEST(Exr, KeepsColoursThatNeedNoConversion) {
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

TEST(Exr, RefusesIncompleteFiles) {
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
              as_half ? ExrSampleType::kHalf : ExrSampleType::kFloat, {{"k", "v"}});
    const std::string whole = read_file(path);
    for (size_t length = 4; length < whole.size(); length += 1 + length / 16) {
      const std::string cut = folder.write("cut.exr", whole.substr(0, length));
      expect_error([&] { read_exr(cut); }, "cut.exr", "truncated");
    }
  }
}

TEST(Exr, DamagedFilesAreErrorsOrImages) {
  const TemporaryFolder folder;
  write_exr(folder.path("a.exr"), make_image(40, 24, {"R", "G", "B"}), ExrSampleType::kFloat, {});
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
        write_exr(folder.path("a.exr"), make_image(2, 2, {"R", "G", "R"}), ExrSampleType::kHalf,
                  {});
      },
      "a.exr", "two channels are named 'R'");
  expect_error([&] { write_exr(folder.path("a.exr"), Image{}, ExrSampleType::kHalf, {}); }, "a.exr",
               "empty");
  EXPECT_EQ(file_count(folder.folder()), 0);
}

}  // namespace
}  // namespace kinome::test::exr_files_test
