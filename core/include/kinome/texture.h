#pragma once

#include <memory>
#include <string>

#include "kinome/blocks.h"
#include "kinome/color.h"
#include "kinome/interaction.h"
#include "kinome/object.h"

namespace kinome {

/// Colour or scalar over a surface's (u, v). Linear Rec.709.
class KINOME_EXPORT Texture : public Object {
 public:
  /// Colour at uv.
  virtual Rgb eval(const Vec2& uv) const = 0;
  /// Scalar value at uv. Default: the luminance of eval().
  virtual float eval_1(const Vec2& uv) const { return luminance(eval(uv)); }
  /// Block versions of eval() and eval_1(). Default: one by one.
  virtual void eval_block(const Columns2& uv, size_t count, const Columns3& out) const;
  virtual void eval_1_block(const Columns2& uv, size_t count, float* out) const;
  /// Partial derivatives of eval_1() by u and v. Default: central differences over 1e-3.
  virtual Vec2 eval_1_gradient(const Vec2& uv) const;
  /// Block version of eval_1_gradient(). Default: one by one.
  virtual void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const;
  /// Value at a surface point. The defaults use only its uv, as most textures do.
  virtual Rgb eval_at(const SurfaceInteraction& si) const { return eval(si.uv); }
  virtual float eval_1_at(const SurfaceInteraction& si) const { return eval_1(si.uv); }
  virtual void eval_block_at(const SurfaceBlock& points, const Columns3& out) const {
    eval_block(points.uv, points.count, out);
  }
  virtual void eval_1_block_at(const SurfaceBlock& points, float* out) const {
    eval_1_block(points.uv, points.count, out);
  }
  /// Name of the MeshAttribute that the texture reads, or "" if none; shapes must have the
  /// attribute. Textures with an attribute are evaluated only by eval_at() and similar functions,
  /// never by uv alone.
  virtual std::string attribute() const { return ""; }
  /// Mean colour over the unit square.
  virtual Rgb mean() const = 0;
  /// Value of a uniform texture as emission; spectra have different colours as emission and as
  /// reflectance (see Quantity). Default: mean().
  virtual Rgb emission() const { return mean(); }
  /// Bounds on all values and channels.
  virtual float max() const = 0;
  virtual float min() const = 0;
  /// Maximum of each channel, or an upper bound on it.
  virtual Rgb channel_max() const { return is_uniform() ? mean() : Rgb(max()); }
  /// True if eval() is constant, so that callers can evaluate it once.
  virtual bool is_uniform() const { return false; }
  /// Number of texels along u and v, for choosing a sampling rate; 1 x 1 if the texture has none.
  virtual glm::uvec2 resolution() const { return {1, 1}; }
};

/// Returns a texture with a constant value.
KINOME_EXPORT std::shared_ptr<Texture> make_uniform_texture(const Rgb& value);

}  // namespace kinome
