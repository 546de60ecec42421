// The part of LocalLight that sorts points and evaluates light that rays find.
#include <algorithm>
#include <cmath>
#include <utility>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/spread.h"
#include "kinome/render_context.h"

namespace kinome {
namespace {

/// Number of cells that a thread sorts together.
constexpr uint32_t kCellsOfPart = 16;
/// Minimum number of chunks that a thread distributes together, and maximum number of their ranges.
constexpr size_t kChunksOfRange = 4, kMaxRanges = 8;

/// Returns the Morton code of a position in the unit cube, with 10 bits per coordinate.
uint32_t morton_code(const Vec3& at) {
  uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    auto v = static_cast<uint32_t>(std::clamp(at[axis], 0.f, 1.f) * 1023.f);
    v = (v | v << 16) & 0x030000ffu;
    v = (v | v << 8) & 0x0300f00fu;
    v = (v | v << 4) & 0x030c30c3u;
    v = (v | v << 2) & 0x09249249u;
    code |= v << axis;
  }
  return code;
}

/// Maximum eye_ratio. It leaves nearly all light to eye rays, and gives 0, not NaN, when multiplied
/// by a density of 0.
constexpr float kMaxEyeRatio = 1e25f;

/// Minimum density of the reflected direction, at normal incidence [1/sr], of a narrow lobe and of
/// a lobe that nearly mirrors. They correspond to GGX with an alpha of 0.28 and 0.0126.
constexpr float kNarrowDensity = 1, kMirroringDensity = 500;

simd::LightPointRow row_of(const LightPoint& p) {
  simd::LightPointRow row{};
  for (int axis = 0; axis < 3; ++axis) {
    row.position[axis] = p.position[axis];
    row.normal[axis] = p.normal[axis];
    row.geometric[axis] = p.geometric[axis];
    row.power[axis] = p.power[axis];
  }
  row.eye_ratio = p.eye_ratio;
  return row;
}

/// A point, and its position along the Morton curve through its cell.
struct PointKey {
  uint32_t code;
  const LightPoint* point;
  bool operator<(const PointKey& other) const { return code < other.code; }
};

/// Sorts the keys of each cell, and copies the points in this order.
void fill_cells(LargeArray<PointKey>& keys, const Scheduler& scheduler, LocalPoints& all) {
  all.points.resize(keys.size());
  all.rows.resize(keys.size());
  all.reflection.resize(keys.size());
  all.group.resize(keys.size());
  const auto cells = static_cast<uint32_t>(all.first.size() - 1);
  const uint32_t parts = (cells + kCellsOfPart - 1) / kCellsOfPart;
  scheduler.parallel_for(parts, [&](size_t part) {
    const auto first_cell = static_cast<uint32_t>(part) * kCellsOfPart;
    const uint32_t last_cell = std::min(first_cell + kCellsOfPart, cells);
    for (uint32_t c = first_cell; c < last_cell; ++c) {
      // A stable sort is used so that the result doesn't depend on the standard library.
      std::stable_sort(keys.begin() + all.first[c], keys.begin() + all.first[c + 1]);
    }
    for (uint32_t i = all.first[first_cell]; i < all.first[last_cell]; ++i) {
      all.points[i] = *keys[i].point;
      all.rows[i] = row_of(all.points[i]);
      all.reflection[i] = all.points[i].reflection;
      all.group[i] = all.points[i].group;
    }
  });
}

}  // namespace

/// Chunks of points that a thread distributes to the cells.
struct LocalLight::ChunkRange {
  std::span<Drawn> chunks;
  std::vector<Aabb> boxes;     ///< of its points in each cell
  std::vector<uint32_t> next;  ///< number of points in each cell, and later the next one's index
  size_t reflections = 0;      ///< number, and later index of the first one
  bool has_bent_normals = false;
};

std::vector<LocalLight::ChunkRange> LocalLight::count_points(std::vector<Drawn>& chunks,
                                                             const Scheduler& scheduler) const {
  std::vector<ChunkRange> ranges(std::clamp<size_t>(chunks.size() / kChunksOfRange, 1, kMaxRanges));
  scheduler.parallel_for(ranges.size(), [&](size_t r) {
    ChunkRange& range = ranges[r];
    const size_t first = r * chunks.size() / ranges.size();
    const size_t end = (r + 1) * chunks.size() / ranges.size();
    range = {{chunks.data() + first, end - first},
             std::vector<Aabb>(size_), std::vector<uint32_t>(size_, 0)};
    for (const Drawn& chunk : range.chunks) {
      range.reflections += chunk.reflections.size();
      for (const LightPoint& p : chunk.points) {
        range.boxes[p.cell].expand(p.position);
        ++range.next[p.cell];
        range.has_bent_normals |= p.off_surface > 0;
      }
    }
  });
  return ranges;
}

