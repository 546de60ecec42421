// Tests of the parameters of films and of the files that they write.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "support/film_xml.h"
#include "kinome/image_files.h"
#include "kinome/error.h"
#include "kinome/film.h"
#include "kinome/texture.h"

namespace kinome::test::film_parameters_test {
namespace {

void expect_error(const std::string& body, const std::string& part) {
  try {
    make_film(body);
    ADD_FAILURE() << "no error for " << body;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    EXPECT_NE(e.where().line, 0) << e.what();
  }
}

TEST(Film, RefusesInvalidParameters) {
  expect_error("<integer name=\"width\" value=\"0\"/>", "width");
  expect_error("<integer name=\"width\" value=\"-5\"/>", "width");
  expect_error("<integer name=\"height\" value=\"99999999999\"/>", "height");
  expect_error("<integer name=\"crop_offset_x\" value=\"5\"/>", "crop window");
  expect_error("<integer name=\"crop_offset_y\" value=\"-1\"/>", "crop window");
  expect_error("<integer name=\"crop_width\" value=\"0\"/>", "crop_width");
  expect_error("<integer name=\"crop_offset_x\" value=\"9223372036854775807\"/>", "crop window");
  expect_error(text("pixel_format", "yuv"), "luminance_alpha");
  expect_error(text("component_format", "uint8"), "float32");
  expect_error(text("file_format", "jpeg"), "openexr");
  for (const char* stddev : {"0", "0.129", "16.1"}) {
    expect_error("<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"" +
                     std::string(stddev) + "\"/></rfilter>",
                 "stddev");
  }
  for (const char* lobes : {"0", "-1", "33"}) {
    expect_error("<rfilter type=\"lanczos\"><integer name=\"lobes\" value=\"" + std::string(lobes) +
                     "\"/></rfilter>",
                 "lobes");
  }
  expect_error("<rfilter type=\"mitchell\"><float name=\"B\" value=\"2.1\"/></rfilter>", "B");
  for (const char* radius : {"-1", "0.5", "65"}) {
    expect_error("<rfilter type=\"tent\"><float name=\"radius\" value=\"" + std::string(radius) +
                     "\"/></rfilter>",
                 "radius");
  }
}

/// The number of pixels must fit into an int.
TEST(Film, RefusesMorePixelsThanItCanCount) {
  const std::string window =
      "<integer name=\"crop_width\" value=\"65536\"/><integer name=\"crop_height\" value=\"";
  expect_error(film_size(65536, 65536), "'width' makes the image too large: must have at most");
  expect_error(film_size(46341, 46341), "'width'");  // just beyond
  expect_error(film_size(32768, 65536), "'height'");
  expect_error(film_size(65536, 65536) + window + "32768\"/>", "'crop_width'");
  // No memory is allocated before rendering.
  EXPECT_EQ(make_film(film_size(46340, 46340))->crop().area(), 2147395600);
  const auto part = make_film(film_size(65536, 65536) + window + "32767\"/>");
  EXPECT_EQ(part->crop().area(), 65536 * 32767);
}

/// Films of other plugins may not check their size.
TEST(Film, RefusesToPrepareMorePixelsThanItCanCount) {
  class Vast : public Film {
   public:
    Vast() { crop_ = {0, 0, 1 << 16, 1 << 16}; }
    void write(const std::string&, const Image&, const ImageMetadata&) const override {}
    std::string file_extension() const override { return ".none"; }
  };
  try {
    Vast().prepare({{}});
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(error.message().find("65536 x 65536"), std::string::npos) << error.what();
  }
}

TEST(Film, DefaultsAreMitsubas) {
  const auto film = make_film("");
  EXPECT_EQ(film->width(), 768);
  EXPECT_EQ(film->height(), 576);
  EXPECT_EQ(film->filter().radius(), 2.f);
  EXPECT_FALSE(film->has_alpha());
  EXPECT_FALSE(film->sample_border());
  EXPECT_EQ(film->file_extension(), ".exr");
  EXPECT_EQ(make_film(text("pixel_format", "RGBA"))->has_alpha(), true);
}

TEST(Film, WritesInItsFormat) {
  const TemporaryFolder folder;
  const auto film = make_film(film_size(40, 30) + text("component_format", "float32") +
                              "<integer name=\"crop_offset_x\" value=\"7\"/>" +
                              "<integer name=\"crop_width\" value=\"11\"/>");
  film->prepare({{"albedo.R"}});
  Image image = film->develop();
  image.at(3, 2, 1) = 1.f / 3;
  film->write(folder.path("picture"), image, {{"note", "hello"}});
  ImageMetadata metadata;
  const Image back = read_exr(folder.path("picture.exr"), {}, &metadata);
  EXPECT_EQ(back.width, 11);
  EXPECT_EQ(back.channels, image.channels);
  EXPECT_EQ(back.data, image.data);
  EXPECT_EQ(metadata["note"], "hello");

  const auto pfm = make_film(film_size(5, 4) + text("file_format", "pfm"));
  pfm->prepare({{}});
  pfm->write(folder.path("picture"), pfm->develop(), {});
  EXPECT_EQ(read_pfm(folder.path("picture.pfm")).width, 5);
}

/// Writes a film of 16 x 2 pixels of one colour, and reads it with `read`.
template <class Read>
auto written(const std::string& formats, const Rgb& color, const Read& read) {
  const TemporaryFolder folder;
  const auto film = make_film(film_size(16, 2) + formats + "<rfilter type=\"box\"/>");
  film->prepare({{}});
  FilmTile tile = film->make_tile(film->crop());
  const float values[] = {color.x, color.y, color.z, 0.25f};
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 16; ++x) {
      tile.add_pixel(x, y, {values, static_cast<size_t>(film->value_count(0))});
    }
  }
  film->commit(tile);
  film->write(folder.path("picture"), film->develop(), {});
  return read(folder.path("picture") + film->file_extension());
}

