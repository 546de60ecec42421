/// Light from infinitely far, given by a latitude-longitude image of any format; those of integers
/// are decoded from sRGB, as in Mitsuba 3.
///
/// Radiance is `scale` times the image, interpolated bilinearly. A direction has the local
/// coordinates d = (sin phi sin theta, cos theta, -cos phi sin theta); columns are centred at
/// phi = 2 pi (j + 1/2) / W, and row i lies at theta = i pi / (H - 1), as in Mitsuba 3.
/// Directions are sampled by the absolute luminance of the interpolated image: see spherical_map.h.
///
///     <emitter type="envmap">
///       <string name="filename" value="city.exr"/>
///       <transform name="to_world"><rotate y="1" angle="90"/></transform>
///     </emitter>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "../textures/stored_image.h"
#include "emission.h"
#include "environment.h"
#include "kinome/color.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "spherical_map.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr,
     "The image, latitude-longitude, in any format of the texture bitmap; integers are sRGB.",
     true},
    {"data", ParameterType::kImage, nullptr,
     "Pixels that a program gives in place of the file: radiance, of one or three channels."},
    {"scale", ParameterType::kFloat, "1", "Factor of the image's radiance."},
    {"to_world", ParameterType::kTransform, "identity",
     "Rotation (or reflection) of the map. Unrotated, its upper row is +y and its centre column "
     "+z."},
    {"mis_compensation", ParameterType::kBoolean, "false",
     "Sample what is brighter than the mean, and leave most of the rest to BSDF sampling (Karlík "
     "et al. 2019)."},
};

/// Linear values.
Image linear_image(StoredImage&& stored) {
  Image image{stored.width, stored.height, {"R", "G", "B"}, std::move(stored.floats)};
  if (stored.channels == 1) image.channels = {"Y"};
  for (const uint8_t byte : stored.bytes) image.data.push_back(static_cast<float>(byte) / 255);
  if (stored.is_encoded) {
    for (float& value : image.data) value = srgb_to_linear(value);
  }
  return image;
}

void check_size(const Location& source, const Image& image) {
  if (size_t(image.width) * size_t(image.height) > SphericalMap::kMostTexels) {
    throw Error(source, "must have at most 2^28 texels");
  }
}

void check_texels(const Location& source, const Image& image, float scale) {
  constexpr float kTooMuch = 1e36f;  // sums of it must stay below the largest float
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channel_count(); ++c) {
        if (std::abs(image.at(x, y, c) * scale) < kTooMuch) continue;
        throw Error(source, "has a texel that is too large at x = " + std::to_string(x) +
                                ", y = " + std::to_string(y) + ", channel " + image.channels[c] +
                                "; times 'scale', radiance must stay below 1e36");
      }
    }
  }
}

float read_scale(const Properties& props) {
  const float scale = props.real("scale");
  if (!std::isfinite(scale) || scale < 0) {
    throw props.error("scale", "must be finite and not negative, got " + std::to_string(scale));
  }
  return scale;
}

SphericalMap read_map(const Properties& props) {
  LoadedImage loaded(props);
  const Image image = linear_image(std::move(loaded.image));
  check_size(loaded.source, image);
  const float scale = read_scale(props);
  check_texels(loaded.source, image, scale);
  return SphericalMap(image, scale, props.boolean("mis_compensation"));
}

class EnvironmentMap final : public Environment {
 public:
  explicit EnvironmentMap(const Properties& props)
      : to_world_(read_rotation(props)),
        to_local_(glm::transpose(to_world_)),
        map_(read_map(props)) {}

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

  void eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                              std::span<float> pdf) const override {
    std::array<Vec3, SphericalMap::kBlock> local;
    for (size_t first = 0; first < d.size(); first += local.size()) {
      const size_t count = std::min(local.size(), d.size() - first);
      for (size_t i = 0; i < count; ++i) local[i] = to_local_ * d[first + i];
      map_.eval_block(std::span(local.data(), count), radiance.data() + first,
                      pdf.empty() ? nullptr : pdf.data() + first);
    }
  }

  void sample_direct_block(const Columns3& /*p*/, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    map_.sample_columns(to_world_, u, count, out);
  }

  void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                              float* pdf) const override {
    map_.eval_columns(to_local_, d, count, radiance, pdf);
  }

  /// Point i stands for cell i of a SpherePartition that turns with the map. All light of a cell is
  /// its point's, so that no small sun is lost between points ("re-sampled onto the leaves",
  /// Åkerlund 2008, 3.4.1, leaves open how). The points stay at the cells' centres whatever the
  /// seed: there is nothing random about them.
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

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::EnvironmentMap, kinome::Category::kEmitter, "envmap",
              "Light from infinitely far, given by a latitude-longitude image.", kinome::kTable);