LocalPoints LocalLight::sort_by_cell(std::vector<Drawn>& chunks, const Scheduler& scheduler) const {
  std::vector<ChunkRange> ranges = count_points(chunks, scheduler);
  LocalPoints all;
  std::vector<Aabb> boxes(size_);
  all.first.assign(size_ + 1, 0);
  for (uint32_t c = 0; c < size_; ++c) {
    uint32_t next = all.first[c];
    for (ChunkRange& range : ranges) {
      boxes[c].expand(range.boxes[c]);
      next += std::exchange(range.next[c], next);
    }
    all.first[c + 1] = next;
  }
  size_t reflections = 0;
  for (ChunkRange& range : ranges) {
    reflections += std::exchange(range.reflections, reflections);
    all.has_bent_normals |= range.has_bent_normals;
  }
  LargeArray<PointKey> keys(all.first.back());
  all.reflections.resize(reflections);
  scheduler.parallel_for(ranges.size(), [&](size_t r) {
    ChunkRange& range = ranges[r];
    for (Drawn& chunk : range.chunks) {
      const auto first = static_cast<uint32_t>(range.reflections);
      std::copy(chunk.reflections.begin(), chunk.reflections.end(),
                all.reflections.begin() + first);
      range.reflections += chunk.reflections.size();
      for (LightPoint& p : chunk.points) {
        if (p.reflection != LightPoint::kLambertian) p.reflection += first;
        const Aabb& box = boxes[p.cell];
        const Vec3 at = (p.position - box.lo) / glm::max(box.extent(), Vec3(1e-30f));
        keys[range.next[p.cell]++] = {morton_code(at), &p};
      }
    }
  });
  fill_cells(keys, scheduler, all);
  return all;
}

LobeWidth lobe_width(const SurfaceInteraction& si) {
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes() & Lobe::kGlossy)) return LobeWidth::kWide;
  SurfaceInteraction straight = si;
  straight.wi = Vec3(0, 0, si.wi.z >= 0 ? 1 : -1);
  straight.wi = si.frame.to_local(bsdf.reflection_frame(straight).n);
  const float density = bsdf.eval_pdf(straight, Lobe::kGlossy, straight.wi).pdf;
  if (density > kMirroringDensity) return LobeWidth::kMirroring;
  return density > kNarrowDensity ? LobeWidth::kNarrow : LobeWidth::kWide;
}

bool is_plain(const SurfaceInteraction& si, LobeWidth width) {
  const Bsdf& bsdf = si.shape->bsdf();
  return !any(bsdf.lobes() & Lobe::kDelta) && !bsdf.transmits() && width == LobeWidth::kWide;
}

LocalPoints LocalLight::draw(uint64_t seed, RenderContext& context, float share) const {
  const auto share_of = [&](uint32_t count) {
    return static_cast<uint32_t>(std::ceil(static_cast<float>(count) * share));
  };
  std::vector<Drawn> chunks;
  draw_part(false, share_of(surface_count_), hash_words(seed, 1), context, chunks);
  draw_part(true, share_of(bounce_count_), hash_words(seed, 2), context, chunks);
  LocalPoints points = sort_by_cell(chunks, context.scheduler);
  points.share = share;
  return points;
}

LocalLight::Place LocalLight::surface_place(const SurfaceInteraction& si) const {
  const Source& source = sources_[source_of_.at(si.shape->emitter())];
  const float density =
      static_cast<float>(surface_count_) * source.surface_share / si.shape->area();
  const uint32_t cell = surface_cell(si);
  return {cell, eye_factors_[cell] / density};
}

float LocalLight::eye_ratio(const Source& source, float probability, const SurfaceInteraction* x,
                            const SurfaceInteraction& y, const Vec3& d, float distance) const {
  const float cosine = std::abs(glm::dot(y.n, d));
  const float count = static_cast<float>(bounce_count_) * source.bounce_share / probability;
  float ratio = kInfinity;
  if (x) {
    const float seen = source.emitter->shape()->pdf_solid_angle(y.p, *x);
    const float per_area = seen * std::abs(glm::dot(x->n, d)) * source.emitter->shape()->area();
    const float sent = surface_cones(*x).pdf(d, surface_emission_pdf(*x, d));
    ratio = per_area / (count * sent * cosine);
  } else if (const auto density = source.emitter->emission_density(d)) {
    if (source.kind == Kind::kEnvironment) {
      const float directions = source.emitter->pdf_environment(-d);
      ratio = directions / (count * density->direction * source.disks.pdf(y.p, d) * cosine);
    } else {
      const float at = density->position > 0
                           ? source.disks.pdf(y.p, d)
                           : source.cones.pdf(d, density->direction) / sqr(distance);
      ratio = 1 / (count * at * cosine);
    }
  }
  // At the rim of a cone, rounding can give a density of 0 to a direction that was drawn.
  return ratio < kMaxEyeRatio ? ratio : kMaxEyeRatio;
}

