/// A point that emits light in a cone around the local +z axis. The intensity is constant up to the
/// angle beam_width from the axis, then decreases linearly with the angle to 0 at cutoff_angle.
///
/// A texture covers the square around the cone's cross-section: the local direction (x, y, z) has
/// (u, v) = 1/2 + 1/2 (x, y) / (z tan(cutoff_angle)). From 90 degrees on, there is no
/// cross-section, and a texture is an error. Mitsuba 3 applies the formula nevertheless: at 90
/// degrees, all light has the colour of the texture's centre; beyond, the texture is upside down,
/// repeats without end, and changes sides at the horizon.
///
///     <emitter type="spot">
///       <transform name="to_world"><lookat origin="0 3 0" target="0 0 0" up="0 0 1"/></transform>
///       <float name="intensity" value="20"/>
///       <float name="cutoff_angle" value="30"/>
///     </emitter>

#include <numbers>

#include "colored_point.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"to_world", ParameterType::kTransform, "identity",
     "Position and orientation; light is emitted along +z."},
    {"intensity", ParameterType::kEmission, "1", "Flux per solid angle inside beam_width [W/sr]."},
    {"cutoff_angle", ParameterType::kFloat, "20",
     "Angle from the axis, in degrees, beyond which there is no light: above 0, up to 180."},
    {"beam_width", ParameterType::kFloat, nullptr,
     "Angle from the axis, in degrees, up to which the intensity is constant; default: 3/4 of "
     "cutoff_angle."},
    {"texture", ParameterType::kUnitlessTexture, "1", "Scale factor of the intensity."},
};

constexpr float kDegree = kPi / 180;

float read_cutoff(const Properties& props) {
  return kDegree * props.real("cutoff_angle", "must be greater than 0 and at most 180 degrees",
                              [](float angle) { return angle > 0 && angle <= 180; });
}

float read_beam_width(const Properties& props, float cutoff) {
  if (!props.has("beam_width")) return 0.75f * cutoff;
  return kDegree * props.real("beam_width",
                              "must be between 0 and cutoff_angle (" +
                                  format_number(cutoff / kDegree) + " degrees)",
                              [cutoff](float b) { return b >= 0 && b * kDegree <= cutoff; });
}

/// Reads to_world. A uniform scale has no effect on a point, as in Mitsuba 3; others are errors.
LightFrame read_frame(const Properties& props) {
  const LightFrame frame = read_light_frame(props);
  const Vec3& scale = frame.scale;
  if (!(max_component(glm::abs(scale / scale.z - 1.f)) < 1e-3f)) {
    throw props.error("to_world", "must have a uniform scale: others would distort the cone");
  }
  return frame;
}

class Spot final : public ColoredPoint<Spot> {
 public:
  explicit Spot(const Properties& props)
      : ColoredPoint(read_frame(props), read_emission_texture(props, "texture")),
        intensity_(read_emission(props, "intensity")),
        cutoff_(read_cutoff(props)),
        beam_width_(read_beam_width(props, cutoff_)),
        cap_height_(2 * sqr(std::sin(cutoff_ / 2))),
        min_lit_cosine_(std::cos(cutoff_) - 1e-4f),
        tan_cutoff_(std::tan(cutoff_)) {
    check_emission(props, "intensity", *texture_, double{max_component(intensity_)});
    if (!texture_->is_uniform() && !(cutoff_ < kPi / 2)) {
      throw props.error("texture", "needs a cutoff_angle of less than 90 degrees, got " +
                                       format_number(cutoff_ / kDegree) +
                                       ": a wider cone has no cross-section");
    }
  }

