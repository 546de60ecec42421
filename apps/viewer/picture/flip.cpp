#include "picture/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "picture/curves.h"

namespace kinome::viewer {
namespace {

/// CIE XYZ relative to the white of Rec.709, D65.
Vec3 relative_xyz(const Rgb& color) {
  static const glm::dvec3 white = xyz(glm::dvec3(1));
  return Vec3(xyz(glm::dvec3(color)) / white);
}

/// Converts to YCxCz, a linear opponent space with Y from -16 to 100.
Vec3 opponent(const Rgb& color) {
  const Vec3 v = relative_xyz(color);
  return {116 * v.y - 16, 500 * (v.x - v.y), 200 * (v.y - v.z)};
}
Rgb from_opponent(const Vec3& c) {
  static const glm::dmat3 to_rgb =
      glm::inverse(glm::dmat3(xyz({1, 0, 0}), xyz({0, 1, 0}), xyz({0, 0, 1})));
  static const glm::dvec3 white = xyz(glm::dvec3(1));
  const double y = (c.x + 16.) / 116;
  return Rgb(to_rgb * (glm::dvec3(y + c.y / 500., y, y - c.z / 200.) * white));
}

/// Converts to CIELAB, with a and b scaled by the lightness (Hunt effect).
Vec3 hunt_lab(const Rgb& color) {
  const Vec3 v = relative_xyz(color);
  Vec3 f;
  for (int i = 0; i < 3; ++i) {
    constexpr float kDelta = 6.f / 29;
    f[i] =
        v[i] > kDelta * kDelta * kDelta ? std::cbrt(v[i]) : v[i] / (3 * kDelta * kDelta) + 4.f / 29;
  }
  const float lightness = 116 * f.y - 16;
  return {lightness, 0.01f * lightness * 500 * (f.x - f.y), 0.01f * lightness * 200 * (f.y - f.z)};
}

/// HyAB, a distance for large colour differences.
float hyab(const Vec3& a, const Vec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// Weights of a one-dimensional filter, from -radius to radius.
using Taps = std::vector<float>;

/// One value per pixel.
using Plane = std::vector<float>;

Taps gaussian(float variance, int radius) {
  Taps taps;
  for (int i = -radius; i <= radius; ++i) {
    taps.push_back(std::exp(-static_cast<float>(i * i) / (2 * variance)));
  }
  return taps;
}
void scale(Taps& taps, float factor) {
  for (float& tap : taps) tap *= factor;
}
float sum(const Taps& taps) {
  return std::accumulate(taps.begin(), taps.end(), 0.f);
}
/// Scales the positive taps to a sum of 1, and the negative ones to -1.
void normalise_signs(Taps& taps) {
  float positive = 0, negative = 0;
  for (const float tap : taps) (tap > 0 ? positive : negative) += std::abs(tap);
  for (float& tap : taps) tap /= tap > 0 ? positive : negative;
}

/// Filters `in` along x, then along y, and adds the result to `out`.
class Convolution {
 public:
  Convolution(int width, int height) : width_(width), height_(height) {}

  void add(const Plane& in, const Taps& along_x, const Taps& along_y, Plane& out) {
    const int radius = static_cast<int>(along_x.size() / 2);
    rows_.assign(in.size(), 0);
    padded_.resize(static_cast<size_t>(width_) + 2 * radius);
    for (int y = 0; y < height_; ++y) {
      const float* row = in.data() + static_cast<size_t>(y) * width_;
      std::fill_n(padded_.begin(), radius, row[0]);
      std::copy_n(row, width_, padded_.begin() + radius);
      std::fill_n(padded_.begin() + radius + width_, radius, row[width_ - 1]);
      for (size_t i = 0; i < along_x.size(); ++i) {
        add_scaled(along_x[i], padded_.data() + i, rows_.data() + static_cast<size_t>(y) * width_);
      }
    }
    const int reach = static_cast<int>(along_y.size() / 2);
    for (int y = 0; y < height_; ++y) {
      for (int i = -reach; i <= reach; ++i) {
        const int from = std::clamp(y + i, 0, height_ - 1);
        add_scaled(along_y[i + reach], rows_.data() + static_cast<size_t>(from) * width_,
                   out.data() + static_cast<size_t>(y) * width_);
      }
    }
  }

 private:
  void add_scaled(float factor, const float* in, float* out) const {
    for (int x = 0; x < width_; ++x) out[x] += factor * in[x];
  }
  int width_, height_;
  Plane rows_, padded_;
};

/// Contrast sensitivity of one channel of YCxCz as a spatial filter: a sum of Gaussians
/// a sqrt(pi / b) exp(-pi² x² / b), x in degrees (table 1 of the paper).
struct Sensitivity {
  struct Term {
    float a, b;
  };
  std::array<Term, 2> terms;
};
constexpr std::array<Sensitivity, 3> kSensitivity{{{{{{1, 0.0047f}, {0, 1e-5f}}}},
                                                   {{{{1, 0.0053f}, {0, 1e-5f}}}},
                                                   {{{{34.1f, 0.04f}, {13.5f, 0.025f}}}}}};
/// Largest b of these terms, which determines the radius of the filters.
constexpr float kMaxB = 0.04f;

Plane filtered(const Plane& in, const Sensitivity& sensitivity, float pixels_per_degree,
               Convolution& convolution) {
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kMaxB / (2 * kPi * kPi)) * pixels_per_degree));
  std::vector<Taps> terms;
  float total = 0;
  for (const auto& [a, b] : sensitivity.terms) {
    if (a == 0) continue;
    const float variance = b / (2 * kPi * kPi) * pixels_per_degree * pixels_per_degree;
    Taps taps = gaussian(variance, radius);
    scale(taps, std::sqrt(a * std::sqrt(kPi / b)));  // once for each axis
    total += sum(taps) * sum(taps);
    terms.push_back(std::move(taps));
  }
  Plane out(in.size());
  for (Taps& taps : terms) {
    scale(taps, 1 / std::sqrt(total));
    convolution.add(in, taps, taps, out);
  }
  return out;
}