std::optional<LocalLight::Arrival> LocalLight::sample_arrival(const SurfaceInteraction& si,
                                                              float u1, const Vec2& u) const {
  if (bounce_ends_.empty()) return std::nullopt;
  const SourceChoice::At asked = asked_at(si, si.wi.z >= 0 ? 1.f : -1.f);
  const uint32_t index = asked.pick(u1);
  const float probability = asked.probability(index);
  const Source& source = sources_[index];
  Arrival arrival;
  arrival.group = source.group;
  std::optional<SurfaceInteraction> x;
  if (source.kind == Kind::kSurface) {
    auto surface = source.emitter->shape()->sample_solid_angle(si.p, u);
    if (!surface || !(surface->pdf > 0)) return std::nullopt;
    x = surface->si;
    x->shape = source.emitter->shape();
    const Vec3 to = x->p - si.p;
    arrival.distance = glm::length(to);
    if (!(arrival.distance > 0)) return std::nullopt;
    arrival.d = to / arrival.distance;
    const bool is_own = source.emitter->shape() == si.shape;
    if (is_own && !si.resolves(arrival.d, arrival.distance)) return std::nullopt;
    x->wi = x->frame.to_local(-arrival.d);
    arrival.density = probability * surface->pdf;
    arrival.radiance = source.emitter->eval_surface(*x) / arrival.density;
  } else {
    const auto light = source.emitter->sample_direct(si.p, u);
    if (!light || !(light->pdf > 0)) return std::nullopt;
    arrival.d = light->d;
    arrival.distance = light->distance;
    const float density = probability * light->pdf;
    arrival.radiance = light->radiance / density;
    if (source.kind == Kind::kEnvironment) arrival.density = density;
  }
  if (is_black(arrival.radiance)) return std::nullopt;
  arrival.place =
      bounce_place(source, probability, x ? &*x : nullptr, si, arrival.d, arrival.distance);
  return arrival;
}

LocalLight::Place LocalLight::bounce_place(const Source& source, float probability,
                                           const SurfaceInteraction* x, const SurfaceInteraction& y,
                                           const Vec3& d, float distance) const {
  const uint32_t cell = bounce_cell(y, glm::dot(y.frame.n, d) >= 0 ? 1.f : -1.f);
  return {cell, eye_factors_[cell] * eye_ratio(source, probability, x, y, -d, distance)};
}

LocalLight::Found LocalLight::found_arrival(const SurfaceInteraction& si, const Vec3& d,
                                            float distance, const SurfaceInteraction* x) const {
  const uint32_t index = source_of_.at(x ? x->shape->emitter() : scene_.environment());
  const Source& source = sources_[index];
  const float probability = asked_at(si, si.wi.z >= 0 ? 1.f : -1.f).probability(index);
  return {bounce_place(source, probability, x, si, d, distance),
          probability * arrival_density(*source.emitter, x, si, d)};
}

std::vector<float> LocalLight::caustic_shares(bool with_extended) const {
  std::vector<float> shares;
  double all = 0;
  const auto flux_of = [&](const Source& source) {
    const bool has = source.kind == Kind::kLamp ? has_lamp_caustics_ : with_extended;
    return has ? source.flux : 0.;
  };
  for (const Source& source : sources_) all += flux_of(source);
  for (const Source& source : sources_) {
    shares.push_back(static_cast<float>(flux_of(source) / all));
  }
  return shares;
}

Reflection::Sent Reflection::toward(const Vec3& d) const {
  SurfaceInteraction seen = si;
  seen.wi = si.frame.to_local(d);
  const Bsdf& bsdf = si.shape->bsdf();
  Sent sent{bsdf.eval_pdf(seen, lobes, to_light).f * incident, 0};
  if (light_density > 0) {
    sent.follow_ratio = bsdf.eval_pdf(seen, Lobe::kGlossy, to_light).pdf / light_density;
  }
  return sent;
}

}  // namespace kinome
