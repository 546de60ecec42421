/// A slide projector: a point that shines an image along the local +z axis, with +x to the image's
/// left and +y up, as a camera at its place would see it. A white diffuse surface across the axis
/// shows exactly `irradiance` x `scale` at z = 1, and 1 / z² of it further away.
///
/// The image's sides are as its resolution's, the square's for a texture without texels. Without a
/// texture it projects a white square.
///
/// A scale in to_world means what it does in Mitsuba 3: along x and y it stretches the image, along
/// z it makes it smaller, and the light brighter by as much. Shear is an error.
///
///     <emitter type="projector">
///       <texture type="bitmap" name="irradiance"><string name="filename" value="slide.exr"/>
///       </texture>
///       <float name="fov" value="40"/>
///       <transform name="to_world"><lookat origin="0 1 5" target="0 1 0" up="0 1 0"/></transform>
///     </emitter>

#include <mutex>

#include "../sensors/camera.h"
#include "emission.h"
#include "flux_grid.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"to_world", ParameterType::kTransform, "identity", "Where it is; it shines along its +z."},
    {"irradiance", ParameterType::kEmissionTexture, "1",
     "What a white diffuse surface shows at z = 1: the image."},
    {"scale", ParameterType::kFloat, "1", "Factor of the irradiance."},
    KINOME_FOV_PARAMETERS,
};

float read_scale(const Properties& props) {
  const float scale = props.real("scale");
  if (!std::isfinite(scale) || scale < 0) {
    throw props.error("scale", "must be finite and not negative, got " + std::to_string(scale));
  }
  return scale;
}

class Projector final : public Emitter {
 public:
  explicit Projector(const Properties& props)
      : frame_(read_light_frame(props)),
        irradiance_(read_emission_texture(props, "irradiance")),
        scale_(read_scale(props) * frame_.scale.z) {
    const Vec2 texels(irradiance_->resolution());
    half_size_.x = read_half_width(props, texels.x / texels.y);
    half_size_.y = half_size_.x * texels.y / texels.x;
    half_size_ *= Vec2(frame_.scale) / frame_.scale.z;
    // Toward its corners it is brightest.
    check_emission(props, "scale", *irradiance_,
                   double{scale_} * std::pow(glm::length(glm::dvec3(half_size_, 1)), 3));
  }