/// Returns the strength of edges or points: the first or second derivative of a Gaussian, with the
/// width of the features that the eye sees best.
Plane features(const Plane& in, bool edges, float pixels_per_degree, Convolution& convolution) {
  const float deviation = 0.5f * 0.082f * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  Taps smooth = gaussian(deviation * deviation, radius), derivative = smooth;
  for (int i = -radius; i <= radius; ++i) {
    const float x = static_cast<float>(i);
    derivative[i + radius] *= edges ? -x : x * x / (deviation * deviation) - 1;
  }
  scale(smooth, 1 / sum(smooth));
  normalise_signs(derivative);
  Plane along_x(in.size()), along_y(in.size());
  convolution.add(in, derivative, smooth, along_x);
  convolution.add(in, smooth, derivative, along_y);
  for (size_t i = 0; i < in.size(); ++i) along_x[i] = std::hypot(along_x[i], along_y[i]);
  return along_x;
}

/// Maps a colour difference to [0,1] (section 4.1.3 of the paper). Small differences get most of
/// the range.
float color_error(float difference) {
  constexpr float kPower = 0.7f, kKnee = 0.4f, kKneeError = 0.95f;
  static const float max_difference =
      std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kPower);
  const float error = std::pow(difference, kPower), knee = kKnee * max_difference;
  if (error < knee) return kKneeError / knee * error;
  return kKneeError + (error - knee) / (max_difference - knee) * (1 - kKneeError);
}

}  // namespace

struct Flip::Seen {
  int width, height;
  std::vector<Vec3> lab;
  Plane edges, points;
};

