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

namespace kinome::test::image_test {
namespace {

namespace fs = std::filesystem;

TEST(Exr, FloatRoundTripIsExact) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const Image image =
      make_image(37, 21, {"R", "G", "B", "A", "albedo.B", "albedo.G", "albedo.R", "depth.Y"});
  write_exr(path, image, ExrSampleType::kFloat, {});
  const Image back = read_exr(path);
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 21);
  EXPECT_EQ(back.channels, image.channels);
  EXPECT_EQ(back.data, image.data);
}

TEST(Exr, BytesDontDependOnThreads) {
  const TemporaryFolder folder;
  const Image image = make_image(701, 523, {"R", "G", "B"});  // large enough for threads
  const auto written = [&](unsigned threads, ExrSampleType number) {
    set_image_file_threads(threads);
    write_exr(folder.path("a.exr"), image, number, {});
    return read_file(folder.path("a.exr"));
  };
  for (const ExrSampleType number : {ExrSampleType::kHalf, ExrSampleType::kFloat}) {
    const std::string bytes = written(1, number);
    for (const unsigned threads : {2u, 5u, 0u}) EXPECT_EQ(written(threads, number), bytes);
  }
  EXPECT_EQ(read_exr(folder.path("a.exr")).data, image.data);
}

TEST(Exr, SmallHalvesAreZipped) {
  const TemporaryFolder folder;
  const auto compression_of = [&](int width, int height, ExrSampleType number) {
    Image image{width, height, {"R", "G", "B"}, {}};
    image.data.assign(static_cast<size_t>(width) * height * 3, 0.5f);
    write_exr(folder.path("a.exr"), image, number, {});
    return Imf::InputFile(folder.path("a.exr").c_str()).header().compression();
  };
  EXPECT_EQ(compression_of(64, 48, ExrSampleType::kHalf), Imf::ZIP_COMPRESSION);
  EXPECT_EQ(compression_of(512, 512, ExrSampleType::kHalf), Imf::PIZ_COMPRESSION);
  EXPECT_EQ(compression_of(512, 512, ExrSampleType::kFloat), Imf::ZIP_COMPRESSION);
}

TEST(Exr, HalfRoundTripRoundsToHalf) {
  const TemporaryFolder folder;
  const Image image = make_image(70, 45, {"R", "G", "B"});
  write_exr(folder.path("a.exr"), image, ExrSampleType::kHalf, {});
  const Image back = read_exr(folder.path("a.exr"));
  for (size_t i = 0; i < image.data.size(); ++i) {
    ASSERT_EQ(back.data[i], static_cast<float>(half(image.data[i])));
  }
  const Image grey = make_image(5, 3, {"Y"});
  write_exr(folder.path("y.exr"), grey, ExrSampleType::kFloat, {});
  EXPECT_EQ(read_exr(folder.path("y.exr")).data, grey.data);
}

TEST(Exr, HalfKeepsTheSunFinite) {
  const TemporaryFolder folder;
  Image image = make_image(4, 1, {"Y"});
  image.data = {65504.f, 65520.f, -1e30f, kInfinity};
  testing::internal::CaptureStderr();
  write_exr(folder.path("a.exr"), image, ExrSampleType::kHalf, {});
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(read_exr(folder.path("a.exr")).data,
            (std::vector<float>{65504.f, 65504.f, -65504.f, kInfinity}));
  EXPECT_NE(log.find("2 values"), std::string::npos) << log;
}

TEST(Exr, MetadataAndWindows) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  const ImageMetadata metadata{{"seed", "7"}, {"scene", "sha \xc3\xa9 \"quoted\""}};
  write_exr(path, make_image(11, 5, {"R", "G", "B"}), ExrSampleType::kHalf, metadata, {7, 9},
            {40, 30});
  ImageMetadata back;
  EXPECT_EQ(read_exr(path, {}, &back).width, 11);
  EXPECT_EQ(back["seed"], "7");
  EXPECT_EQ(back["scene"], metadata.at("scene"));
  const Imf::InputFile file(path.c_str());
  EXPECT_EQ(file.header().dataWindow(), Imath::Box2i(Imath::V2i(7, 9), Imath::V2i(17, 13)));
  EXPECT_EQ(file.header().displayWindow(), Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(39, 29)));
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

TEST(Pfm, RefusesIncompleteFiles) {
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
