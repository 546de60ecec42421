#pragma once

#include <memory>
#include <string>

#include "kinome/blocks.h"
#include "kinome/color.h"
#include "kinome/interaction.h"
#include "kinome/object.h"

namespace kinome {

/// A colour or number over a surface's (u, v).
class KINOME_EXPORT Texture : public Object {
 public:
  virtual Rgb eval(const Vec2& uv) const = 0;
  /// As one number: the luminance of a colour texture, unless the texture defines it otherwise.
  virtual float eval_1(const Vec2& uv) const { return luminance(eval(uv)); }
  /// Both over a block of places. Default: one by one.
  virtual void eval_block(const Columns2& uv, size_t count, const Columns3& out) const;
  virtual void eval_1_block(const Columns2& uv, size_t count, float* out) const;
  /// Slopes of eval_1 along u and along v, per unit of both. Default: differences over 1e-3.
  virtual Vec2 eval_1_gradient(const Vec2& uv) const;
  /// The same over a block. Default: one by one.
  virtual void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const;
  /// The same at points of surfaces. Default: by their uv, which is all that most textures look at.
  virtual Rgb eval_at(const SurfaceInteraction& si) const { return eval(si.uv); }
  virtual float eval_1_at(const SurfaceInteraction& si) const { return eval_1(si.uv); }
  virtual void eval_block_at(const SurfaceBlock& points, const Columns3& out) const {
    eval_block(points.uv, points.count, out);
  }
  virtual void eval_1_block_at(const SurfaceBlock& points, float* out) const {
    eval_1_block(points.uv, points.count, out);
  }
  /// The name of the MeshAttribute that it reads, without which a shape can't have it; "": none.
  /// One that reads any is asked by eval_at and its like, never by uv alone.
  virtual std::string attribute() const { return ""; }
  /// Means over the texture (unit square).
  virtual Rgb mean() const = 0;
  /// What it comes to as light, where it is uniform: a spectrum has another colour as light than as
  /// a reflectance (see Quantity). Default: mean().
  virtual Rgb emission() const { return mean(); }
  /// Largest value of any channel; for checks and bounds.
  virtual float max() const = 0;
  virtual float min() const = 0;
  /// Largest value of each channel, or a bound on it.
  virtual Rgb channel_max() const { return is_uniform() ? mean() : Rgb(max()); }
  /// True where eval is one value everywhere: callers then skip it per point.
  virtual bool is_uniform() const { return false; }
  /// Texels along u and v, by which callers choose how finely to look; 1 x 1 where there are none.
  virtual glm::uvec2 resolution() const { return {1, 1}; }
};

/// A texture of one value.
KINOME_EXPORT std::shared_ptr<Texture> make_uniform_texture(const Rgb& value);

}  // namespace kinome
