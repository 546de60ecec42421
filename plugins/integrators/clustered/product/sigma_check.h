#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "clustered/product/visibility.h"
#include "kinome/render_context.h"

namespace kinome {

/// How far what rays find is from learned visibilities, beside how far the learner expects it to
/// be: (V - v)² over sigma², as a table over sigma² and whether v says hidden, visible or neither.
/// It is told of the pilot's rays, as learned from those around them. How much there is that
/// nobody can foresee is a scene's own: a wall with a window needs rays at few cells, foliage at
/// all.
///
/// tell() may be called by several threads at once, and not beside the others; sums are of
/// integers, so that their order doesn't matter.
class SigmaCheck {
 public:
  void forget();
  /// A ray to a cell that has been learned without it: v in [0, 1], sigma in (0, 1.1].
  void tell(float v, float sigma, float visible);
  /// Makes of the sums those of all processes of a group.
  void add_up(RenderContext& context);
  /// All have been told.
  void finish();
  /// Makes of each sigma what rays found; sigma_mixed, which is for v = 0, stays as it is. Before
  /// finish(): leaves all.
  void correct(Visibility& visibility) const;

 private:
  /// Half octaves of sigma² below 1.
  static constexpr int kSteps = 40;
  static constexpr int kHidden = 0, kVisible = 1, kNeither = 2, kSides = 3;
  /// In integers, of 2^-32.
  struct Sums {
    std::atomic<uint64_t> expected = 0, found = 0;
  };
  std::array<Sums, kSides * kSteps> sums_;
  std::array<float, kSides * kSteps> factor_;  ///< of sigma
  bool is_finished_ = false;
};

}  // namespace kinome
