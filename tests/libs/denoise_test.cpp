// Tests of denoising with denoisers that the tests define: the combination with the noisy image,
// the channels of the result, and the film's filter. tests/apps/cli/commands/denoise_test.py loads
// libraries.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "kinome/denoise.h"
#include "kinome/error.h"
#include "kinome/math.h"
#include "support/film_xml.h"

namespace kinome::test::denoise_test {
namespace {

constexpr int kSide = 64;
constexpr int kLanes = 4;

/// An image with independent noise, and its variance as estimated from kLanes lanes.
struct NoisyPicture {
  std::vector<float> noisy, variance;
};

/// `samples` are averaged in each lane. A sample's standard deviation is the true value.
NoisyPicture add_noise(const std::vector<float>& truth, int samples, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  NoisyPicture picture;
  for (const float value : truth) {
    double sum = 0, squares = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      const double mean = value * (1 + normal(random) / std::sqrt(samples));
      sum += mean;
      squares += mean * mean;
    }
    const double mean = sum / kLanes;
    picture.noisy.push_back(static_cast<float>(mean));
    picture.variance.push_back(static_cast<float>((squares / kLanes - mean * mean) / (kLanes - 1)));
  }
  return picture;
}

/// Stripes that are one pixel wide, on a slope of brightness.
std::vector<float> stripes() {
  std::vector<float> image;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (int c = 0; c < 3; ++c) {
        image.push_back((0.5f + static_cast<float>(y) / kSide) * (x % 2 == 0 ? 1.f : 0.7f));
      }
    }
  }
  return image;
}

/// Denoises by the mean over (2 radius + 1)² pixels.
std::vector<float> blurred(const std::vector<float>& image, int radius) {
  std::vector<float> result;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        int count = 0;
        for (int v = std::max(y - radius, 0); v <= std::min(y + radius, kSide - 1); ++v) {
          for (int u = std::max(x - radius, 0); u <= std::min(x + radius, kSide - 1);
               ++u, ++count) {
            sum += image[static_cast<size_t>(3 * (v * kSide + u) + c)];
          }
        }
        result.push_back(static_cast<float>(sum / count));
      }
    }
  }
  return result;
}

double mean_square(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(double{a[i]} - b[i], 2);
  return sum / static_cast<double>(a.size());
}

/// The seeds are fixed. Over other seeds, each mean square varies by about 1.3 % (sqrt(2 / 12288)),
/// which is far less than the tolerances.
TEST(Denoise, TheCombinationIsHardlyWorseThanTheBetterImage) {
  const std::vector<float> truth = stripes();
  for (const int samples : {1, 4, 16, 64, 256, 1024, 4096}) {
    const NoisyPicture picture = add_noise(truth, samples, 7);
    const std::vector<float> denoised = blurred(picture.noisy, 2);
    const auto combined =
        combine_with_noisy(picture.noisy, picture.variance, denoised, kSide, kSide);
    const double best = std::min(mean_square(picture.noisy, truth), mean_square(denoised, truth));
    EXPECT_LT(mean_square(combined, truth), 1.15 * best) << samples;
  }
}

/// The bias of the denoised image is about 0.15² here, however many samples there are. The error of
/// the combination approaches that of the noisy image.
TEST(Denoise, TheCombinationConvergesToTheExpectationOfTheNoisyImage) {
  const std::vector<float> truth = stripes();
  for (const int samples : {1 << 12, 1 << 16, 1 << 20}) {
    const NoisyPicture picture = add_noise(truth, samples, 11);
    const auto combined = combine_with_noisy(picture.noisy, picture.variance,
                                             blurred(picture.noisy, 2), kSide, kSide);
    EXPECT_LT(mean_square(combined, truth), 1.1 * mean_square(picture.noisy, truth)) << samples;
  }
}

/// Where the denoised image has no bias, it is kept, except for the noise of the estimated bias.
TEST(Denoise, TheCombinationKeepsAnUnbiasedImage) {
  const std::vector<float> truth = stripes();
  const NoisyPicture picture = add_noise(truth, 4, 3);
  const auto combined = combine_with_noisy(picture.noisy, picture.variance, truth, kSide, kSide);
  EXPECT_LT(mean_square(combined, truth), 0.02 * mean_square(picture.noisy, truth));
}

