#pragma once

#include <optional>
#include <string>
#include <vector>

#include "checked_scene.h"

namespace kinome::test {

/// Compares the light of methods that have the same expectation; see check_scene().
class MethodComparison {
 public:
  /// `scene` must outlive the object.
  explicit MethodComparison(CheckedScene& scene) : scene_(scene) {}

  /// Compares a method with the one of Method::against. Adds the result to the scene's report.
  void compare_with_other(const Method& method);

 private:
  struct Comparison {
    Agreement agreement;
    double largest = 0;              ///< contribution of a sample, as a fraction of the sum
    double missing = 0;              ///< missing_light() of the standard that is compared with
    double lost = 0;                 ///< missing_light() of the method itself
    bool has_constant_side = false;  ///< all renders of one method are the same
    bool is_chance = false;          ///< one method hardly ever finds what the other does

    /// True if a few samples decide the result.
    bool is_open() const;
  };

  const Method& method_named(const std::string& name) const;
  /// Returns true if both methods have the same expectation in this scene and find its light within
  /// a few thousand samples. Light tracing and emitter sampling can't find what mirrors show, and
  /// hardly ever find what near-mirrors show.
  bool has_expectation_of(const Method& method);
  /// Number of renders of the repetition i of kRepetitions.
  int renders_of_repetition(size_t i, const Method& method, bool is_costly);
  /// `repetition`: index of the repetition; nullopt for the first comparison. Returns nullopt if
  /// some values aren't finite.
  std::optional<Comparison> comparison(const Method& method, const Method& other,
                                       std::optional<size_t> repetition);
  /// Treats identical renders of the last repetition as exact, and sets is_chance.
  void judge_constants(const Method& method, const Method& other, const Renders& own,
                       const Renders& others, std::vector<TileEstimate>& own_tiles,
                       std::vector<TileEstimate>& other_tiles, Comparison& result);
  /// Repeats a suspicious comparison with more renders. Returns the last repetition if the methods
  /// differ in all of them. Returns nullopt otherwise, and reports open comparisons.
  std::optional<Comparison> repeat(const Method& method, const Method& other);
  void leave_open(const Method& method, const Method& other, const std::string& excuse);
  /// Returns nullopt if some values aren't finite.
  std::optional<std::vector<TileEstimate>> long_tiles_of(const Method& method, uint64_t seed);
  /// Returns the reason why a path with a bounce, the standard, is too dark by chance; empty if it
  /// isn't. A path chooses one direction, while light points and photons reach all lit surfaces.
  /// Light from a speck may be missed by a hundred thousand samples, and their variance doesn't
  /// show it. This is accepted in two cases: the longest run agrees and most of the difference is
  /// gone, or that run, too, would expect only a few hits of the brightest reflection for all the
  /// missing light.
  std::string reason_for_missing_light(const Method& standard, const Method& method,
                                       double missing_before);
  /// Returns the reason why `product` is too dark by chance. It distributes rays by unoccluded
  /// light. Bright light that is hidden takes nearly all of them, so that few are left for dim
  /// light.
  std::string reason_for_lost_light(const Method& method, const Comparison& comparison);

  CheckedScene& scene_;
  std::optional<std::vector<TileEstimate>> long_standard_;  ///< see reason_for_missing_light()
};

}  // namespace kinome::test