std::unique_ptr<const Flip::Seen> Flip::see(const LinearPicture& picture, float pixels_per_degree) {
  auto seen = std::make_unique<Seen>();
  seen->width = picture.width;
  seen->height = picture.height;
  const size_t count = picture.pixels.size();
  std::array<Plane, 3> planes;
  for (Plane& plane : planes) plane.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const Vec3 c = opponent(picture.pixels[i]);
    for (int k = 0; k < 3; ++k) planes[k][i] = c[k];
  }
  Convolution convolution(picture.width, picture.height);
  Plane luminance(count);
  for (size_t i = 0; i < count; ++i) luminance[i] = (planes[0][i] + 16) / 116;
  seen->edges = features(luminance, true, pixels_per_degree, convolution);
  seen->points = features(luminance, false, pixels_per_degree, convolution);
  for (int k = 0; k < 3; ++k) {
    planes[k] = filtered(planes[k], kSensitivity[k], pixels_per_degree, convolution);
  }
  seen->lab.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const Rgb color = from_opponent({planes[0][i], planes[1][i], planes[2][i]});
    seen->lab[i] = hunt_lab(glm::clamp(color, 0.f, 1.f));
  }
  return seen;
}

Flip::Flip(const LinearPicture& reference, float pixels_per_degree)
    : pixels_per_degree_(pixels_per_degree), reference_(see(reference, pixels_per_degree)) {}
Flip::~Flip() = default;

std::vector<float> Flip::differences(const LinearPicture& picture) const {
  const auto seen = see(picture, pixels_per_degree_);
  const Seen& reference = *reference_;
  std::vector<float> result(picture.pixels.size());
  for (size_t i = 0; i < result.size(); ++i) {
    const float color = color_error(hyab(reference.lab[i], seen->lab[i]));
    const float feature = std::max(std::abs(reference.edges[i] - seen->edges[i]),
                                   std::abs(reference.points[i] - seen->points[i]));
    const float feature_error = std::sqrt(feature / std::sqrt(2.f));
    result[i] = std::pow(color, 1 - feature_error);
  }
  return result;
}

Exposures flip_exposures(const LinearPicture& reference) {
  std::vector<float> values;
  values.reserve(reference.pixels.size());
  for (const Rgb& color : reference.pixels) values.push_back(luminance(color));
  if (values.empty()) return {0, 0, 2};
  const float brightest = *std::max_element(values.begin(), values.end());
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  float below = 0, above = 100;  // bisects for the value at which filmic() is 0.85
  for (int i = 0; i < 40; ++i) {
    const float x = 0.5f * (below + above);
    (filmic(x) < 0.85f ? below : above) = x;
  }
  constexpr float kMinLuminance = 1e-7f;
  const float first = std::log2(above / std::max(brightest, kMinLuminance));
  const float last = std::log2(above / std::max(*middle, kMinLuminance));
  return {first, last, std::max(2, static_cast<int>(std::ceil(last - first)))};
}

std::vector<float> hdr_flip(const LinearPicture& reference, const LinearPicture& picture,
                            float pixels_per_degree) {
  const Exposures exposures = flip_exposures(reference);
  const auto shown = [](const LinearPicture& radiance, float exposure) {
    LinearPicture made = radiance;
    for (Rgb& color : made.pixels) {
      for (int c = 0; c < 3; ++c) color[c] = filmic(std::max(color[c], 0.f) * std::exp2(exposure));
    }
    return made;
  };
  std::vector<float> result(picture.pixels.size());
  for (int i = 0; i < exposures.count; ++i) {
    const Flip flip(shown(reference, exposures.at(i)), pixels_per_degree);
    const auto differences = flip.differences(shown(picture, exposures.at(i)));
    for (size_t k = 0; k < result.size(); ++k) result[k] = std::max(result[k], differences[k]);
  }
  return result;
}

double mean_of(const std::vector<float>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.) / static_cast<double>(values.size());
}

}  // namespace kinome::viewer