  bool is_delta() const override { return true; }

  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& /*u*/) const override {
    const TowardLight light(p, frame_.origin);
    const Vec3 d = frame_.to_local(-light.d);
    const auto place = place_of(d);
    if (!place.is_lit) return std::nullopt;
    return light_from_point(light, intensity(irradiance_.at(place.uv), d.z));
  }
  void sample_direct_block(const Columns3& p, const Columns2& /*u*/, size_t count,
                           const DirectBlock& out) const override {
    const wide::ScratchColumns scratch(3, count);
    const Columns2 uv = scratch.two(0);
    float* const cosine = scratch[2];
    const auto toward_lanes = [&](size_t i) {
      return TowardLight(wide::Vec3::load(p, i), wide::Vec3(frame_.origin));
    };
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec3 d = frame_.to_local(-toward_lanes(i).d);
      const auto place = place_of(d);
      select(place.is_lit, place.uv).store(uv, i);
      select(place.is_lit, d.z).store(cosine + i);
    });
    const wide::ColorInput::Columns irradiance(irradiance_, uv, count);
    wide::for_lanes(count, [&](size_t i) {
      const wide::Float z = wide::Float::load(cosine + i);
      const wide::Rgb shone = select(z > 0.f, intensity(irradiance[i], z));
      store_light_from_point(out, i, toward_lanes(i), shone);
    });
  }

  std::optional<EmissionDensity> emission_density(const Vec3& d) const override {
    const Vec3 local = frame_.to_local(d);
    const auto place = place_of(local);
    if (!place.is_lit) return EmissionDensity{};
    return EmissionDensity{direction_pdf(flux().pdf(place.uv), 1 / local.z), 0};
  }

  /// Directions are drawn by their flux, which is even where the image is: equal areas of the plane
  /// z = 1 get equal flux.
  std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                const Vec2& direction) const override {
    const auto place = flux().sample(direction);
    if (!place) return std::nullopt;
    const Vec3 through = on_plane<Vec3>(place->uv);
    const float inverse_cosine = glm::length(through);
    const Rgb shone = intensity(irradiance_.at(place->uv), 1 / inverse_cosine);
    if (is_black(shone)) return std::nullopt;
    EmissionSample sample;
    sample.o = frame_.origin;
    sample.d = frame_.to_world(through / inverse_cosine);
    sample.pdf_direction = direction_pdf(place->pdf, inverse_cosine);
    sample.power = shone / sample.pdf_direction;
    return sample;
  }
  void sample_emission_block(const Columns2& /*position*/, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    const wide::ScratchColumns scratch(4, count);
    const Columns2 uv = scratch.two(0);
    float *const pdf = scratch[2], *const inverse_cosine = scratch[3];
    const bool is_black = flux().is_black();
    wide::for_lanes(count, [&](size_t i) {
      FluxGrid::SampleOf<wide::Float> place{wide::Vec2(0.5f), 1.f};
      if (!is_black) place = flux().sample(wide::Vec2::load(direction, i));
      const auto through = on_plane<wide::Vec3>(place.uv);
      const wide::Float distance = length(through);
      place.uv.store(uv, i);
      distance.store(inverse_cosine + i);
      direction_pdf(place.pdf, distance).store(pdf + i);
      frame_.to_world(through / distance).store(out.d, i);
    });
    const wide::ColorInput::Columns irradiance(irradiance_, uv, count);
    wide::for_lanes(count, [&](size_t i) {
      const wide::Float cosine = 1.f / wide::Float::load(inverse_cosine + i);
      const wide::Rgb power = intensity(irradiance[i], cosine) / wide::Float::load(pdf + i);
      store_emission(out, i, frame_.origin, wide::Vec3::load(out.d, i), !is_black, power);
    });
  }

 private:
  const FluxGrid& flux() const {
    std::call_once(flux_made_, [this] { flux_.emplace(make_flux_grid()); });
    return *flux_;
  }
  template <class F>
  struct Place {
    wide::formulas::Vec2Of<F> uv;
    wide::formulas::MaskOf<F> is_lit;
  };
  /// Of the image, that light along the unit vector d (in the projector's frame) shows.
  template <class V>
  Place<wide::formulas::NumberOf<V>> place_of(const V& d) const {
    using F = wide::formulas::NumberOf<V>;
    const F u = 0.5f - d.x / (2.f * d.z * half_size_.x);
    const F v = 0.5f - d.y / (2.f * d.z * half_size_.y);
    return {{u, v}, d.z > 0.f && u >= 0.f && u <= 1.f && v >= 0.f && v <= 1.f};
  }
  /// The place of the plane z = 1 that shows a place of the image.
  template <class V, class V2>
  V on_plane(const V2& uv) const {
    const V2 plane = (V2(1.f) - 2.f * uv) * V2(half_size_);
    return {plane.x, plane.y, 1.f};
  }
  /// Per solid angle, from that per area of the image.
  template <class F>
  F direction_pdf(F image_pdf, F inverse_cosine) const {
    return image_pdf / (4 * half_size_.x * half_size_.y) * inverse_cosine * inverse_cosine *
           inverse_cosine;
  }

  /// Toward a place of the image, that shows `irradiance`, at an angle to the axis. Its cube is
  /// what makes the plane z = 1 show the image as it is: 1 / distance² and the receiving cosine.
  template <class V, class F>
  V intensity(const V& irradiance, F cosine) const {
    return irradiance * (kPi * scale_ / (cosine * cosine * cosine));
  }

  FluxGrid make_flux_grid() const {
    const auto flux = [this](const Vec2& uv) {
      return scale_ * luminance(glm::abs(irradiance_.at(uv)));
    };
    if (irradiance_->is_uniform()) return FluxGrid({1, 1}, 1, flux);
    // At twice the image's resolution, or a multiple, its interpolation is bilinear in every cell.
    // Few texels are refined (other textures look like one); of too many, several share a cell.
    constexpr uint32_t kMinSide = 256;
    constexpr uint64_t kMaxCells = 1 << 22;
    glm::uvec2 cells = irradiance_->resolution() * 2u;
    for (int i = 0; i < 2; ++i) cells[i] *= (kMinSide + cells[i] - 1) / cells[i];
    uint32_t parts = 1;
    while (uint64_t{cells.x} * cells.y > kMaxCells) {
      cells = (cells + 1u) / 2u;
      parts *= 2;
    }
    return FluxGrid(cells, parts, flux);
  }

  LightFrame frame_;
  wide::ColorInput irradiance_;
  float scale_;
  Vec2 half_size_{1.f};  ///< of the image at z = 1
  /// Made when the first ray of light is asked for: direct light doesn't need it.
  mutable std::once_flag flux_made_;
  mutable std::optional<FluxGrid> flux_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Projector, kinome::Category::kEmitter, "projector",
              "A point that shines an image, as a slide projector does.", kinome::kTable);
