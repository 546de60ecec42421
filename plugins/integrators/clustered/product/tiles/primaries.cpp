#include "clustered/product/tiles/primaries.h"

#include <algorithm>

#include "clustered/cells/hilbert_points.h"
#include "kinome/wide/owen.h"
#include "kinome/wide/surface_point.h"

namespace kinome {
namespace {

/// Number of rays that are traced at once. Their points fit a core's own cache, and there are
/// enough for full packets and blocks of each material.
constexpr size_t kRaysAtOnce = 2048;

Columns3 three(Column<float> (&columns)[3]) {
  return {columns[0].data(), columns[1].data(), columns[2].data()};
}

}  // namespace

Primaries::Primaries(const View& view)
    : view_(view), hides_environment_(transport::hides_environment(view.paths, view.scene.scene())) {
  make_room(kRaysAtOnce);
  clear();
}

void Primaries::make_room(size_t rays) {
  arena_.emplace(rays);
  camera_ = std::make_unique<transport::Camera>(view_.scene, view_.sensor, rays,
                                                view_.paths.hide_emitters);
  if (view_.sensor.film().has_alpha()) {
    coverage_.emplace(view_.scene, numbers_, view_.paths, rays);
    for (auto& column : key_) column = arena_->indices();
  }
  alpha_ = arena_->floats();
  position_ = arena_->two();
  aperture_ = arena_->two();
  emitted_ = arena_->three();
  point_ = arena_->of<int32_t>();
  const size_t points = padded(transport::Surfaces::max_points(view_.scene, rays));
  patch_.resize(points);
  kind_.resize(points);
  frames_.resize(points);
  microfacets_.resize(points);
  turned_.resize(points);
  for (auto& column : diffuse_) column.resize(points);
}

void Primaries::clear() {
  tiles_.clear();
  first_.assign(1, 0);
  kinds_.clear();
}

bool Primaries::add(const Rect& pixels, std::span<const uint16_t> counts) {
  size_t rays = 0;
  for (const uint16_t count : counts) rays += count;
  if (!tiles_.empty() && first_.back() + rays > kRaysAtOnce) return false;
  tiles_.push_back({pixels, first_.size() - 1, first_.back(), rays, 0, 0});
  for (const uint16_t count : counts) first_.push_back(first_.back() + count);
  return true;
}

void Primaries::place_pixel(int x, int y, size_t begin, size_t end, uint64_t seed) {
  const uint64_t key = hash_words(seed, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
  const bool has_aperture = view_.sensor.needs_aperture_sample();
  const uint64_t aperture_x = hash_words(key, 1), aperture_y = hash_words(key, 2);
  const auto count = static_cast<uint32_t>(end - begin);
  for (uint32_t first = 0; first < count; first += HilbertPoints::kMaxCount) {
    const uint32_t part = std::min(count - first, HilbertPoints::kMaxCount);
    const auto points = HilbertPoints::get().first(part);
    const uint64_t shift = hash_words(key, 3, first);
    for (uint32_t k = 0; k < part; ++k) {
      const size_t i = begin + first + k;
      const Vec2 u =
          points[k].shifted(static_cast<uint32_t>(shift), static_cast<uint32_t>(shift >> 32));
      position_.set(i, film_position(x, y, u));
      if (coverage_) {
        const uint64_t own = hash_words(key, 5, first + k);
        key_[0][i] = static_cast<uint32_t>(own), key_[1][i] = static_cast<uint32_t>(own >> 32);
      }
      if (has_aperture) {
        aperture_.set(i, owen_sobol_point(first + k, aperture_x, aperture_y));
      }
    }
  }
}

void Primaries::find_width(Tile& tile) const {
  const Vec2 corner(static_cast<float>(tile.pixels.x0), static_cast<float>(tile.pixels.y0));
  const Ray a = view_.sensor.sample_ray(corner, Vec2(0.5f));
  const Ray b = view_.sensor.sample_ray(corner + Vec2(1, 0), Vec2(0.5f));
  const auto side = static_cast<float>(tile.pixels.width());
  tile.origin_width = side * glm::length(b.o - a.o);
  tile.direction_width = side * glm::length(b.d - a.d);
}

void Primaries::place(uint64_t seed) {
  if (!view_.sensor.needs_aperture_sample()) {
    for (float* const column : {aperture_.x, aperture_.y}) {
      std::fill_n(column, padded(first_.back()), 0.5f);
    }
  }
  for (Tile& tile : tiles_) {
    find_width(tile);
    size_t pixel = tile.first_pixel;
    for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
      for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x, ++pixel) {
        place_pixel(x, y, first_[pixel], first_[pixel + 1], seed);
      }
    }
  }
}

