#pragma once

#include "kinome/clustered_light.h"
#include "kinome/distant_disk.h"
#include "kinome/sphere_partition.h"

namespace kinome {

/// Base of environments, which emit light from all directions. Samples emitted rays by sampling a
/// direction, and an origin on the disk perpendicular to it.
class Environment : public Emitter, public ClusteredLight {
 public:
  bool is_environment() const final { return true; }
  void prepare(const Aabb& scene_bounds) final { disk_.prepare(scene_bounds); }

  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const final {
    return emission_of(*this, disk_, position, direction);
  }

  void sample_emission_block(const Columns2& position, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const final {
    const wide::ScratchColumns scratch(6, count);
    // Directions don't depend on the point that receives the light.
    const Columns3 unused = scratch.three(3);
    for (float* column : {unused.x, unused.y, unused.z}) std::fill_n(column, padded(count), 0.f);
    const DirectBlock light{out.d, scratch[0], scratch[1], out.power, scratch[2]};
    sample_direct_block(unused, direction, count, light);
    const float pdf_position = disk_.pdf();
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec3 d = -wide::Vec3::load(out.d, i);
      const wide::Float pdf_direction = wide::Float::load(light.pdf + i);
      disk_.origin(d, wide::Vec2::load(position, i)).store(out.o, i);
      d.store(out.d, i);
      const wide::Rgb power = wide::Rgb::load(out.power, i) / (pdf_direction * pdf_position);
      select(pdf_direction > 0.f && pdf_position > 0.f, power).store(out.power, i);
    });
  }

  std::optional<EmissionDensity> emission_density(const Vec3& d) const final {
    return EmissionDensity{pdf_environment(-d), disk_.pdf()};
  }

 private:
  DistantDisk disk_;
};

/// Returns light points of an environment, one in the direction `centre(i)` of each cell i.
template <class Centre>
LightPoints distant_points(const SpherePartition& cells, std::vector<Rgb> power,
                           const Centre& centre) {
  const auto count = static_cast<uint32_t>(power.size());
  LightPoints points;
  points.kind = LightPoints::Kind::kDistant;
  points.power = std::move(power);
  points.extent.assign(count, cells.cell_solid_angle());
  points.position.reserve(count);
  for (uint32_t i = 0; i < count; ++i) points.position.push_back(centre(i));
  return points;
}

}  // namespace kinome
