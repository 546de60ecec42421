// What a film may be, and how it is written.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "film_xml.h"
#include "kinome/error.h"
#include "kinome/film.h"

namespace kinome::test {
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

TEST(Film, RefusesWhatItCannotBe) {
  expect_error("<integer name=\"width\" value=\"0\"/>", "width");
  expect_error("<integer name=\"width\" value=\"-5\"/>", "width");
  expect_error("<integer name=\"height\" value=\"99999999999\"/>", "height");
  expect_error("<integer name=\"crop_offset_x\" value=\"5\"/>", "crop window");
  expect_error("<integer name=\"crop_offset_y\" value=\"-1\"/>", "crop window");
  expect_error("<integer name=\"crop_width\" value=\"0\"/>", "crop_width");
  expect_error("<integer name=\"crop_offset_x\" value=\"9223372036854775807\"/>", "crop window");
  expect_error(text("pixel_format", "xyz"), "luminance_alpha");
  expect_error(text("component_format", "uint32"), "float32");
  expect_error(text("file_format", "jpeg"), "openexr");
  for (const char* stddev : {"0", "0.129", "16.1"}) {
    expect_error("<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"" +
                     std::string(stddev) + "\"/></rfilter>",
                 "stddev");
  }
  for (const char* lobes : {"0", "-1", "33"}) {
    expect_error("<rfilter type=\"lanczos\"><integer name=\"lobes\" value=\"" +
                     std::string(lobes) + "\"/></rfilter>",
                 "lobes");
  }
  expect_error("<rfilter type=\"mitchell\"><float name=\"B\" value=\"2.1\"/></rfilter>", "B");
  for (const char* radius : {"-1", "0.5", "65"}) {
    expect_error("<rfilter type=\"tent\"><float name=\"radius\" value=\"" + std::string(radius) +
                     "\"/></rfilter>",
                 "radius");
  }
}

/// An int counts the pixels of a picture.
TEST(Film, RefusesMorePixelsThanItCanCount) {
  const std::string window =
      "<integer name=\"crop_width\" value=\"65536\"/><integer name=\"crop_height\" value=\"";
  expect_error(film_size(65536, 65536),
               "'width' makes the picture 65536 x 65536 pixels: no more than");
  expect_error(film_size(46341, 46341), "'width'");  // just beyond
  expect_error(film_size(32768, 65536), "'height'");
  expect_error(film_size(65536, 65536) + window + "32768\"/>", "'crop_width'");
  // No memory is taken before it is rendered.
  EXPECT_EQ(make_film(film_size(46340, 46340))->crop().area(), 2147395600);
  const auto part = make_film(film_size(65536, 65536) + window + "32767\"/>");
  EXPECT_EQ(part->crop().area(), 65536 * 32767);
}

/// Films of other plugins may not ask.
TEST(Film, PreparesNoMorePixelsThanItCanCount) {
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

}  // namespace
}  // namespace kinome::test