/// A sample that is a thousand times as bright as all others raises its pixel's variance, too: the
/// variance of a mean of which one lane has all light is its square.
TEST(Denoise, ABrightSampleDoesNotReturn) {
  const std::vector<float> truth = stripes();
  NoisyPicture picture = add_noise(truth, 64, 5);
  const size_t at = static_cast<size_t>(3 * (30 * kSide + 30));
  for (size_t i = at; i < at + 3; ++i) {
    picture.noisy[i] = 1000;
    picture.variance[i] = 1e6f;
  }
  const auto combined =
      combine_with_noisy(picture.noisy, picture.variance, blurred(truth, 2), kSide, kSide);
  for (size_t i = at; i < at + 3; ++i) EXPECT_LT(combined[i], truth[i] + 0.5f);
  for (const float value : combined) EXPECT_LT(value, 2.5f);
}

/// Pixels of unknown variance are those of the denoised image, and so are black images.
TEST(Denoise, TheCombinationNeedsAVariance) {
  const std::vector<float> truth = stripes();
  const NoisyPicture picture = add_noise(truth, 4, 3);
  const std::vector<float> unknown(truth.size(), kInfinity), black(truth.size(), 0.f);
  EXPECT_EQ(combine_with_noisy(picture.noisy, unknown, truth, kSide, kSide), truth);
  EXPECT_EQ(combine_with_noisy(black, black, black, kSide, kSide), black);
}

/// They have no influence on other pixels.
TEST(Denoise, TheCombinationSkipsPixelsThatAreNotFinite) {
  const std::vector<float> truth = stripes(), denoised = blurred(truth, 2);
  const NoisyPicture picture = add_noise(truth, 4096, 3);
  const size_t at = static_cast<size_t>(3 * (30 * kSide + 30));
  std::vector<float> broken = picture.noisy, unknown = picture.variance;
  unknown[at] = kInfinity;
  for (const float value : {kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    broken[at] = value;
    EXPECT_EQ(combine_with_noisy(broken, picture.variance, denoised, kSide, kSide),
              combine_with_noisy(picture.noisy, unknown, denoised, kSide, kSide));
  }
}

/// The discrete filter has the film's weights at whole pixels, normalised, also at the edges.
TEST(Denoise, FiltersPixelsByTheFilmsFilter) {
  const auto film = make_film(film_size(9, 9) + R"(<rfilter type="tent"><float name="radius"
      value="2"/></rfilter>)");
  const std::vector<float> weights = filter_weights(film->filter());
  ASSERT_EQ(weights.size(), 2u);
  EXPECT_FLOAT_EQ(weights[1] / weights[0], 0.5f);
  Image image{9, 9, {"R", "variance.R"}, std::vector<float>(162, 1.f)};
  image.at(4, 4, 0) = 17;
  image.at(4, 4, 1) = 17;
  Image same = image;
  filter_pixels(same, std::vector{1.f});
  EXPECT_EQ(same.data, image.data);
  filter_pixels(image, weights);
  EXPECT_FLOAT_EQ(image.at(4, 4, 0), 1 + 16 / 4.f);
  EXPECT_FLOAT_EQ(image.at(3, 4, 0), 1 + 16 / 8.f);
  EXPECT_FLOAT_EQ(image.at(5, 5, 0), 1 + 16 / 16.f);
  EXPECT_FLOAT_EQ(image.at(2, 4, 0), 1);
  EXPECT_FLOAT_EQ(image.at(0, 0, 0), 1);
  EXPECT_EQ(image.at(4, 4, 1), 17);
}

/// An image of two pixels with the channels of a scene for denoising, whose own integrator has a
/// channel `depth.T`.
Image two_pixels(const std::vector<std::string>& color) {
  Image image{2, 1, color, {}};
  for (const char* name : {"_noisy.R", "_noisy.G", "_noisy.B", "_noisy.A", "_noisy.depth.T",
                           "_guide_albedo.R", "_guide_albedo.G", "_guide_albedo.B",
                           "_guide_normal.X", "_guide_normal.Y", "_guide_normal.Z"}) {
    image.channels.emplace_back(name);
  }
  for (size_t i = 0; i < 2 * image.channels.size(); ++i) {
    image.data.push_back(static_cast<float>(i) / 64);
  }
  return image;
}

std::vector<float> doubled(const DenoiserInput& input) {
  std::vector<float> result = input.color;
  for (float& value : result) value *= 2;
  return result;
}

TEST(Denoise, TheResultHasTheScenesChannelsAndTheOtherColour) {
  const Image image = two_pixels({"R", "G", "B", "A"});
  DenoiserInput seen;
  const Denoiser denoiser = [&seen](const DenoiserInput& input) {
    seen = input;
    return doubled(input);
  };
  const Image denoised = denoise_image(image, denoiser, {});
  EXPECT_EQ(denoised.channels, (std::vector<std::string>{"R", "G", "B", "A", "depth.T", "noisy.R",
                                                         "noisy.G", "noisy.B"}));
  EXPECT_EQ(seen.width, 2);
  EXPECT_EQ(seen.height, 1);
  ASSERT_EQ(seen.albedo.size(), 6u);
  EXPECT_EQ(seen.albedo[4], image.at(1, 0, image.find_channel("_guide_albedo.G")));
  EXPECT_EQ(seen.normal[2], image.at(0, 0, image.find_channel("_guide_normal.Z")));
  for (int x = 0; x < 2; ++x) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(denoised.at(x, 0, c), 2 * image.at(x, 0, c));
      EXPECT_EQ(denoised.at(x, 0, 5 + c), image.at(x, 0, c));
    }
    EXPECT_EQ(denoised.at(x, 0, 3), image.at(x, 0, 3));
    EXPECT_EQ(denoised.at(x, 0, 4), image.at(x, 0, image.find_channel("_noisy.depth.T")));
  }
  const Image layer = denoise_image(image, denoiser, {.as_layer = true});
  EXPECT_EQ(layer.channels.back(), "denoised.B");
  EXPECT_EQ(layer.at(1, 0, 0), image.at(1, 0, 0));
  EXPECT_EQ(layer.at(1, 0, 5), 2 * image.at(1, 0, 0));
}

