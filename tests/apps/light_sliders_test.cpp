// Tests the viewer's sliders of light groups: the image is the exact sum of the groups, times their
// factors.

#include <gtest/gtest.h>

#include "picture/light_sliders.h"

namespace kinome::viewer::light_sliders_test {
namespace {

/// Image whose values are multiples of 1/8, so that the sums below are exact.
Image grouped_image() {
  Image image{3, 2, {"R", "G", "B", "A"}, {}};
  for (const char* const group : {"sun", "lamps"}) {
    for (const char* const letter : {".R", ".G", ".B"}) {
      image.channels.push_back(std::string("lights.") + group + letter);
    }
  }
  for (int pixel = 0; pixel < 6; ++pixel) {
    float groups[6];
    for (int i = 0; i < 6; ++i) groups[i] = 0.125f * static_cast<float>(7 * pixel + 3 * i);
    image.data.insert(image.data.end(), {groups[0] + groups[3], groups[1] + groups[4],
                                         groups[2] + groups[5], 0.5f});
    image.data.insert(image.data.end(), std::begin(groups), std::end(groups));
  }
  return image;
}

TEST(LightSliders, ShowTheWeightedSumOfTheGroups) {
  const Image image = grouped_image();
  LightSliders sliders;
  EXPECT_FALSE(sliders.change(image));
  sliders.follow(image);
  ASSERT_EQ(sliders.groups().size(), 2u);
  EXPECT_EQ(sliders.groups()[0].name, "sun");
  EXPECT_EQ(sliders.groups()[1].name, "lamps");
  EXPECT_FALSE(sliders.change(image));
  sliders.groups()[0].intensity = 4;
  sliders.groups()[1] = {"lamps", 2, {0, 0.25f, 1}};
  ASSERT_TRUE(sliders.change(image));
  const Image relit = sliders.relit(image);
  EXPECT_EQ(relit.channels, image.channels);
  for (int i = 0; i < 6; ++i) {
    const int x = i % 3, y = i / 3;
    const float lamps[] = {0, 0.5f, 2};
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(relit.at(x, y, 4 + c), 4 * image.at(x, y, 4 + c));
      EXPECT_EQ(relit.at(x, y, 7 + c), lamps[c] * image.at(x, y, 7 + c));
      EXPECT_EQ(relit.at(x, y, c), 4 * image.at(x, y, 4 + c) + lamps[c] * image.at(x, y, 7 + c));
    }
    EXPECT_EQ(relit.at(x, y, 3), 0.5f);
  }
  sliders.reset();
  EXPECT_FALSE(sliders.change(image));
  EXPECT_EQ(sliders.relit(image).data, image.data);
}

TEST(LightSliders, KeepTheFactorsOfGroupsThatRemain) {
  const Image image = grouped_image();
  LightSliders sliders;
  sliders.follow(image);
  sliders.groups()[1].intensity = 3;
  const Image preview{1, 1, {"R", "G", "B"}, {1, 2, 3}};
  sliders.follow(preview);
  EXPECT_FALSE(sliders.change(preview));
  ASSERT_EQ(sliders.groups().size(), 2u);
  // Another scene has one of the groups, which is now the first.
  Image other{1, 1, {"R", "G", "B", "lights.lamps.R", "lights.lamps.G", "lights.lamps.B"}, {}};
  other.data = {1, 2, 4, 1, 2, 4};
  sliders.follow(other);
  ASSERT_EQ(sliders.groups().size(), 1u);
  EXPECT_EQ(sliders.relit(other).data, (std::vector<float>{3, 6, 12, 3, 6, 12}));
  // Back to the first image.
  sliders.follow(image);
  ASSERT_EQ(sliders.groups().size(), 2u);
  EXPECT_EQ(sliders.groups()[1].intensity, 3);
  // Groups without a colour can't be relit.
  const Image groups_alone{1, 1, {"lights.lamps.R", "lights.lamps.G", "lights.lamps.B"}, {1, 2, 4}};
  EXPECT_FALSE(sliders.change(groups_alone));
}

}  // namespace
}  // namespace kinome::viewer::light_sliders_test
