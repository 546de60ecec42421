/// Evaluation and sampling of a SphericalMap, for single directions and for columns of them. The
/// number type F is float or wide::Float. For columns, memory is prefetched while other directions
/// are processed.

#include <array>
#include <cmath>
#include <cstring>

#include "cell_search.h"
#include "kinome/wide/functions.h"
#include "spherical_map.h"

namespace kinome {
namespace {

using namespace wide::formulas;
using wide::Float;
using wide::Int;
using wide::kLanes;

/// atan2 by the polynomial of Moshier's Cephes library (atanf). Its relative error is 2e-7, also
/// near 0; it takes a third of the time of std::atan2.
template <class F>
inline F fast_atan2(F y, F x) {
  const F ax = abs(x), ay = abs(y);
  const F large = max(max(ax, ay), F(std::numeric_limits<float>::min()));
  const F small = min(ax, ay);
  const MaskOf<F> is_reduced = small > 0.414213562f * large;  // tan(pi / 8)
  const F t =
      select(is_reduced, small - large, small) / select(is_reduced, small + large, large);
  const F z = t * t;
  const F p = polynomial(z, 8.05374449538e-2f, -1.38776856032e-1f, 1.99777106478e-1f,
                         -3.33329491539e-1f);
  F angle = select(is_reduced, F(kPi / 4)) + (p * z * t + t);
  angle = select(ay > ax, kPi / 2 - angle, angle);
  angle = select(x < 0.f, kPi - angle, angle);
  return copysign(angle, y);
}

/// Samples s in [0, 1] with a density proportional to a (1 - s) + b s.
template <class F>
inline F sample_line(F a, F b, F u) {
  // The root of (b - a) s² / 2 + a s = u (a + b) / 2 in its form without cancellation.
  const F root = sqrt(lerp(a * a, b * b, u));
  return select(a + root > 0.f, min(u * (a + b) / (a + root), F(1.f)), u);
}

/// Samples t in [0, 1] with a density proportional to (a (1 - t) + b t) (p (1 - t) + q t), where a,
/// b, p and q aren't negative. Uses bracketed Newton iterations, usually one or two.
template <class F>
struct ProductSample {
  ProductSample() = default;
  ProductSample(F a, F b, F p, F q, F u) {
    d0 = a * p;  // Bernstein coefficients
    const F d1 = 0.5f * (a * q + b * p), d2 = b * q;
    target = u * (d0 + d1 + d2) / 3.f;
    c2 = d1 - d0;
    c3 = (d0 - 2.f * d1 + d2) / 3.f;
    t = sample_line(d0, d2, u);  // exact if p = q
  }
  void step() {
    const F error = ((c3 * t + c2) * t + d0) * t - target;
    const MaskOf<F> is_exact = error == 0.f, is_above = error > 0.f;
    hi = select(is_above, t, hi);
    lo = select(is_above, lo, t);
    const F slope = (3.f * c3 * t + 2.f * c2) * t + d0;
    const F next = t - error / slope;
    const MaskOf<F> is_near = abs(next - t) <= 1e-6f * t;
    const MaskOf<F> is_inside = next > lo && next < hi;
    const F better =
        select(is_near, clamp(next, lo, hi), select(is_inside, next, 0.5f * (lo + hi)));
    t = select(is_found || is_exact, t, better);
    is_found = is_found || is_exact || is_near;
  }

  F t;
  MaskOf<F> is_found = false;

