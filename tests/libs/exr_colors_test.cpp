// Tests how the colour channels of an EXR file are selected.
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <gtest/gtest.h>

#include "support/image_helpers.h"
#include "kinome/image_files.h"
#include "kinome/color.h"

namespace kinome::test::exr_colors_test {
namespace {

using Names = std::vector<std::string>;

/// Returns 2 x 1 pixels. Channel c of pixel x has the value 1 + c + 10 x.
Image numbered(const Names& channels) {
  Image image{2, 1, channels, {}};
  for (int x = 0; x < 2; ++x) {
    for (size_t c = 0; c < channels.size(); ++c) {
      image.data.push_back(static_cast<float>(1 + c) + 10.f * static_cast<float>(x));
    }
  }
  return image;
}

struct Part {
  std::string name;
  Names channels;
};

/// Writes a file of several parts, each numbered() from 1.
void write_parts(const std::string& path, const std::vector<Part>& parts) {
  std::vector<Imf::Header> headers;
  for (const Part& part : parts) {
    Imf::Header header(2, 1);
    header.setName(part.name);
    header.setType(Imf::SCANLINEIMAGE);
    for (const std::string& channel : part.channels) {
      header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    }
    headers.push_back(header);
  }
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
  for (size_t i = 0; i < parts.size(); ++i) {
    Image image = numbered(parts[i].channels);
    const size_t pixel = image.channels.size() * sizeof(float);
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < image.channels.size(); ++c) {
      buffer.insert(image.channels[c],
                    Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&image.data[c]), pixel, 0));
    }
    Imf::OutputPart part(file, static_cast<int>(i));
    part.setFrameBuffer(buffer);
    part.writePixels(1);
  }
}

class ExrColors : public testing::Test {
 protected:
  Image read_back(const Image& image) const {
    write_exr(path_, image, ExrSampleType::kFloat, {});
    return read_exr(path_);
  }
  TemporaryFolder folder_;
  const std::string path_ = folder_.path("a.exr");
};

TEST_F(ExrColors, AreFoundInLayersAndInSmallLetters) {
  const Names rgb{"R", "G", "B"}, rgba{"R", "G", "B", "A"};
  const struct {
    Names file, read;
  } cases[] = {
      {{".R", ".G", ".B"}, rgb},
      {{"r", "g", "b", "a"}, rgba},
      {{"ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B",
        "ViewLayer.Combined.A"},
       rgba},
      {{"layer.r", "layer.g", "layer.b"}, rgb},
      {{"y"}, {"Y"}},
      {{"light.Y", "light.A"}, {"Y", "A"}},
  };
  for (const auto& c : cases) {
    const Image back = read_back(numbered(c.file));
    EXPECT_EQ(back.channels, c.read) << c.file[0];
    EXPECT_EQ(back.data, numbered(c.file).data) << c.file[0];
  }
}

TEST_F(ExrColors, ComeFirstAndLeaveOtherChannelsTheirNames) {
  const Image back = read_back(numbered({"R", "G", "B", "a.R", "a.G", "a.B", "Z"}));
  EXPECT_EQ(back.channels, (Names{"R", "G", "B", "Z", "a.B", "a.G", "a.R"}));
  EXPECT_EQ(back.data[0], 1);
  EXPECT_EQ(back.at(1, 0, 2), 13);
  EXPECT_EQ(back.at(0, 0, 3), 7);
  // A luminance without a layer name takes precedence over the colour of a layer.
  EXPECT_EQ(read_back(numbered({"Y", "albedo.R", "albedo.G", "albedo.B"})).channels[0], "Y");
}

TEST_F(ExrColors, PrefersTheLayerOfTheWholeImage) {
  const auto first = [this](const std::string& other) {
    const Image back = read_back(numbered(
        {"Diffuse.R", "Diffuse.G", "Diffuse.B", other + ".R", other + ".G", other + ".B"}));
    return back.data[0];
  };
  testing::internal::CaptureStderr();
  EXPECT_EQ(first("View.Combined"), 4);
  EXPECT_EQ(first("rgba"), 4);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  EXPECT_EQ(first("Emission"), 1);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("several layers with colour: using 'Diffuse.R', ignoring Emission"),
            std::string::npos)
      << log;
}

