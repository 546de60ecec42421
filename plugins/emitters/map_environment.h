#pragma once

#include <algorithm>
#include <array>

#include "environment.h"
#include "spherical_map.h"

namespace kinome {

/// An environment given by a latitude-longitude image.
class MapEnvironment : public Environment {
 public:
  /// `to_world` is a rotation or reflection. Its columns are the map's axes in the world.
  MapEnvironment(const glm::mat3& to_world, SphericalMap map)
      : to_world_(to_world), to_local_(glm::transpose(to_world)), map_(std::move(map)) {}

  Rgb eval_environment(const Vec3& d) const override { return map_.eval(to_local_ * d); }

  float pdf_environment(const Vec3& d) const override { return map_.pdf(to_local_ * d); }

  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& u) const override {
    const auto sample = map_.sample(u);
    if (!sample) return std::nullopt;
    DirectSample direct;
    direct.d = to_world_ * sample->d;
    direct.pdf = sample->pdf;
    direct.radiance = sample->radiance;
    return direct;
  }

  std::optional<EnvironmentGrid> cell_grid() const override {
    EnvironmentGrid grid;
    grid.columns = map_.columns();
    grid.rows = map_.rows() - 1;
    grid.first_column = 0.5f;
    grid.to_world = to_world_;
    grid.smooth_quads = grid.bilinear_quads = true;
    return grid;
  }

  bool eval_grid_batch(std::span<const Vec2> places, std::span<Rgb> radiance) const override {
    for (size_t first = 0; first < places.size(); first += SphericalMap::kBlock) {
      const size_t count = std::min(SphericalMap::kBlock, places.size() - first);
      map_.eval_places(places.subspan(first, count), &radiance[first]);
    }
    return true;
  }

  bool eval_grid_corners(int row, int first, std::span<Rgb> radiance) const override {
    map_.copy_texels(row, first, radiance);
    return true;
  }

  bool eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                              std::span<float> pdf) const override {
    std::array<Vec3, SphericalMap::kBlock> local;
    for (size_t first = 0; first < d.size(); first += local.size()) {
      const size_t count = std::min(local.size(), d.size() - first);
      for (size_t i = 0; i < count; ++i) local[i] = to_local_ * d[first + i];
      map_.eval_block(std::span(local.data(), count), radiance.data() + first,
                      pdf.empty() ? nullptr : pdf.data() + first);
    }
    return true;
  }

  void sample_direct_block(const Columns3& /*p*/, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    map_.sample_columns(to_world_, u, count, out);
  }

  void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                              float* pdf) const override {
    map_.eval_columns(to_local_, d, count, radiance, pdf);
  }

  /// Point i represents cell i of a SpherePartition that rotates with the map. Its power is the
  /// integral over the cell, so that no small sun is lost between points. (Åkerlund 2008, 3.4.1,
  /// "re-sampled onto the leaves", doesn't specify how.) Points are at the cells' centres,
  /// independent of the seed.
  std::optional<LightPoints> light_points(const Scene& /*scene*/, RenderContext& /*context*/,
                                          uint32_t count) const override {
    const SpherePartition cells(count);
    return distant_points(cells, map_.integrate(cells),
                          [&](uint32_t i) { return to_world_ * cells.centre(i); });
  }

 private:
  glm::mat3 to_world_;
  glm::mat3 to_local_;
  SphericalMap map_;
};

}  // namespace kinome
