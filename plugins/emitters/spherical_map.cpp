#include "spherical_map.h"

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

namespace kinome {
namespace {

constexpr double kPiD = std::numbers::pi;

/// A map of fewer rows is refined, which leaves its interpolation as it is.
constexpr int kMinRows = 33;

/// What compensation leaves of a texel's weight: no density is zero where there is light, so that
/// estimates without BSDF sampling stay unbiased, too.
constexpr float kCompensationFloor = 1 / 16.f;

/// Of a texel that is not black, however dim beside the brightest: far enough from denormals for
/// what is interpolated from it not to vanish.
constexpr float kLeastDensity = 1e-30f;

/// The integral of sin theta, and of (theta - origin) sin theta, over [a, b].
struct SineMoments {
  double zeroth;
  double first;
};
SineMoments sine_moments(double a, double b, double origin) {
  const double zeroth = std::cos(a) - std::cos(b);
  const double theta = std::sin(b) - b * std::cos(b) - std::sin(a) + a * std::cos(a);
  return {zeroth, theta - origin * zeroth};
}

/// In the form that is positive where a and b are, however different they are.
inline float lerp(float a, float b, float t) {
  return a * (1 - t) + b * t;
}

/// atan2 by the polynomial of Moshier's Cephes library (atanf): within 2e-7 relative of the truth,
/// also near 0, and a third of the time of the standard one.
inline float fast_atan2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float large = std::max({ax, ay, std::numeric_limits<float>::min()});
  const float small = std::min(ax, ay);
  const bool is_reduced = small > 0.414213562f * large;  // tan(pi / 8)
  const float t = is_reduced ? (small - large) / (small + large) : small / large;
  const float z = t * t;
  const float p =
      ((8.05374449538e-2f * z - 1.38776856032e-1f) * z + 1.99777106478e-1f) * z - 3.33329491539e-1f;
  float angle = (is_reduced ? kPi / 4 : 0) + (p * z * t + t);
  angle = ay > ax ? kPi / 2 - angle : angle;
  angle = x < 0 ? kPi - angle : angle;
  return std::copysign(angle, y);
}

/// s in [0, 1] of density proportional to a (1 - s) + b s.
float sample_line(float a, float b, float u) {
  // The root of (b - a) s² / 2 + a s = u (a + b) / 2 in its form without cancellation.
  const float root = std::sqrt(lerp(a * a, b * b, u));
  return a + root > 0 ? std::min(u * (a + b) / (a + root), 1.f) : u;
}

/// t in [0, 1] of density proportional to (a (1 - t) + b t) (p (1 - t) + q t), none negative.
float sample_product(float a, float b, float p, float q, float u) {
  const float d0 = a * p, d1 = 0.5f * (a * q + b * p), d2 = b * q;  // Bernstein coefficients
  const float target = u * (d0 + d1 + d2) / 3;
  const float c2 = d1 - d0, c3 = (d0 - 2 * d1 + d2) / 3;
  float lo = 0, hi = 1;
  float t = sample_line(d0, d2, u);  // exact where p = q
  for (int i = 0; i < 32; ++i) {     // Newton, kept in a bracket: mostly one or two steps
    const float error = ((c3 * t + c2) * t + d0) * t - target;
    if (error == 0) return t;
    (error > 0 ? hi : lo) = t;
    const float slope = (3 * c3 * t + 2 * c2) * t + d0;
    float next = t - error / slope;
    if (std::abs(next - t) <= 1e-6f * t) return std::clamp(next, lo, hi);
    if (!(next > lo && next < hi)) next = 0.5f * (lo + hi);
    t = next;
  }
  return t;
}

}  // namespace

SphericalMap::SphericalMap(const Image& image, float scale, bool compensate) {
  fill(image, scale);
  set_weights(compensate);
}

