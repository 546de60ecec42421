#pragma once

// Textures as inputs of formulas, at one point or in columns.

#include <algorithm>
#include <memory>
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

/// Texture read as a colour. Uniform textures are evaluated only once.
class ColorInput {
 public:
  explicit ColorInput(std::shared_ptr<const Texture> texture)
      : texture_(std::move(texture)),
        is_uniform_(texture_->is_uniform()),
        value_(is_uniform_ ? texture_->eval(glm::vec2(0.f)) : glm::vec3(0.f)) {}

  bool is_uniform() const { return is_uniform_; }
  glm::vec3 at(const glm::vec2& uv) const { return is_uniform_ ? value_ : texture_->eval(uv); }
  glm::vec3 at(const SurfaceInteraction& si) const {
    return is_uniform_ ? value_ : texture_->eval_at(si);
  }
  const Texture& operator*() const { return *texture_; }
  const Texture* operator->() const { return texture_.get(); }
  const std::shared_ptr<const Texture>& texture() const { return texture_; }

  /// Colours at the points of a block.
  class Columns {
   public:
    Columns(const ColorInput& input, const Columns2& uv, size_t count)
        : value_(input.value_), columns_(3, input.is_uniform_ ? 0 : count) {
      if (input.is_uniform_) return;
      values_ = columns_.three();
      input.texture_->eval_block(uv, count, values_);
    }
    Columns(const ColorInput& input, const SurfaceBlock& points)
        : value_(input.value_), columns_(3, input.is_uniform_ ? 0 : points.count) {
      if (input.is_uniform_) return;
      values_ = columns_.three();
      input.texture_->eval_block_at(points, values_);
    }
    KINOME_WIDE Rgb operator[](size_t i) const {
      return values_.x ? Rgb::load(values_, i) : Rgb(value_);
    }

   private:
    glm::vec3 value_;
    ScratchColumns columns_;
    Columns3 values_;
  };

 private:
  std::shared_ptr<const Texture> texture_;
  bool is_uniform_;
  glm::vec3 value_;
};

/// Texture read as a scalar. Uniform textures are evaluated only once.
class NumberInput {
 public:
  explicit NumberInput(std::shared_ptr<const Texture> texture)
      : texture_(std::move(texture)),
        is_uniform_(texture_->is_uniform()),
        value_(is_uniform_ ? texture_->eval_1(glm::vec2(0.f)) : 0.f) {}

  float at(const glm::vec2& uv) const { return is_uniform_ ? value_ : texture_->eval_1(uv); }
  float at(const SurfaceInteraction& si) const {
    return is_uniform_ ? value_ : texture_->eval_1_at(si);
  }
  const Texture& operator*() const { return *texture_; }
  const Texture* operator->() const { return texture_.get(); }
  const std::shared_ptr<const Texture>& texture() const { return texture_; }

  /// Scalars at the points of a block.
  class Columns {
   public:
    Columns(const NumberInput& input, const Columns2& uv, size_t count)
        : value_(input.value_), columns_(1, input.is_uniform_ ? 0 : count) {
      if (input.is_uniform_) return;
      values_ = columns_[0];
      input.texture_->eval_1_block(uv, count, values_);
    }
    Columns(const NumberInput& input, const SurfaceBlock& points)
        : value_(input.value_), columns_(1, input.is_uniform_ ? 0 : points.count) {
      if (input.is_uniform_) return;
      values_ = columns_[0];
      input.texture_->eval_1_block_at(points, values_);
    }
    KINOME_WIDE Float operator[](size_t i) const {
      return values_ ? Float::load(values_ + i) : Float(value_);
    }

   private:
    float value_;
    ScratchColumns columns_;
    float* values_ = nullptr;
  };

 private:
  std::shared_ptr<const Texture> texture_;
  bool is_uniform_;
  float value_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
