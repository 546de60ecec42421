#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kinome/block_points.h"
#include "kinome/bsdf.h"
#include "kit/scenes/block_memory.h"

/// Blocks of surface points, for tests of BSDFs.
namespace kinome::check {

/// Arguments of a BSDF's functions at one point.
struct BsdfQuestion {
  SurfaceInteraction si;
  Vec3 wo{0, 0, 1};
  float u1 = 0;
  Vec2 u2{0};
};

/// Results of a BSDF's functions at one point.
struct BsdfReply {
  BsdfValue value;
  BsdfSample sample;  ///< pdf 0: no sample
};

/// Arguments and results of shade_block(). Values that aren't set are NaN.
class BsdfBlock {
 public:
  explicit BsdfBlock(const std::vector<BsdfQuestion>& questions)
      : columns_(questions.size()), shape_(padded(questions.size()), nullptr) {
    points = columns_.surface(questions.size(), shape_.data());
    query = {columns_.three(), columns_.one(), columns_.two()};
    answer = {columns_.three(), columns_.one(), columns_.three(),
              columns_.three(), columns_.one(), columns_.one()};
    for (size_t i = 0; i < questions.size(); ++i) set(i, questions[i]);
  }

  BsdfReply reply(size_t i) const {
    BsdfReply r;
    r.value = {answer.f.at(i), answer.pdf[i]};
    r.sample = {answer.wo.at(i), answer.sample_pdf[i], answer.weight.at(i),
                answer.is_delta[i] == kNullSample ? Lobe::kDelta | Lobe::kNull
                : answer.is_delta[i] == 1         ? Lobe::kDelta
                                                  : Lobe::kNone};
    return r;
  }

  /// Returns true if a function wrote beyond a column's padding.
  bool is_overrun() const { return columns_.is_overrun(); }

  SurfaceBlock points;
  BsdfQuery query;
  BsdfAnswer answer;

 private:
  void set(size_t i, const BsdfQuestion& q) {
    set_point(points, i, q.si);
    query.wo.set(i, q.wo), query.u1[i] = q.u1, query.u2.set(i, q.u2);
  }

  BlockMemory columns_;
  std::vector<const Shape*> shape_;
};

/// Calls the BSDF's functions for single points.
inline BsdfReply reply_at(const Bsdf& bsdf, const BsdfQuestion& q) {
  return {bsdf.eval_pdf(q.si, Lobe::kAll, q.wo),
          bsdf.sample(q.si, Lobe::kAll, q.u1, q.u2).value_or(BsdfSample{})};
}

}  // namespace kinome::check
