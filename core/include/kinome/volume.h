#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "kinome/color.h"
#include "kinome/columns.h"
#include "kinome/object.h"

namespace kinome {

/// Regular grid of blocks over a box in world space. Block (x, y, z) has the index
/// (z * size.y + y) * size.x + x.
struct BlockGrid {
  Aabb box;
  glm::uvec3 size{1};

  size_t count() const { return size_t{size.x} * size.y * size.z; }
  /// Box of a block.
  Aabb block(const glm::uvec3& at) const {
    const Vec3 step = box.extent() / Vec3(size);
    return {box.lo + Vec3(at) * step, box.lo + Vec3(at + 1u) * step};
  }
};

/// Numbers or colours over world space, such as the extinction of a medium. Colours are linear
/// Rec.709.
class KINOME_EXPORT Volume : public Object {
 public:
  static constexpr uint32_t kMaxChannels = 6;
  /// Number of values at each point: 1, 3 (a colour), or 6 (a symmetric matrix: xx, yy, zz, xy, xz,
  /// yz).
  virtual uint32_t channels() const = 0;
  /// Writes the channels() values at the world-space point p. Defined everywhere, also outside of
  /// box().
  virtual void eval(const Vec3& p, float* values) const = 0;
  /// Block version of eval(): values[c][i] is channel c at point i. Default: point by point.
  virtual void eval_block(const Columns3& p, size_t count, float* const* values) const;

  /// Bounds on all values of all channels.
  virtual float min() const = 0;
  virtual float max() const = 0;
  /// True if eval() is constant.
  virtual bool is_uniform() const { return false; }
  /// World-space bounding box of the unit cube that `to_world` transforms. Media end at its faces.
  virtual Aabb box() const = 0;
  /// Number of voxels along the axes of box(), for choosing the size of blocks; 1 without voxels.
  virtual glm::uvec3 resolution() const { return glm::uvec3(1); }
  /// Computes bounds lo and hi on the values of all channels in each block, whose lengths are
  /// blocks.count(). They include the blocks' faces, and hold for eval_block() in spite of rounding
  /// errors. Default: min() and max().
  virtual void extremes(const BlockGrid& blocks, float* lo, float* hi) const;

  /// True if integral_block() is implemented.
  virtual bool has_integral() const { return is_uniform(); }
  /// Integrates each channel along segments o + t d, 0 <= t <= length, with unit vectors d, exactly
  /// up to rounding errors. The segments must be within box(), unless the volume is uniform.
  virtual void integral_block(const Columns3& o, const Columns3& d, const float* length,
                              size_t count, float* const* values) const;

  /// Colour at p; grey if there is one channel. Not for six channels.
  Rgb color(const Vec3& p) const;
  void color_block(const Columns3& p, size_t count, const Columns3& out) const;
};

/// Volume with the same value everywhere: grey, or a colour.
class KINOME_EXPORT UniformVolume : public Volume {
 public:
  explicit UniformVolume(const Rgb& value, const Aabb& box = {Vec3(0.f), Vec3(1.f)});
  uint32_t channels() const override { return channels_; }
  void eval(const Vec3& p, float* values) const override;
  void eval_block(const Columns3& p, size_t count, float* const* values) const override;
  float min() const override { return -max_component(-value_); }
  float max() const override { return max_component(value_); }
  bool is_uniform() const override { return true; }
  Aabb box() const override { return box_; }
  const Rgb& value() const { return value_; }

 private:
  Rgb value_;
  Aabb box_;
  uint32_t channels_;
};

}  // namespace kinome