  /// Samples directions by their flux, from a grid that is mapped to the cone with equal areas.
  std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                const Vec2& direction) const override {
    const auto place = flux().sample(direction);
    if (!place) return std::nullopt;
    const Vec3 local = direction_at<Vec3>(place->uv);
    const Rgb intensity = intensity_toward(local);
    if (is_black(intensity)) return std::nullopt;
    EmissionSample sample;
    sample.o = frame_.origin;
    sample.d = frame_.to_world(local);
    sample.pdf_direction = place->pdf / (2 * kPi * cap_height_);
    sample.power = intensity / sample.pdf_direction;
    return sample;
  }
  void sample_emission_block(const Columns2& /*position*/, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    const wide::ScratchColumns scratch(3, count);
    const Columns2 uv = scratch.two(0);
    float* const share = scratch[2];
    const bool is_black = flux().is_black();
    wide::for_lanes(count, [&](size_t i) {
      wide::Vec3 local(0.f, 0.f, 1.f);
      wide::Float pdf = 1.f;
      if (!is_black) {
        const auto place = flux().sample(wide::Vec2::load(direction, i));
        local = direction_at<wide::Vec3>(place.uv);
        pdf = place.pdf / (2 * kPi * cap_height_);
      }
      const auto beam = beam_toward(local);
      beam.uv.store(uv, i);
      (beam.factor / pdf).store(share + i);
      frame_.to_world(local).store(out.d, i);
    });
    const wide::ColorInput::Columns texture(texture_, uv, count);
    wide::for_lanes(count, [&](size_t i) {
      const wide::Rgb power = wide::Rgb(intensity_) * texture[i] * wide::Float::load(share + i);
      store_emission(out, i, frame_.origin, wide::Vec3::load(out.d, i), !is_black, power);
    });
  }

  std::optional<EmissionDensity> emission_density(const Vec3& d) const override {
    const Vec3 local = frame_.to_local(d);
    const float sine2 = local.x * local.x + local.y * local.y;
    // 1 - cos(theta), precise at small angles.
    const float depth = local.z > 0 ? sine2 / (1 + local.z) : 1 - local.z;
    if (!(depth <= cap_height_)) return EmissionDensity{};
    const float radius = std::sqrt(depth / cap_height_);
    const Vec2 disk = sine2 > 0 ? Vec2(local) * (radius / std::sqrt(sine2)) : Vec2(0.f);
    return EmissionDensity{flux().pdf(disk_to_square_concentric(disk)) / (2 * kPi * cap_height_),
                           0};
  }

 private:
  friend class ColoredPoint<Spot>;

  /// The factor is 0 outside the cone.
  template <class V>
  Beam<wide::formulas::NumberOf<V>> beam_toward(const V& d) const {
    using namespace wide::formulas;
    using F = NumberOf<V>;
    // The angle by atan2, because that by the cosine is imprecise if it is small.
    const F theta = atan2(sqrt(d.x * d.x + d.y * d.y), d.z);
    const MaskOf<F> is_lit = d.z >= min_lit_cosine_ && theta <= cutoff_;
    const F falloff =
        select(theta <= beam_width_, F(1.f), (cutoff_ - theta) / (cutoff_ - beam_width_));
    const F scale = 0.5f / (d.z * tan_cutoff_);
    return {select(is_lit, falloff),
            {select(is_lit, 0.5f + scale * d.x), select(is_lit, 0.5f + scale * d.y)}};
  }
  template <class V, class F>
  V intensity(const V& texel, const F& factor) const {
    return V(intensity_) * factor * texel;
  }

  /// Maps the unit square to the cone, uniformly by solid angle.
  template <class V, class V2>
  V direction_at(const V2& uv) const {
    using namespace wide::formulas;
    using F = NumberOf<V>;
    const V2 disk = warp::square_to_disk_concentric(uv);
    const F depth = dot(disk, disk) * cap_height_;  // 1 - cos(theta)
    const V2 xy = disk * safe_sqrt(cap_height_ * (2.f - depth));
    return {xy.x, xy.y, 1.f - depth};
  }

  FluxGrid make_flux_grid() const {
    // Cells have half the size of a texel. If these were too many, the parts of a cell have the
    // size of a texel. Without a texture, there is only the smooth falloff.
    constexpr uint32_t kSmoothSide = 64, kMinSide = 128, kMaxSide = 1024;
    const glm::uvec2 resolution = texture_->resolution();
    const uint32_t texels = std::max(resolution.x, resolution.y);
    const uint32_t side =
        texture_->is_uniform() ? kSmoothSide : std::clamp(2 * texels, kMinSide, kMaxSide);
    const uint32_t parts = (texels + side - 1) / side;
    return FluxGrid(glm::uvec2(side), parts, [this](const Vec2& uv) {
      return luminance(glm::abs(intensity_toward(direction_at<Vec3>(uv))));
    });
  }

  Rgb intensity_;
  float cutoff_;          ///< radians
  float beam_width_;      ///< radians
  float cap_height_;      ///< 1 - cos(cutoff)
  float min_lit_cosine_;  ///< directions with a smaller cosine are dark, whatever the rounding
  float tan_cutoff_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Spot, kinome::Category::kEmitter, "spot",
              "A point that emits light in a cone, with a linear falloff towards its edge.",
              kinome::kTable);
