#include "kinome/volume.h"
#include "kinome/plugin.h"
#include "kinome/texture.h"
#include "kinome/wide/textures.h"

/// A volume as a texture of surfaces: its value at the point in world space.
///
///     <texture type="volume" name="reflectance">
///       <volume type="gridvolume" name="volume"><string name="filename"
///       value="wood.vol"/></volume>
///     </texture>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"volume", ParameterType::kVolume, "1", "volume of 1 or 3 channels"},
};

class VolumeTexture final : public Texture {
 public:
  explicit VolumeTexture(const Properties& props) : volume_(props.volume("volume")) {
    if (volume_->channels() > 3) throw props.error("volume", "must have 1 or 3 channels, got 6");
    // Without a surface, the value is that of the middle.
    const Vec3 middle = volume_->box().centre();
    middle_ = volume_->color(is_finite(middle) ? middle : Vec3(0.f));
  }

  Rgb eval(const Vec2& /*uv*/) const override { return middle_; }
  Rgb eval_at(const SurfaceInteraction& si) const override { return volume_->color(si.p); }
  float eval_1_at(const SurfaceInteraction& si) const override { return number(eval_at(si)); }
  float eval_1(const Vec2& /*uv*/) const override { return number(middle_); }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const override {
    volume_->color_block(points.p, points.count, out);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    if (volume_->channels() == 1) {
      float* const values[] = {out};
      return volume_->eval_block(points.p, points.count, values);
    }
    const wide::ScratchColumns columns(3, points.count);
    volume_->color_block(points.p, points.count, columns.three());
    wide::for_lanes(points.count, [&](size_t i) {
      luminance(wide::Rgb::load(columns.three(), i)).store(out + i);
    });
  }
  /// A guess: the mean over the surface is unknown.
  Rgb mean() const override { return middle_; }
  float max() const override { return volume_->max(); }
  float min() const override { return volume_->min(); }
  bool is_uniform() const override { return volume_->is_uniform(); }

 private:
  /// Returns a grey value exactly; its luminance would have rounding errors.
  float number(const Rgb& value) const {
    return volume_->channels() == 1 ? value.x : luminance(value);
  }

  std::shared_ptr<const Volume> volume_;
  Rgb middle_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::VolumeTexture, kinome::Category::kTexture, "volume",
              "A volume as a texture of surfaces.", kinome::kParameters);