void SphericalMap::fill(const Image& image, float scale) {
  width_ = image.width;
  const int gaps = std::max(1, image.height - 1);
  const int refine = (kMinRows - 1 + gaps - 1) / gaps;
  height_ = gaps * refine + 1;
  row_angle_ = static_cast<float>(kPiD / (height_ - 1));
  sines_.resize(height_);
  texels_.resize(static_cast<size_t>(height_) * (width_ + 1));
  const bool grey = image.channel_count() < 3;
  const auto read = [&](int x, int y) {
    return grey ? Rgb(image.at(x, y, 0))
                : Rgb(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
  };
  for (int i = 0; i < height_; ++i) {
    sines_[i] =
        i == 0 || i + 1 == height_ ? 0.f : static_cast<float>(std::sin(kPiD * i / (height_ - 1)));
    const int above = i / refine;
    const int below = std::min(above + 1, image.height - 1);
    const float t = static_cast<float>(i % refine) / static_cast<float>(refine);
    Texel* const out = texels_.data() + static_cast<size_t>(i) * (width_ + 1);
    for (int j = 0; j < width_; ++j) {
      const Rgb a = read(j, std::min(above, image.height - 1));
      out[j].radiance = scale * (t == 0 ? a : a * (1 - t) + read(j, below) * t);
    }
    out[width_].radiance = out[0].radiance;
  }
}

void SphericalMap::set_weights(bool compensate) {
  // The solid angle of the sphere that a row's texels stand for, from patches with interpolated
  // sines; then the integral of the absolute luminance.
  double total = 0, sphere = 0;
  std::vector<double> row_angles(height_);
  for (int i = 0; i < height_; ++i) {
    const double before = i > 0 ? sines_[i - 1] : 0, after = i + 1 < height_ ? sines_[i + 1] : 0;
    const double own = i == 0 || i + 1 == height_ ? 1 : 2;
    row_angles[i] = (own * sines_[i] / 3 + (before + after) / 6) * row_angle_ * 2 * kPiD / width_;
  }
  const auto sum_up = [&](auto&& weight) {
    total = 0;
    for (int i = 0; i < height_; ++i) {
      double sum = 0;
      Texel* const texel = texels_.data() + static_cast<size_t>(i) * (width_ + 1);
      for (int j = 0; j < width_; ++j) sum += texel[j].weight = weight(texel[j]);
      texel[width_].weight = texel[0].weight;
      total += sum * row_angles[i];
    }
  };
  sum_up([](const Texel& texel) { return luminance(glm::abs(texel.radiance)); });
  for (const double angle : row_angles) sphere += angle * width_;
  if (compensate) {
    const auto mean = static_cast<float>(total / sphere);
    sum_up([mean](const Texel& texel) {
      return std::max(texel.weight - mean, kCompensationFloor * texel.weight);
    });
  }
  if (!(total > 0)) return;  // black: every density is 0, and there is no patch to choose
  const double norm = 1 / total;
  sum_up([norm](const Texel& texel) {
    const auto density = static_cast<float>(texel.weight * norm);
    return texel.weight > 0 ? std::max(density, kLeastDensity) : 0.f;
  });

  std::vector<float> patches(static_cast<size_t>(width_) * (height_ - 1));
  for (int i = 0; i + 1 < height_; ++i) {
    const Texel* const top = row(i);
    const Texel* const bottom = row(i + 1);
    float* const out = patches.data() + static_cast<size_t>(i) * width_;
    const float top_share = sines_[i] / 3 + sines_[i + 1] / 6;
    const float bottom_share = sines_[i] / 6 + sines_[i + 1] / 3;
    for (int j = 0; j < width_; ++j) {
      out[j] = (top[j].weight + top[j + 1].weight) * top_share +
               (bottom[j].weight + bottom[j + 1].weight) * bottom_share;
    }
  }
  patches_ = GridDistribution(width_, height_ - 1, std::move(patches));
}

SphericalMap::Place SphericalMap::locate(const Vec3& d) const {
  const float sin_theta = std::sqrt(d.x * d.x + d.z * d.z);
  const float theta = fast_atan2(sin_theta, d.y);
  const auto columns = static_cast<float>(width_);
  float x = fast_atan2(d.x, -d.z) * (0.5f * kInvPi) * columns - 0.5f;
  if (x < 0) x += columns;
  const auto rows = static_cast<float>(height_ - 1);
  const float y = theta * kInvPi * rows;
  // A direction that is not a number stays one in s and t, and reads no memory but the map's: no
  // comparison holds for NaN, whose conversion to int is undefined.
  const int column = x >= 0 && x < columns ? static_cast<int>(x) : x > 0 ? width_ - 1 : 0;
  const int row_index = y >= 0 && y < rows ? static_cast<int>(y) : y > 0 ? height_ - 2 : 0;
  return {row(row_index) + column, row_index, std::min(x - static_cast<float>(column), 1.f),
          std::min(y - static_cast<float>(row_index), 1.f), sin_theta};
}

float SphericalMap::sine_ratio(int i, float t, float sin_theta) const {
  // Near a pole both are proportional to the angle to it (the error is of its square).
  if (sin_theta < 1e-3f && (i == 0 || i + 2 == height_)) return sines_[1] / row_angle_;
  return lerp(sines_[i], sines_[i + 1], t) / sin_theta;
}

Rgb SphericalMap::radiance_at(const Place& at) const {
  // Four floats at a time, the weight along with the colour.
  using Float4 = float __attribute__((vector_size(16)));
  static_assert(sizeof(Texel) == sizeof(Float4));
  const auto load = [](const Texel* texel) {
    Float4 v;
    std::memcpy(&v, texel, sizeof v);
    return v;
  };
  const Texel* const top = at.texel;
  const Texel* const bottom = at.texel + width_ + 1;
  const Float4 upper = load(top) * (1 - at.s) + load(top + 1) * at.s;
  const Float4 lower = load(bottom) * (1 - at.s) + load(bottom + 1) * at.s;
  const Float4 value = upper * (1 - at.t) + lower * at.t;
  return {value[0], value[1], value[2]};
}

float SphericalMap::pdf_at(const Place& at) const {
  const Texel* const top = at.texel;
  const Texel* const bottom = at.texel + width_ + 1;
  const float weight = lerp(lerp(top[0].weight, top[1].weight, at.s),
                            lerp(bottom[0].weight, bottom[1].weight, at.s), at.t);
  return weight * sine_ratio(at.row, at.t, at.sin_theta);
}

Rgb SphericalMap::eval(const Vec3& d) const {
  return radiance_at(locate(d));
}

float SphericalMap::pdf(const Vec3& d) const {
  return pdf_at(locate(d));
}

void SphericalMap::eval_block(std::span<const Vec3> d, Rgb* radiance, float* pdf) const {
  std::array<Place, kBlock> places;
  for (size_t i = 0; i < d.size(); ++i) {
    places[i] = locate(d[i]);
    __builtin_prefetch(places[i].texel);
    __builtin_prefetch(places[i].texel + width_ + 1);
  }
  for (size_t i = 0; i < d.size(); ++i) {
    radiance[i] = radiance_at(places[i]);
    if (pdf) pdf[i] = pdf_at(places[i]);
  }
}

void SphericalMap::eval_places(std::span<const Vec2> places, Rgb* radiance) const {
  std::array<Place, kBlock> found;
  for (size_t i = 0; i < places.size(); ++i) {
    const int column = std::clamp(static_cast<int>(places[i].x), 0, width_ - 1);
    const int row_index = std::clamp(static_cast<int>(places[i].y), 0, height_ - 2);
    found[i] = {row(row_index) + column, row_index, places[i].x - static_cast<float>(column),
                places[i].y - static_cast<float>(row_index), 0};
    __builtin_prefetch(found[i].texel);
    __builtin_prefetch(found[i].texel + width_ + 1);
  }
  for (size_t i = 0; i < places.size(); ++i) radiance[i] = radiance_at(found[i]);
}

void SphericalMap::copy_texels(int row_index, int first, std::span<Rgb> radiance) const {
  const Texel* const texels = row(row_index) + first;
  for (size_t i = 0; i < radiance.size(); ++i) radiance[i] = texels[i].radiance;
}

SphericalMap::Sample SphericalMap::sample_patch(const GridDistribution::Cell& patch) const {
  const auto i = static_cast<int>(patch.row);
  const Texel* const top = row(i) + patch.column;
  const Texel* const bottom = top + width_ + 1;
  const float t = sample_product(top[0].weight + top[1].weight, bottom[0].weight + bottom[1].weight,
                                 sines_[i], sines_[i + 1], patch.u.y);
  const float left = lerp(top[0].weight, bottom[0].weight, t);
  const float right = lerp(top[1].weight, bottom[1].weight, t);
  const float s = sample_line(left, right, patch.u.x);

  // From the nearer pole: there sin theta keeps its relative precision.
  const float from_north = (static_cast<float>(i) + t) * row_angle_;
  const float from_south = (static_cast<float>(height_ - 2 - i) + (1 - t)) * row_angle_;
  const bool is_north = from_north < from_south;
  const float from_pole = is_north ? from_north : from_south;
  const float sin_theta = std::sin(from_pole), height = std::cos(from_pole);
  const float phi = (static_cast<float>(patch.column) + s + 0.5f) * (2 * kPi / width_);
  Sample sample;
  sample.d =
      Vec3(std::sin(phi) * sin_theta, is_north ? height : -height, -std::cos(phi) * sin_theta);
  sample.radiance = radiance_at({top, i, s, t, sin_theta});
  sample.pdf = lerp(left, right, s) * sine_ratio(i, t, sin_theta);
  return sample;
}

std::optional<SphericalMap::Sample> SphericalMap::sample(const Vec2& u) const {
  if (!(patches_.total() > 0)) return std::nullopt;
  const Sample sample = sample_patch(patches_.sample(u));
  return sample.pdf > 0 ? std::optional(sample) : std::nullopt;
}

void SphericalMap::sample_block(std::span<const Vec2> u, Sample* samples) const {
  if (!(patches_.total() > 0)) {
    std::fill(samples, samples + u.size(), Sample{});
    return;
  }
  std::array<GridDistribution::Cell, kBlock> cells;
  for (size_t i = 0; i < u.size(); ++i) cells[i] = patches_.start(u[i]);
  for (size_t i = 0; i < u.size(); ++i) patches_.prefetch(cells[i]);
  for (size_t i = 0; i < u.size(); ++i) {
    patches_.finish(cells[i]);
    const Texel* const top = row(static_cast<int>(cells[i].row)) + cells[i].column;
    __builtin_prefetch(top);
    __builtin_prefetch(top + width_ + 1);
  }
  for (size_t i = 0; i < u.size(); ++i) samples[i] = sample_patch(cells[i]);
}

void SphericalMap::integrate_ring(double theta0, double theta1,
                                  std::vector<glm::vec4>& columns) const {
  const double angle = kPiD / (height_ - 1);
  const int first = std::clamp(static_cast<int>(theta0 / angle), 0, height_ - 2);
  const int last = std::clamp(static_cast<int>(theta1 / angle), 0, height_ - 2);
  std::fill(columns.begin(), columns.end(), glm::vec4(0.f));
  double carried = 0;  // what the strip above gives to this strip's upper row
  for (int i = first; i <= last + 1; ++i) {
    double share = carried;
    carried = 0;
    const double a = std::max(theta0, i * angle), b = std::min(theta1, (i + 1) * angle);
    if (i <= last && b > a) {
      const SineMoments moments = sine_moments(a, b, i * angle);
      carried = moments.first / angle;
      share += moments.zeroth - carried;
    }
    const auto factor = static_cast<float>(share);
    const Texel* const texels = row(i);
    for (int j = 0; j <= width_; ++j) {
      columns[j] += factor * glm::vec4(texels[j].radiance, texels[j].weight);
    }
  }
}

std::vector<Rgb> SphericalMap::integrate(const SpherePartition& cells) const {
  std::vector<Rgb> powers(cells.size());
  std::vector<glm::vec4> columns(width_ + 1);  // as texels are: four floats vectorise
  const double column_angle = 2 * kPiD / width_;
  double theta0 = 0;
  for (uint32_t ring = 0; ring < cells.ring_count(); ++ring) {
    const uint32_t first = cells.first_of_ring(ring), next = cells.first_of_ring(ring + 1);
    // 1 - cos theta = 2 sin²(theta / 2): precise at both poles.
    const double share = static_cast<double>(next) / cells.size();
    const double theta1 = next == cells.size() ? kPiD : 2 * std::asin(std::sqrt(share));
    integrate_ring(theta0, theta1, columns);
    theta0 = theta1;

    // Along phi the integrand is linear from column to column (column 0 at half a texel). A walk
    // over the borders of both, in units of columns and from half a column before column 0.
    int column = width_ - 1;
    double at = -0.5;  // place of the walk, and the next column after it
    double next_column = 0;
    for (uint32_t cell = first; cell < next; ++cell) {
      const double end = static_cast<double>(cell + 1 - first) * width_ / (next - first) - 0.5;
      std::array<double, 3> sum{};
      while (at < end) {
        const double stop = std::min(end, next_column);
        const double s = 0.5 * (at + stop) - (next_column - 1);
        const glm::vec4& a = columns[column];
        const glm::vec4& b = columns[column + 1];
        for (int c = 0; c < 3; ++c) sum[c] += (stop - at) * (a[c] + (b[c] - a[c]) * s);
        at = stop;
        if (stop == next_column) {
          next_column += 1;
          column = column + 1 == width_ ? 0 : column + 1;
        }
      }
      powers[cell] = Rgb(sum[0] * column_angle, sum[1] * column_angle, sum[2] * column_angle);
    }
  }
  return powers;
}

}  // namespace kinome