void Primaries::trace(uint64_t seed, RenderCounters& counters) {
  const size_t rays = first_.back();
  if (rays > arena_->capacity()) make_room(padded(rays));
  place(seed);
  camera_->trace(position_, aperture_, rays, counters);
  camera_->set_seen_light(emitted_);
  if (coverage_) {
    const PixelSamples samples{key_[0], key_[1], rays, 0, 1, 0};
    coverage_->find(samples, *camera_, alpha_, counters);
  }
  std::fill_n(point_, rays, -1);
  for (const transport::Surfaces::Range& range : camera_->surfaces().ranges()) {
    for (size_t i = range.first; i < range.first + range.count; ++i) {
      point_[points().ray[i]] = static_cast<int32_t>(i);
    }
  }
  std::fill_n(patch_.begin(), points().count, -1);
  describe();
  const SurfaceBlock& p = points();
  wide::for_lanes(p.count, [&](size_t i) {
    wide::frame_at(p, i).to_world(wide::Vec3::load(p.wi, i)).store(three(frames_.viewer), i);
  });
}

/// Describes each material once, for all its shapes. The elements between their ranges are
/// valid points, too.
void Primaries::describe() {
  const auto ranges = camera_->surfaces().ranges();
  const BsdfFormBlock forms{three(frames_.normal),
                            three(frames_.tangent),
                            three(diffuse_),
                            three(microfacets_.specular),
                            microfacets_.alpha_u.data(),
                            microfacets_.alpha_v.data(),
                            three(turned_.normal),
                            turned_.bump_alpha2.data(),
                            kind_.data(),
                            &kinds_};
  for (size_t k = 0; k < ranges.size();) {
    const Bsdf* const bsdf = ranges[k].row->bsdf;
    const size_t first = ranges[k].first;
    size_t end = first;
    for (; k < ranges.size() && ranges[k].row->bsdf == bsdf; ++k) {
      end = ranges[k].first + ranges[k].count;
    }
    if (any(bsdf->lobes())) {
      bsdf->describe_block(points().part(first, end - first), forms.from(first));
    }
  }
}

Ray TilePrimaries::last_part(size_t ray) const {
  constexpr float kMargin = 1e-3f;
  const size_t i = tile_->first_ray + ray, lane = i % kBlockLanes;
  const Ray16& all = all_->camera_->rays()[i / kBlockLanes].ray;
  Ray part;
  part.o = {all.ox[lane], all.oy[lane], all.oz[lane]};
  part.d = {all.dx[lane], all.dy[lane], all.dz[lane]};
  part.tmin = all.tmax[lane] * (1 - kMargin);
  part.tmax = all.tmax[lane] * (1 + kMargin);
  return part;
}

BsdfForm TilePrimaries::form(size_t ray) const {
  const auto i = static_cast<size_t>(point(ray));
  BsdfForm form = *form_kind(ray);
  form.diffuse = diffuse(ray);
  form.specular = specular(ray);
  form.alpha_u = all_->microfacets_.alpha_u[i];
  form.alpha_v = all_->microfacets_.alpha_v[i];
  form.surface_normal = at(all_->turned_.normal, ray);
  form.bump_alpha2 = all_->turned_.bump_alpha2[i];
  return form;
}

}  // namespace kinome
