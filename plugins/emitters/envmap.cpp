/// An environment given by a latitude-longitude image of any supported format. Integer formats are
/// decoded from sRGB, as in Mitsuba 3.
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
#include <string>

#include "../textures/stored_image.h"
#include "emission.h"
#include "kinome/color.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "map_environment.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr,
     "Latitude-longitude image in any format that 'bitmap' reads; integers are sRGB.", true},
    {"data", ParameterType::kImage, nullptr,
     "Pixels from a program, instead of the file: radiance with one or three channels."},
    {"scale", ParameterType::kFloat, "1", "Scale factor of the image's radiance."},
    {"to_world", ParameterType::kTransform, "identity",
     "Rotation (or reflection) of the map. Without it, the top row is +y and the centre column "
     "+z."},
    {"mis_compensation", ParameterType::kBoolean, "false",
     "Sample mainly directions that are brighter than the mean; BSDF sampling covers most of the "
     "others (Karlík et al. 2019)."},
};

/// Converts the image to linear values.
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
  if (size_t(image.width) * size_t(image.height) > SphericalMap::kMaxTexels) {
    throw Error(source, "must have at most 2^28 texels, got " + std::to_string(image.width) +
                            " x " + std::to_string(image.height));
  }
}

void check_texels(const Location& source, const Image& image, float scale) {
  constexpr float kMaxRadiance = 1e36f;  // sums must stay below the largest float
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channel_count(); ++c) {
        if (std::abs(image.at(x, y, c) * scale) < kMaxRadiance) continue;
        throw Error(source, "has a texel that is too large at x = " + std::to_string(x) +
                                ", y = " + std::to_string(y) + ", channel " + image.channels[c] +
                                "; times 'scale', radiance must stay below 1e36");
      }
    }
  }
}

SphericalMap read_map(const Properties& props) {
  LoadedImage loaded(props);
  const Image image = linear_image(std::move(loaded.image));
  check_size(loaded.source, image);
  const float scale = read_scale(props);
  check_texels(loaded.source, image, scale);
  return SphericalMap(image, scale, props.boolean("mis_compensation"));
}

class EnvironmentMap final : public MapEnvironment {
 public:
  explicit EnvironmentMap(const Properties& props)
      : MapEnvironment(read_rotation(props), read_map(props)) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::EnvironmentMap, kinome::Category::kEmitter, "envmap",
              "An environment given by a latitude-longitude image.", kinome::kTable);
