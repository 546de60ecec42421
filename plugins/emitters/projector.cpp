/// A slide projector: a point that projects an image along the local +z axis, with +x to the left
/// and +y up, as a camera at the same position would see the image. A white diffuse surface
/// perpendicular to the axis shows exactly `irradiance` x `scale` at z = 1, and 1 / z² of it at
/// distance z.
///
/// The image has the aspect ratio of its resolution. A texture without texels, or a colour, is
/// projected as a square.
///
/// A scale in to_world acts as in Mitsuba 3: along x and y it stretches the image; along z it makes
/// the image smaller and the light brighter by the same factor. Shear is an error.
///
///     <emitter type="projector">
///       <texture type="bitmap" name="irradiance"><string name="filename" value="slide.exr"/>
///       </texture>
///       <float name="fov" value="40"/>
///       <transform name="to_world"><lookat origin="0 1 5" target="0 1 0" up="0 1 0"/></transform>
///     </emitter>

#include "../sensors/camera.h"
#include "colored_point.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"to_world", ParameterType::kTransform, "identity",
     "Position and orientation; light is emitted along +z."},
    {"irradiance", ParameterType::kEmissionTexture, "1",
     "The projected image: the radiance of a white diffuse surface at z = 1."},
    {"scale", ParameterType::kFloat, "1", "Scale factor of the irradiance."},
    KINOME_FOV_PARAMETERS,
};

class Projector final : public ColoredPoint<Projector> {
 public:
  explicit Projector(const Properties& props)
      : ColoredPoint(read_light_frame(props), read_emission_texture(props, "irradiance")),
        scale_(read_scale(props) * frame_.scale.z) {
    const Vec2 texels(texture_->resolution());
    half_size_.x = read_half_width(props, texels.x / texels.y);
    half_size_.y = half_size_.x * texels.y / texels.x;
    half_size_ *= Vec2(frame_.scale) / frame_.scale.z;
    // The intensity is largest toward the corners.
    check_emission(props, "scale", *texture_,
                   double{scale_} * std::pow(glm::length(glm::dvec3(half_size_, 1)), 3));
  }

  std::optional<EmissionDensity> emission_density(const Vec3& d) const override {
    const Vec3 local = frame_.to_local(d);
    const auto point = beam_toward(local);
    if (!(point.factor > 0)) return EmissionDensity{};
    return EmissionDensity{direction_pdf(flux().pdf(point.uv), 1 / local.z), 0};
  }

  /// Samples directions by their flux: equal areas of the plane z = 1 get flux in proportion to the
  /// image.
  std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                const Vec2& direction) const override {
    const auto point = flux().sample(direction);
    if (!point) return std::nullopt;
    const Vec3 through = on_plane<Vec3>(point->uv);
    const float inverse_cosine = glm::length(through);
    const Rgb emitted = intensity(texture_.at(point->uv), 1 / inverse_cosine);
    if (is_black(emitted)) return std::nullopt;
    EmissionSample sample;
    sample.o = frame_.origin;
    sample.d = frame_.to_world(through / inverse_cosine);
    sample.pdf_direction = direction_pdf(point->pdf, inverse_cosine);
    sample.power = emitted / sample.pdf_direction;
    return sample;
  }
  void sample_emission_block(const Columns2& /*position*/, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    const wide::ScratchColumns scratch(4, count);
    const Columns2 uv = scratch.two(0);
    float *const pdf = scratch[2], *const inverse_cosine = scratch[3];
    const bool is_black = flux().is_black();
    wide::for_lanes(count, [&](size_t i) {
      FluxGrid::SampleOf<wide::Float> point{wide::Vec2(0.5f), 1.f};
      if (!is_black) point = flux().sample(wide::Vec2::load(direction, i));
      const auto through = on_plane<wide::Vec3>(point.uv);
      const wide::Float distance = length(through);
      point.uv.store(uv, i);
      distance.store(inverse_cosine + i);
      direction_pdf(point.pdf, distance).store(pdf + i);
      frame_.to_world(through / distance).store(out.d, i);
    });
    const wide::ColorInput::Columns irradiance(texture_, uv, count);
    wide::for_lanes(count, [&](size_t i) {
      const wide::Float cosine = 1.f / wide::Float::load(inverse_cosine + i);
      const wide::Rgb power = intensity(irradiance[i], cosine) / wide::Float::load(pdf + i);
      store_emission(out, i, frame_.origin, wide::Vec3::load(out.d, i), !is_black, power);
    });
  }

 private:
  friend class ColoredPoint<Projector>;

  /// The factor is the cosine with the axis, and uv the point of the image.
  template <class V>
  Beam<wide::formulas::NumberOf<V>> beam_toward(const V& d) const {
    using namespace wide::formulas;
    using F = NumberOf<V>;
    const F u = 0.5f - d.x / (2.f * d.z * half_size_.x);
    const F v = 0.5f - d.y / (2.f * d.z * half_size_.y);
    const auto is_lit = d.z > 0.f && u >= 0.f && u <= 1.f && v >= 0.f && v <= 1.f;
    return {select(is_lit, d.z), select(is_lit, Vec2Of<F>(u, v))};
  }
  /// Maps a point of the image to the plane z = 1.
  template <class V, class V2>
  V on_plane(const V2& uv) const {
    const V2 plane = (V2(1.f) - 2.f * uv) * V2(half_size_);
    return {plane.x, plane.y, 1.f};
  }
  /// Converts a density per area of the image to one per solid angle.
  template <class F>
  F direction_pdf(F image_pdf, F inverse_cosine) const {
    return image_pdf / (4 * half_size_.x * half_size_.y) * inverse_cosine * inverse_cosine *
           inverse_cosine;
  }

  /// Intensity toward a point of the image with `irradiance`, at an angle to the axis. The cubed
  /// cosine cancels 1 / distance² and the cosine at the plane z = 1, which thus shows the image
  /// unchanged.
  template <class V, class F>
  V intensity(const V& irradiance, F cosine) const {
    return irradiance * (kPi * scale_ / (cosine * cosine * cosine));
  }

  FluxGrid make_flux_grid() const {
    const auto flux = [this](const Vec2& uv) {
      return scale_ * luminance(glm::abs(texture_.at(uv)));
    };
    if (texture_->is_uniform()) return FluxGrid({1, 1}, 1, flux);
    // At a multiple of twice the image's resolution, the interpolation is bilinear in every cell. A
    // small image gets several cells per texel (other textures count as one texel). A large image
    // gets several texels per cell.
    constexpr uint32_t kMinSide = 256;
    constexpr uint64_t kMaxCells = 1 << 22;
    glm::uvec2 cells = texture_->resolution() * 2u;
    for (int i = 0; i < 2; ++i) cells[i] *= (kMinSide + cells[i] - 1) / cells[i];
    uint32_t parts = 1;
    while (uint64_t{cells.x} * cells.y > kMaxCells) {
      cells = (cells + 1u) / 2u;
      parts *= 2;
    }
    return FluxGrid(cells, parts, flux);
  }

  float scale_;
  Vec2 half_size_{1.f};  ///< half of the image's size at z = 1
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Projector, kinome::Category::kEmitter, "projector",
              "A slide projector: a point that projects an image.", kinome::kTable);