TEST(Denoise, DenoisesLuminance) {
  const Image image = two_pixels({"Y"});
  const Image denoised = denoise_image(image, doubled, {});
  EXPECT_EQ(denoised.channels, (std::vector<std::string>{"Y", "depth.T", "noisy.Y"}));
  EXPECT_NEAR(denoised.at(1, 0, 0), 2 * image.at(1, 0, 0), 1e-6);
  EXPECT_NEAR(denoised.at(1, 0, 2), image.at(1, 0, 0), 1e-6);
}

/// With variances, the denoised colour is the combined one. Channels of the variance are kept on
/// request.
TEST(Denoise, UsesTheVariance) {
  Image image = two_pixels({"R", "G", "B"});
  const size_t before = image.channels.size();
  for (const char* name : {"variance.R", "variance.G", "variance.B", "tile_variance.R"}) {
    image.channels.emplace_back(name);
  }
  std::vector<float> data;
  for (size_t p = 0; p < 2; ++p) {
    data.insert(data.end(), &image.data[p * before], &image.data[p * before] + before);
    data.insert(data.end(), 4, 0.f);  // no noise: the denoised image is biased
  }
  image.data = std::move(data);
  const Image denoised = denoise_image(image, doubled, {});
  EXPECT_EQ(denoised.find_channel("variance.R"), -1);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(denoised.at(1, 0, c), image.at(1, 0, c), 1e-6);
  const Image kept = denoise_image(image, doubled, {.keeps_variance = true});
  EXPECT_NE(kept.find_channel("tile_variance.R"), -1);
}

TEST(Denoise, NeedsTheGuides) {
  const Image image{1, 1, {"R", "G", "B"}, {1, 1, 1}};
  try {
    denoise_image(image, doubled, {});
    FAIL() << "an image without guides was denoised";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("'_guide_albedo.R'"), std::string::npos);
  }
}

}  // namespace
}  // namespace kinome::test::denoise_test
