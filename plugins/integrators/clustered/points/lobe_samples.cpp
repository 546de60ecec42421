#include "clustered/points/lobe_samples.h"

#include <algorithm>

#include "kinome/wide/surface_point.h"

namespace kinome {

using namespace wide;

namespace {

/// Maximum number of directions in one call of a BSDF, unless a single point has more.
constexpr size_t kCapacity = 2048;

}  // namespace

LobeSamples::LobeSamples(const Sampler& sampler)
    : sampler_(sampler),
      count_(sampler.sample_count()),
      arena_(std::max(kCapacity, count_)),
      points_(arena_),
      u1_(arena_.floats()),
      u2_(arena_.two()),
      answer_(transport::make_answer(arena_)),
      // Whole vectors are written, even behind the last directions.
      found_arena_(arena_.capacity() + kBlockLanes),
      found_(found_arena_.three()) {}

void LobeSamples::clear() {
  points_.clear();
  list_.clear();
}

size_t LobeSamples::add(const LitPoints& points, size_t i, const Bsdf& bsdf) {
  const size_t first = points_.add(points.surfaces.points(), i, bsdf, count_);
  const SampleKey key = transport::key_of(points.samples, points.owner[i]);
  const auto count = static_cast<uint32_t>(count_);
  const PixelSamples samples{&key.x, &key.y, 1, key.sample * count, count, key.seed};
  sampler_.fill_2d_block(samples, points.dimension, u2_.from(first));
  sampler_.fill_1d_block(samples, points.dimension + 2, u1_ + first);
  list_.push_back({first, 0});
  return list_.size() - 1;
}

void LobeSamples::draw() {
  points_.shade({.u1 = u1_, .u2 = u2_, .lobes = Lobe::kGlossy}, answer_);
  const SurfaceBlock& points = points_.points();
  for (Point& point : list_) {
    point.found = 0;
    for (size_t k = 0; k < count_; k += kLanes) {
      const size_t i = point.first + k;
      const wide::Vec3 d = frame_at(points, i).to_world(wide::Vec3::load(answer_.wo, i));
      const Mask is_sample = first_lanes(std::min(count_ - k, kLanes)) &&
                             Float::load(answer_.sample_pdf + i) > 0.f;
      const size_t to = point.first + point.found;
      store_selected(is_sample, d.x, found_.x + to);
      store_selected(is_sample, d.y, found_.y + to);
      point.found += store_selected(is_sample, d.z, found_.z + to);
    }
  }
}

LobeDirections LobeSamples::directions(size_t number) const {
  const Point& point = list_[number];
  const Columns3 from = found_.from(point.first);
  return {from.x, from.y, from.z, point.found};
}

}  // namespace kinome
