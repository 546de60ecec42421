#pragma once

// Textures as inputs of formulas, at one point or in columns.

#include <algorithm>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "kinome/columns.h"
#include "kinome/texture.h"
#include "kinome/wide/vectors.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Uninitialised columns for the lifetime of the object. Their memory stays with the thread for
/// reuse.
class ScratchColumns {
 public:
  ScratchColumns(size_t columns, size_t count)
      : length_(std::max(padded(count), kBlockLanes)) {  // never empty
    Pool& pool = of_thread();
    if (pool.idle.empty()) {
      pool.idle.reserve(++pool.made);
    } else {
      memory_ = std::move(pool.idle.back());
      pool.idle.pop_back();
    }
    const size_t wanted = columns * length_ / kBlockLanes;
    if (memory_.size() < wanted) memory_.resize(wanted);
  }
  ~ScratchColumns() { of_thread().idle.push_back(std::move(memory_)); }  // never allocates
  ScratchColumns(const ScratchColumns&) = delete;
  ScratchColumns& operator=(const ScratchColumns&) = delete;

  float* operator[](size_t column) const {
    return const_cast<float*>(memory_.data()->v) + column * length_;
  }
  /// Returns columns `first` to first + 2 (or first + 1, for two()).
  Columns3 three(size_t first = 0) const {
    return {(*this)[first], (*this)[first + 1], (*this)[first + 2]};
  }
  Columns2 two(size_t first = 0) const { return {(*this)[first], (*this)[first + 1]}; }

 private:
  struct alignas(kColumnAlignment) Lanes {
    float v[kBlockLanes];
  };
  /// Free memory of the thread, with capacity for all columns ever in use at once.
  struct Pool {
    std::vector<std::vector<Lanes>> idle;
    size_t made = 0;
  };
  static Pool& of_thread() {
    static thread_local Pool pool;
    return pool;
  }
  size_t length_;
  std::vector<Lanes> memory_;
};

/// Texture whose values of type V are read by the given functions of Texture: `eval` and `eval_at`
/// for single points, `eval_block` and `eval_block_at` for columns of type Block. Uniform textures
/// are evaluated only once.
template <class V, class Block, auto eval, auto eval_at, auto eval_block, auto eval_block_at>
class TextureInput {
  static constexpr bool kIsColor = std::is_same_v<Block, Columns3>;

 public:
  explicit TextureInput(std::shared_ptr<const Texture> texture)
      : texture_(std::move(texture)),
        is_uniform_(texture_->is_uniform()),
        value_(is_uniform_ ? ((*texture_).*eval)(glm::vec2(0.f)) : V(0.f)) {}

  bool is_uniform() const { return is_uniform_; }
  V at(const glm::vec2& uv) const { return is_uniform_ ? value_ : ((*texture_).*eval)(uv); }
  V at(const SurfaceInteraction& si) const {
    return is_uniform_ ? value_ : ((*texture_).*eval_at)(si);
  }
  const Texture& operator*() const { return *texture_; }
  const Texture* operator->() const { return texture_.get(); }
  const std::shared_ptr<const Texture>& texture() const { return texture_; }

  /// Values at the points of a block.
  class Columns {
   public:
    Columns(const TextureInput& input, const Columns2& uv, size_t count) : Columns(input, count) {
      if (!input.is_uniform_) ((*input.texture_).*eval_block)(uv, count, values_);
    }
    Columns(const TextureInput& input, const SurfaceBlock& points) : Columns(input, points.count) {
      if (!input.is_uniform_) ((*input.texture_).*eval_block_at)(points, values_);
    }
    KINOME_WIDE auto operator[](size_t i) const {
      if constexpr (kIsColor) {
        return values_.x ? Rgb::load(values_, i) : Rgb(value_);
      } else {
        return values_ ? Float::load(values_ + i) : Float(value_);
      }
    }

   private:
    Columns(const TextureInput& input, size_t count)
        : value_(input.value_), columns_(kIsColor ? 3 : 1, input.is_uniform_ ? 0 : count) {
      if (input.is_uniform_) return;
      if constexpr (kIsColor) {
        values_ = columns_.three();
      } else {
        values_ = columns_[0];
      }
    }

    V value_;
    ScratchColumns columns_;
    Block values_{};
  };

 private:
  std::shared_ptr<const Texture> texture_;
  bool is_uniform_;
  V value_;
};

/// Texture read as a colour, and as a scalar.
using ColorInput = TextureInput<glm::vec3, Columns3, &Texture::eval, &Texture::eval_at,
                                &Texture::eval_block, &Texture::eval_block_at>;
using NumberInput = TextureInput<float, float*, &Texture::eval_1, &Texture::eval_1_at,
                                 &Texture::eval_1_block, &Texture::eval_1_block_at>;

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
