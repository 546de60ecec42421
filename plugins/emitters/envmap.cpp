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
#include <cctype>
#include <memory>
#include <string>

#include "../textures/open_image.h"
#include "emission.h"
#include "environment.h"
#include "kinome/color.h"
#include "kinome/emitter.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "spherical_map.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr,
     "The image, latitude-longitude: OpenEXR (its chromaticities, if any, are converted to "
     "Rec.709), PFM, or anything that OpenImageIO reads (HDR, PNG, JPEG, ...; of integers: sRGB).",
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

std::string extension_of(const std::string& path) {
  const size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] == '/') return "";
  std::string extension = path.substr(dot);
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/// Linear values of what the core can't read.
Image open_linear_image(const std::string& path, const Properties& props) {
  StoredImage stored = open_image(path, props);
  Image image{stored.width, stored.height, {"R", "G", "B"}, std::move(stored.floats)};
  if (stored.channels == 1) image.channels = {"Y"};
  for (const uint8_t byte : stored.bytes) image.data.push_back(static_cast<float>(byte) / 255);
  if (stored.is_encoded) {
    for (float& value : image.data) value = srgb_to_linear(value);
  }
  return image;
}

/// Of the pixels that are given, or of the file `source`.
Image read_image(const Location& source, const Properties& props) {
  const std::string& path = source.file;
  const std::string extension = extension_of(path);
  const auto pixels = props.image("data");
  Image image = pixels                ? *pixels
                : extension == ".exr" ? read_exr(path)
                : extension == ".pfm" ? read_pfm(path)
                                      : open_linear_image(path, props);
  const bool is_rgb = image.channel_count() >= 3 && image.channels[0] == "R" &&
                      image.channels[1] == "G" && image.channels[2] == "B";
  if (image.width < 1 || image.height < 1 || !(is_rgb || image.channel_count() == 1)) {
    throw Error(source, "must have the channels R, G, B, or a single one");
  }
  if (size_t(image.width) * size_t(image.height) > SphericalMap::kMostTexels) {
    throw Error(source, "must have at most 2^28 texels");
  }
  std::vector<std::string> unused;
  for (size_t c = is_rgb ? 3 : 1; c < image.channels.size(); ++c) {
    unused.push_back("channel " + image.channels[c]);
  }
  log_unused(path, unused);
  return image;
}

/// Names the first texel that is no light, and counts those that are less than none.
void check_texels(const Properties& props, const Location& source, const Image& image,
                  float scale) {
  constexpr float kTooMuch = 1e36f;  // sums of it must stay below the largest float
  const int channels = std::min(3, image.channel_count());
  size_t negative = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      bool is_negative = false;
      for (int c = 0; c < channels; ++c) {
        const float value = image.at(x, y, c);
        is_negative |= value < 0;
        if (std::abs(value * scale) < kTooMuch) continue;
        const std::string place = " at x = " + std::to_string(x) + ", y = " + std::to_string(y) +
                                  ", channel " + image.channels[c];
        if (std::isfinite(value)) {
          throw Error(source, "has a texel that is too large" + place +
                                          "; times 'scale', radiance must stay below 1e36");
        }
        throw Error(source, "has a texel that is " +
                                        std::string(std::isnan(value) ? "NaN" : "infinite") +
                                        place + "; radiance must be finite");
      }
      negative += is_negative;
    }
  }
  if (negative > 0) {
    props.warn(props.has("data") ? "data" : "filename", "has " + std::to_string(negative) +
                               (negative == 1 ? " negative texel, which is kept"
                                              : " negative texels, which are kept"));
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
  const Location source = props.has("data") ? props.error("data", "").where()
                                            : Location{props.file("filename"), 0, 0};
  const Image image = read_image(source, props);
  const float scale = read_scale(props);
  check_texels(props, source, image, scale);
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