 private:
  F d0, c2, c3, target, lo = 0.f, hi = 1.f;
};

}  // namespace

template <class F>
SphericalMap::Place<F> SphericalMap::locate(const VecOf<F>& d) const {
  const F sin_theta = sqrt(d.x * d.x + d.z * d.z);
  const F theta = fast_atan2(sin_theta, d.y);
  const auto columns = static_cast<float>(width_);
  F x = fast_atan2(d.x, -d.z) * (0.5f * kInvPi) * columns - 0.5f;
  x = select(x < 0.f, x + columns, x);
  const auto rows = static_cast<float>(height_ - 1);
  const F y = theta * kInvPi * rows;
  // For NaN directions, s and t are NaN, and the indices stay inside the map: comparisons with NaN
  // are false. Converting NaN to int would be undefined.
  const auto whole = [](F value, float count) {
    const F last = select(value > 0.f, F(count - 1.f));
    return to_int(select(value >= 0.f && value < count, value, last));
  };
  const IntOf<F> column = whole(x, columns), row = whole(y, rows);
  return {row * (width_ + 1) + column, row, min(x - to_float(column), F(1.f)),
          min(y - to_float(row), F(1.f)), sin_theta};
}

template <class F>
F SphericalMap::sine_ratio(const Place<F>& at) const {
  // Near a pole, both sines are proportional to the angle to it, with an error of second order.
  const MaskOf<F> is_polar =
      at.sin_theta < 1e-3f && (at.row == 0 || at.row == height_ - 2);
  const F sine = lerp(gather(sines_.data(), at.row), gather(sines_.data() + 1, at.row), at.t);
  return select(is_polar, F(sines_[1] / row_angle_), sine / at.sin_theta);
}

template <class F, size_t n>
void SphericalMap::draw(const IntOf<F> (&row_index)[n], const IntOf<F> (&column)[n],
                        const Vec2Of<F> (&u)[n], Drawn<F> (&drawn)[n]) const {
  constexpr int kMaxSteps = 32;
  const float* const weights = &texels_[0].weight;
  const int stride = 4 * (width_ + 1);
  F top_left[n], top_right[n], bottom_left[n], bottom_right[n];
  ProductSample<F> product[n];
  for (size_t i = 0; i < n; ++i) {
    const IntOf<F> top = (row_index[i] * (width_ + 1) + column[i]) * 4;
    top_left[i] = gather(weights, top), top_right[i] = gather(weights + 4, top);
    bottom_left[i] = gather(weights + stride, top);
    bottom_right[i] = gather(weights + stride + 4, top);
    product[i] = {top_left[i] + top_right[i], bottom_left[i] + bottom_right[i],
                  gather(sines_.data(), row_index[i]), gather(sines_.data() + 1, row_index[i]),
                  u[i].y};
  }
  MaskOf<F> is_found = false;
  for (int k = 0; k < kMaxSteps && !all(is_found); ++k) {
    is_found = true;
    for (ProductSample<F>& one : product) {
      one.step();
      is_found = is_found && one.is_found;
    }
  }
  for (size_t i = 0; i < n; ++i) {
    const F t = product[i].t;
    drawn[i] = finish_draw<F>(row_index[i], column[i], lerp(top_left[i], bottom_left[i], t),
                              lerp(top_right[i], bottom_right[i], t), u[i].x, t);
  }
}

/// Completes a sample at t between the rows. `left` and `right` are the weights of the patch's
/// sides at t.
template <class F>
SphericalMap::Drawn<F> SphericalMap::finish_draw(IntOf<F> row_index, IntOf<F> column, F left,
                                                 F right, F u, F t) const {
  Drawn<F> drawn;
  drawn.place.row = row_index;
  drawn.place.texel = row_index * (width_ + 1) + column;
  const F s = sample_line(left, right, u);

  // Measured from the nearer pole, which keeps the relative precision of sin theta.
  const F i = to_float(row_index);
  const F from_north = (i + t) * row_angle_;
  const F from_south = (static_cast<float>(height_ - 2) - i + (1.f - t)) * row_angle_;
  F sin_theta, height, sin_phi, cos_phi;
  sincos(min(from_north, from_south), sin_theta, height);
  const F turned = to_float(column) + s + 0.5f;
  sincos(turned * (2 * kPi / static_cast<float>(width_)), sin_phi, cos_phi);
  height = select(from_north < from_south, height, -height);
  drawn.d = {sin_phi * sin_theta, height, -cos_phi * sin_theta};
  drawn.place.s = s;
  drawn.place.t = t;
  drawn.place.sin_theta = sin_theta;
  drawn.pdf = lerp(left, right, s) * sine_ratio(drawn.place);
  return drawn;
}

SphericalMap::Float4 SphericalMap::interpolate(size_t texel, float s, float t) const {
  static_assert(sizeof(Texel) == sizeof(Float4));
  const auto load = [](const Texel* from) {
    Float4 v;
    std::memcpy(&v, from, sizeof v);
    return v;
  };
  const Texel* const top = texels_.data() + texel;
  const Texel* const bottom = top + width_ + 1;
  const Float4 upper = load(top) * (1 - s) + load(top + 1) * s;
  const Float4 lower = load(bottom) * (1 - s) + load(bottom + 1) * s;
  return upper * (1 - t) + lower * t;
}

SphericalMap::Interpolated SphericalMap::interpolate_lanes(const uint32_t* texel, const float* s,
                                                           const float* t) const {
  // Lane by lane, because neighbours are adjacent in memory: four loads per lane instead of sixteen
  // gathers.
  alignas(64) float values[4 * kLanes];
  for (size_t i = 0; i < kLanes; ++i) {
    const Float4 value = interpolate(texel[i], s[i], t[i]);
    std::memcpy(values + 4 * i, &value, sizeof value);
  }
  Interpolated result;
  wide::load_rows(values, result.radiance.x, result.radiance.y, result.radiance.z, result.weight);
  return result;
}

void SphericalMap::prefetch(uint32_t texel) const {
  __builtin_prefetch(texels_.data() + texel);
  __builtin_prefetch(texels_.data() + texel + width_ + 1);
}

Rgb SphericalMap::eval(const Vec3& d) const {
  const auto at = locate<float>(d);
  const Float4 value = interpolate(static_cast<size_t>(at.texel), at.s, at.t);
  return {value[0], value[1], value[2]};
}

float SphericalMap::pdf(const Vec3& d) const {
  const auto at = locate<float>(d);
  return interpolate(static_cast<size_t>(at.texel), at.s, at.t)[3] * sine_ratio(at);
}

SphericalMap::Sample SphericalMap::sample_patch(const GridDistribution::Cell& patch) const {
  Drawn<float> one[1];
  draw<float>({static_cast<int>(patch.row)}, {static_cast<int>(patch.column)}, {patch.u}, one);
  const auto& [drawn] = one;
  const auto& at = drawn.place;
  const Float4 value = interpolate(static_cast<size_t>(at.texel), at.s, at.t);
  return {drawn.d, {value[0], value[1], value[2]}, drawn.pdf};
}

std::optional<SphericalMap::Sample> SphericalMap::sample(const Vec2& u) const {
  if (!(patches_.total() > 0)) return std::nullopt;
  const Sample sample = sample_patch(patches_.sample(u));
  return sample.pdf > 0 ? std::optional(sample) : std::nullopt;
}

void SphericalMap::eval_block(std::span<const Vec3> d, Rgb* radiance, float* pdf) const {
  std::array<Place<float>, kBlock> places;
  for (size_t i = 0; i < d.size(); ++i) {
    places[i] = locate<float>(d[i]);
    prefetch(static_cast<uint32_t>(places[i].texel));
  }
  for (size_t i = 0; i < d.size(); ++i) {
    const auto& at = places[i];
    const Float4 value = interpolate(static_cast<size_t>(at.texel), at.s, at.t);
    radiance[i] = {value[0], value[1], value[2]};
    if (pdf) pdf[i] = value[3] * sine_ratio(at);
  }
}

void SphericalMap::eval_places(std::span<const Vec2> places, Rgb* radiance) const {
  std::array<Place<float>, kBlock> found;
  for (size_t i = 0; i < places.size(); ++i) {
    const int column = std::clamp(static_cast<int>(places[i].x), 0, width_ - 1);
    const int row_index = std::clamp(static_cast<int>(places[i].y), 0, height_ - 2);
    found[i] = {row_index * (width_ + 1) + column, row_index,
                places[i].x - static_cast<float>(column),
                places[i].y - static_cast<float>(row_index), 0};
    prefetch(static_cast<uint32_t>(found[i].texel));
  }
  for (size_t i = 0; i < places.size(); ++i) {
    const Float4 value =
        interpolate(static_cast<size_t>(found[i].texel), found[i].s, found[i].t);
    radiance[i] = {value[0], value[1], value[2]};
  }
}

namespace {

/// Number of directions that pass through the stages together: few enough that intermediate values
/// and prefetched texels stay in the L1 cache.
constexpr size_t kStep = 256;

/// Column of intermediate values between stages.
template <class T>
struct alignas(64) StageColumn {
  std::array<T, kStep> values;
  T* at(size_t i) { return values.data() + i; }
};

}  // namespace

void SphericalMap::eval_columns(const glm::mat3& to_local, const Columns3& d, size_t count,
                                const Columns3& radiance, float* pdf) const {
  StageColumn<uint32_t> texel;
  StageColumn<float> s, t, ratio;
  for (size_t begin = 0; begin < count; begin += kStep) {
    const size_t length = std::min(kStep, count - begin);
    wide::for_lanes(length, [&](size_t i) {
      const auto at = locate<Float>(to_local * wide::Vec3::load(d, begin + i));
      at.texel.store(texel.at(i));
      at.s.store(s.at(i));
      at.t.store(t.at(i));
      if (pdf) sine_ratio(at).store(ratio.at(i));
      for (size_t lane = i; lane < i + kLanes; ++lane) prefetch(texel.values[lane]);
    });
    wide::for_lanes(length, [&](size_t i) {
      const auto value = interpolate_lanes(texel.at(i), s.at(i), t.at(i));
      value.radiance.store(radiance, begin + i);
      if (pdf) (value.weight * Float::load(ratio.at(i))).store(pdf + begin + i);
    });
  }
}

void SphericalMap::sample_columns(const glm::mat3& to_world, const Columns2& u, size_t count,
                                  const DirectBlock& out) const {
  wide::for_lanes(count, [&](size_t i) {
    Float(kInfinity).store(out.distance + i);
    Float(0.f).store(out.is_delta + i);
    Float(0.f).store(out.pdf + i);
  });
  if (!(patches_.total() > 0)) return;
  const GridDistribution::Tables tables = patches_.tables();
  const auto columns = static_cast<int>(tables.columns);
  const auto row_buckets = static_cast<float>(tables.row_guide_size);
  const auto buckets = static_cast<int>(tables.column_guide_size);
  StageColumn<uint32_t> row, texel, found;  // found: index that the next stage reads
  StageColumn<float> x, y;
  CellSearch<kStep> search;
  for (size_t begin = 0; begin < count; begin += kStep) {
    const size_t length = std::min(kStep, count - begin);
    const auto fetch = [&](const auto* table, const uint32_t* places) {
      for (size_t lane = 0; lane < kLanes; ++lane) __builtin_prefetch(table + places[lane]);
    };
    wide::for_lanes(length, [&](size_t i) {
      unit_number(Float::load(u.x + begin + i)).store(x.at(i));
      const Float uy = unit_number(Float::load(u.y + begin + i));
      uy.store(y.at(i));
      search.add(i, wide::cells_at(0, tables.row_guide, to_int(uy * row_buckets)), uy);
    });
    search.run(tables.row_cdf);
    wide::for_lanes(length, [&](size_t i) {
      Float uy = Float::load(y.at(i));
      const Int in_row = wide::enter_cell(tables.row_cdf, 0, Int::load(search.found() + i), uy);
      in_row.store(row.at(i));
      uy.store(y.at(i));
      const Int bucket = to_int(Float::load(x.at(i)) * static_cast<float>(buckets));
      (in_row * (buckets + 1) + bucket).store(found.at(i));
      fetch(tables.column_guide, found.at(i));
    });
    wide::for_lanes(length, [&](size_t i) {
      const Int cdf_first = Int::load(row.at(i)) * columns;
      search.add(i, wide::cells_at(cdf_first, tables.column_guide, Int::load(found.at(i))),
                 Float::load(x.at(i)));
      fetch(tables.column_cdf, search.found() + i);
    });
    search.run(tables.column_cdf);
    wide::for_lanes(length, [&](size_t i) {
      const Int in_row = Int::load(row.at(i));
      Float ux = Float::load(x.at(i));
      const Int column =
          wide::enter_cell(tables.column_cdf, in_row * columns, Int::load(search.found() + i), ux);
      column.store(found.at(i));
      ux.store(x.at(i));
      (in_row * (width_ + 1) + column).store(texel.at(i));
      for (size_t lane = i; lane < i + kLanes; ++lane) prefetch(texel.values[lane]);
    });
    for (size_t first = 0; first < length; first += 2 * kLanes) {
      // An odd last vector is processed twice.
      const size_t i[2] = {first, first + kLanes < length ? first + kLanes : first};
      Drawn<Float> drawn[2];
      draw<Float>({Int::load(row.at(i[0])), Int::load(row.at(i[1]))},
                  {Int::load(found.at(i[0])), Int::load(found.at(i[1]))},
                  {{Float::load(x.at(i[0])), Float::load(y.at(i[0]))},
                   {Float::load(x.at(i[1])), Float::load(y.at(i[1]))}},
                  drawn);
      for (size_t k = 0; k < 2; ++k) {
        const auto& at = drawn[k].place;
        at.s.store(x.at(i[k]));
        at.t.store(y.at(i[k]));
        (to_world * drawn[k].d).store(out.d, begin + i[k]);
        drawn[k].pdf.store(out.pdf + begin + i[k]);
        interpolate_lanes(texel.at(i[k]), x.at(i[k]), y.at(i[k]))
            .radiance.store(out.radiance, begin + i[k]);
      }
    }
  }
}

}  // namespace kinome