TEST_F(ExrColors, VectorsAreNoColours) {
  for (const Names& channels :
       {Names{"x", "y", "z"}, {"N.X", "N.Y", "N.Z"}, {"U", "V"}, {"X", "Y"}, {"G", "R"}}) {
    const Image image = numbered(channels);
    const Image back = read_back(image);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.data, image.data);
  }
}

/// mi.Bitmap of Mitsuba 3.9.1 converts (0.2, 0.3, 0.1) to these values.
TEST_F(ExrColors, XyzBecomesRec709) {
  const Image back = read_back(Image{1, 1, {"X", "Y", "Z", "A"}, {0.2f, 0.3f, 0.1f, 0.5f}});
  ASSERT_EQ(back.channels, (Names{"R", "G", "B", "A"}));
  EXPECT_NEAR(back.data[0], 0.1371f, 1e-4f);
  EXPECT_NEAR(back.data[1], 0.3731f, 1e-4f);
  EXPECT_NEAR(back.data[2], 0.0556f, 1e-4f);
  EXPECT_EQ(back.data[3], 0.5f);
  const glm::dvec3 c = xyz({0.8, 0.2, 0.05});
  const Image same =
      read_back(Image{1,
                      1,
                      {"X", "Y", "Z"},
                      {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)}});
  EXPECT_NEAR(same.data[0], 0.8f, 1e-6f);
  EXPECT_NEAR(same.data[1], 0.2f, 1e-6f);
  EXPECT_NEAR(same.data[2], 0.05f, 1e-6f);
}

TEST_F(ExrColors, ThePartWithColourIsRead) {
  write_parts(path_, {{"depth", {"Z"}}, {"beauty", {"R", "G", "B"}}});
  EXPECT_EQ(read_exr(path_).channels, (Names{"R", "G", "B"}));
  EXPECT_EQ(read_exr(path_).data, numbered({"R", "G", "B"}).data);
  write_parts(path_, {{"n", {"N.X", "N.Y", "N.Z"}},
                      {"layer", {"a.R", "a.G", "a.B", "a.A"}},
                      {"grey", {"Y"}},
                      {"late", {"R", "G", "B"}},
                      {"last", {"R", "G", "B", "A"}}});
  EXPECT_EQ(read_exr(path_).channels, (Names{"R", "G", "B"}));
  write_parts(path_, {{"depth", {"Z"}}, {"id", {"id"}}});
  expect_error([&] { read_exr(path_); }, path_, "none of its 2 parts has a colour");
}

/// OpenEXR writes Y, and RY and BY at half the resolution. A smooth image survives this.
TEST_F(ExrColors, LuminanceAndChromaBecomeRgb) {
  constexpr int kWidth = 32, kHeight = 20;
  for (const bool has_alpha : {false, true}) {
    Imf::Array2D<Imf::Rgba> pixels(kHeight, kWidth);
    const auto color = [](int x, int y) {
      return Rgb(0.8f - 0.01f * static_cast<float>(x), 0.2f + 0.01f * static_cast<float>(y), 0.1f);
    };
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Rgb c = color(x, y);
        pixels[y][x] = {half(c.x), half(c.y), half(c.z), half(0.25f)};
      }
    }
    {
      const Imath::Box2i window({6, -4}, {6 + kWidth - 1, -4 + kHeight - 1});
      Imf::RgbaOutputFile file(path_.c_str(), window, window,
                               has_alpha ? Imf::WRITE_YCA : Imf::WRITE_YC);
      file.setFrameBuffer(&pixels[0][0] - 6 + 4 * kWidth, 1, kWidth);
      file.writePixels(kHeight);
    }
    const Image image = read_exr(path_);
    ASSERT_EQ(image.channels, has_alpha ? (Names{"R", "G", "B", "A"}) : (Names{"R", "G", "B"}));
    ASSERT_EQ(image.width, kWidth);
    ASSERT_EQ(image.height, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          // The chroma filter reaches beyond the border.
          ASSERT_NEAR(image.at(x, y, c), color(x, y)[c], 0.02f) << x << " " << y << " " << c;
        }
        if (has_alpha) {
          ASSERT_EQ(image.at(x, y, 3), 0.25f);
        }
      }
    }
  }
}

}  // namespace
}  // namespace kinome::test::exr_colors_test