/// Values that Mitsuba 3.9.1 writes for (0.2, 0.5, 0.8).
TEST(Film, WritesXyzAsMitsubaDoes) {
  const std::map<std::string, float> expected{
      {"X", .40561903f}, {"Y", .4578494f}, {"Z", .8236449f}, {"A", .25f}};
  // Uses OpenEXR directly, because read_exr() converts XYZ to RGB.
  const auto read = [&expected](const std::string& path) {
    Imf::InputFile file(path.c_str());
    Imf::FrameBuffer buffer;
    std::map<std::string, std::array<float, 32>> channels;
    for (const auto& [name, value] : expected) {
      EXPECT_NE(file.header().channels().findChannel(name), nullptr) << name;
      buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(channels[name].data()),
                                     sizeof(float), 16 * sizeof(float)));
    }
    file.setFrameBuffer(buffer);
    file.readPixels(0, 1);
    return channels;
  };
  const auto channels = written(text("pixel_format", "xyza") + text("component_format", "float32"),
                                Rgb(.2f, .5f, .8f), read);
  for (const auto& [name, value] : expected) {
    EXPECT_NEAR(channels.at(name)[16 + 3], value, 2e-6f) << name;
  }
}

TEST(Film, WritesIntegersOfWhichTheLargestIsOne) {
  const auto read = [](const std::string& path) {
    // Integers are not normalised when they are read.
    return read_exr(path).at(5, 1, 0);
  };
  const std::string format = text("component_format", "uint32");
  EXPECT_NEAR(written(format, Rgb(.25f), read), 0x1p30f, 0x1p10f);
  EXPECT_NEAR(written(format, Rgb(2.f), read), 0x1p32f, 0x1p10f);
  EXPECT_EQ(written(format, Rgb(-1.f), read), 0.f);
  EXPECT_EQ(written(format, Rgb(0.f), read), 0.f);
}

/// Read by the `bitmap` texture.
TEST(Film, WritesRgbeAsMitsubaDoes) {
  const auto read = [](const std::string& path) {
    const auto bitmap = make<Texture>("<texture type=\"bitmap\">" + text("filename", path.c_str()) +
                                      text("filter_type", "nearest") + "</texture>");
    return bitmap->eval(Vec2(.3f, .7f));
  };
  const std::string format = text("file_format", "rgbe");
  EXPECT_EQ(written(format, Rgb(.2f, .5f, .8f), read), Rgb(.19921875f, .5f, .796875f));
  EXPECT_EQ(written(format, Rgb(0.f), read), Rgb(0.f));
  EXPECT_EQ(written(format, Rgb(3000, -5, 1), read), Rgb(2992, 0, 0));
  EXPECT_EQ(make_film(format)->file_extension(), ".rgbe");
  // Pixel formats that such files don't support become rgb.
  EXPECT_FALSE(make_film(format + text("pixel_format", "luminance_alpha"))->has_alpha());
  EXPECT_EQ(make_film(format + text("pixel_format", "luminance"))->channels().size(), 3u);
  EXPECT_EQ(make_film(text("file_format", "pfm") + text("pixel_format", "luminance"))->channels(),
            std::vector<std::string>{"Y"});
}

}  // namespace
}  // namespace kinome::test::film_parameters_test
