#include "check.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "kinome/error.h"
#include "kinome/film.h"
#include "kinome/plugin_audit.h"
#include "kinome/render_context.h"
#include "kinome/sensor.h"
#include "luck.h"
#include "measure.h"
#include "support/render.h"

namespace kinome::test {
namespace {

constexpr double kSuspicious = 1e-4, kCertain = 1e-6;
/// Number of renders of the first comparison, and number of repetitions if it is suspicious. The
/// last repetition has as many renders as a number of samples allows. Cheap methods find rarely
/// what the others find reliably. If clusters nearly always miss a point next to a surface, even a
/// thousand renders are all too dark, and their variance doesn't show it.
constexpr int kRenders = 16;
constexpr size_t kRepetitions = 3;
constexpr double kMaxSamples = 8e6, kMaxSamplesOfCostly = 2e6;
/// The last repetition has between these multiples of the renders of the one before.
constexpr int kMinFactor = 2, kMaxFactor = 32, kMaxFactorOfCostly = 4;
constexpr int kTiles = 2;
/// Samples per image; an invalid scene may have many more.
constexpr double kMaxImageSamples = 4096;
/// Expected number of hits below which light is found only by chance.
constexpr double kMinHits = 10;
/// Expected number of hits below which light is hardly ever found.
constexpr double kMinHiddenHits = 1;
/// A comparison is open if a single sample contributes a larger fraction of the sum.
constexpr double kMaxContribution = 0.05;

/// True if all renders are identical.
bool is_constant(const std::vector<TileEstimate>& tiles) {
  return std::all_of(tiles.begin(), tiles.end(),
                     [](const TileEstimate& tile) { return tile.estimate.variance_of_mean == 0; });
}
void make_exact(std::vector<TileEstimate>& tiles) {
  for (TileEstimate& tile : tiles) {
    tile.freedom = tile.spread = std::numeric_limits<double>::infinity();
  }
}
/// Returns how much less light b has than a, in the tile and channel with the largest difference
/// beyond noise.
double missing_light(const std::vector<TileEstimate>& a, const std::vector<TileEstimate>& b) {
  constexpr double kNoise = 4;
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const Estimate &more = a[i].estimate, &less = b[i].estimate;
    const double missing = more.mean - less.mean;
    const double noise = std::sqrt(more.variance_of_mean + less.variance_of_mean);
    if (missing > kNoise * noise) most = std::max(most, missing);
  }
  return most;
}

class Checker {
 public:
  Checker(const std::string& text, const std::string& folder, const CheckTask& task)
      : text_(text), folder_(folder), task_(task) {}

  CheckReport run() {
    for (const Method& method : task_.methods) {
      if (task_.only.empty() || method.name == task_.only) left_.push_back(&method);
    }
    const auto at_loading = refusals([&](const Method& method) { scene_of(method); });
    for (const Refusal& refusal : at_loading) {
      if (refusal.error.find('\n') == std::string::npos) continue;
      report_.findings.push_back({"exception", "load", "an error of many lines"});
      break;
    }
    judge(at_loading);
    check_plugins();
    judge(refusals([&](const Method& method) { check_alone(method); }));
    const auto at_comparing = refusals([&](const Method& method) { compare_with_other(method); });
    for (const Refusal& refusal : at_comparing) add_finding(refusal);
    return report_;
  }

 private:
  struct Refusal {
    std::string method, error;
  };

  /// Runs a step with each remaining method and returns the errors. Methods with an error are
  /// excluded from later steps, so that one method's error doesn't hide findings of others.
  template <class Step>
  std::vector<Refusal> refusals(const Step& step) {
    std::vector<Refusal> refusals;
    std::vector<const Method*> left;
    for (const Method* method : left_) {
      try {
        step(*method);
        left.push_back(method);
        continue;
      } catch (const Error& error) {
        if (!is_loaded(*method) || !has_too_much_flux(*method)) {
          refusals.push_back({method->name, error.what()});
        }
      } catch (const std::exception& error) {
        report_.findings.push_back({"exception", method->name, error.what()});
      }
      out_.insert(method->name);
    }
    left_ = left;
    return refusals;
  }
  /// A scene must be refused by all methods or by none.
  void judge(const std::vector<Refusal>& refusals) {
    if (refusals.empty()) return;
    if (!left_.empty()) {
      for (const Refusal& refusal : refusals) add_finding(refusal);
      return;
    }
    report_.refused = refusals[0].error;
    // An error message is no excuse: of 1100 valid scenes of random_scene(), including extreme
    // ones, none was refused.
    if (task_.is_valid) add_finding({"load", report_.refused});
  }
  void add_finding(const Refusal& refusal) {
    report_.findings.push_back({"refused", refusal.method, refusal.error});
  }

  const Method& method_named(const std::string& name) const {
    for (const Method& method : task_.methods) {
      if (method.name == name) return method;
    }
    throw std::logic_error("no method '" + name + "'");
  }

  /// The project's plugins must pass the audit.
  void check_plugins() {
    constexpr uint32_t kPlaces = 256;
    if (left_.empty()) return;
    const Scene& scene = scene_of(*left_[0]);
    for (const PluginFault& fault : audit_plugins(scene, *scene.sensors().at(0), 1, kPlaces)) {
      report_.findings.push_back(
          {"fault", fault.plugin,
           fmt::format("{}, at {} of {} places", fault.what, fault.count, fault.looks)});
    }
  }

  const Scene& scene_of(const Method& method) {
    auto& scene = scenes_[method.name];
    if (!scene) {
      const size_t at = text_.find("<sensor");
      std::string whole = text_;
      whole.insert(at == std::string::npos ? text_.rfind("</scene") : at,
                   integrator_of(method, text_) + "\n");
      LoadOptions options;
      options.search_paths = {folder_};
      options.threads = 1;
      scene = load_scene_from_string(whole, folder_ + "/scene.xml", options, registry());
    }
    return *scene;
  }

  const Renders& renders_of(const Method& method) {
    auto& renders = renders_[method.name];
    if (renders.pixels.empty()) {
      renders = render_often(scene_of(method), kRenders, first_seed(method));
    }
    return renders;
  }
  /// Independent estimates use different seeds; methods that are compared seed by seed share one.
  uint64_t first_seed(const Method& method) const {
    if (method.name.starts_with("groundtruth") || method.same_seeds) return 1;
    uint64_t number = 1;
    for (const Method& m : task_.methods) {
      if (&m == &method) break;
      ++number;
    }
    return number * 1000;
  }

  void check_alone(const Method& method) {
    const Scene& scene = scene_of(method);
    if (samples_of(method) > kMaxImageSamples) {
      throw Error("a picture too large to be rendered many times");
    }
    const Renders one = render_often(scene, 1, 7, 1), two = render_often(scene, 1, 7, 2);
    if (one.pixels[0].size() != two.pixels[0].size() ||
        std::memcmp(one.pixels[0].data(), two.pixels[0].data(),
                    one.pixels[0].size() * sizeof(float)) != 0) {
      report_.findings.push_back({"threads", method.name, "one thread and two give other bits"});
    }
    if (is_finite(method, one) && is_finite(method, two)) is_finite(method, renders_of(method));
  }

  bool is_loaded(const Method& method) const {
    const auto scene = scenes_.find(method.name);
    return scene != scenes_.end() && scene->second;
  }
  /// Returns true if the method may exceed single precision here: it follows light from the
  /// emitters, and the scene is both bright and large. Adds one excuse.
  bool has_too_much_flux(const Method& method) {
    const bool starts_at_sensor = method.name.starts_with("path") || method.name == "direct" ||
                                  method.name == "emitter sampling";
    if (starts_at_sensor) return false;
    const bool follows_sky =
        method.name.starts_with("ptracer") || method.name.ends_with("one bounce");
    if (!has_vast_flux(scene_of(method), follows_sky)) return false;
    report_.excuses.push_back(method.name + ": more flux than single precision holds");
    return true;
  }

  /// Adds one finding per method if some values aren't finite.
  bool is_finite(const Method& method, const Renders& renders) {
    if (renders.non_finite == 0) return true;
    if (not_finite_.insert(method.name).second && !has_too_much_flux(method)) {
      report_.findings.push_back(
          {"not finite", method.name, std::to_string(renders.non_finite) + " values"});
    }
    return false;
  }

  /// Returns true if both methods have the same expectation in this scene and find its light within
  /// a few thousand samples. Light tracing and emitter sampling can't find what mirrors show, and
  /// hardly ever find what near-mirrors show.
  bool has_expectation_of(const Method& method) {
    const Scene& scene = scene_of(method);
    const bool is_light_tracing = method.name.starts_with("ptracer");
    const bool is_product = method.name.starts_with("product");
    const bool has_bounce = method.name.ends_with("one bounce");
    const bool is_blunt = is_light_tracing || method.against == "emitter sampling";
    const bool has_mirror = has_mirrors(scene), is_sharp = has_sharp_lobes(text_, kMinAlpha);
    if (is_blunt && (has_mirror || has_sharp_lobes(text_, kMinBluntAlpha))) return false;
    // With hide_emitters (see integrator()), only `ptracer` shows light that reflects off emitting
    // surfaces.
    if (is_light_tracing && scene.environment() && scene.has_surface_emitters()) return false;
    if (is_light_tracing && (has_specks(scene) || has_needles(text_))) return false;
    // Clusters are chosen by the lobe at one of their points, so that a sharp lobe at other points
    // finds light only by chance. The same holds for light points on glossy surfaces, because
    // clusters are chosen without regard to these lobes.
    if (method.same_seeds && (is_sharp || (has_bounce && has_sharp_lobes(text_, kMinBluntAlpha))))
      return false;
    // `product` includes light of lamps by way of mirrors and near-mirrors; `path` never or hardly
    // ever does.
    if (is_product && has_bounce && (has_mirror || is_sharp)) return false;
    if (is_product && !has_bounce) {
      // Like `joint`, it has the expectation of the light points if an environment is one of
      // several emitters.
      return scene.emitters().size() <= 1 || !scene.environment();
    }
    return true;
  }

  /// Number of samples of one comparison, assuming one per pixel.
  static double number_of_pixels(const Renders& renders) {
    return static_cast<double>(renders.pixels.size() * renders.pixels[0].size()) / 3;
  }

  struct Comparison {
    Agreement agreement;
    double largest = 0;              ///< contribution of a sample, as a fraction of the sum
    double missing = 0;              ///< missing_light() of the standard that is compared with
    double lost = 0;                 ///< missing_light() of the method itself
    bool has_constant_side = false;  ///< all renders of one method are the same
    bool is_chance = false;          ///< one method hardly ever finds what the other does

    /// True if a few samples decide the result.
    bool is_open() const { return agreement.is_open || largest > kMaxContribution || is_chance; }
  };

  static bool is_cheap(const Method& method) {
    return !method.name.starts_with("product") && !method.same_seeds &&
           !method.name.starts_with("groundtruth");
  }
  double samples_of(const Method& method) {
    const Sensor& sensor = *scene_of(method).sensors().at(0);
    return double{1} * sensor.film().crop().area() * sensor.sampler().sample_count();
  }
  /// Number of renders of the repetition i of kRepetitions.
  int renders_of_repetition(size_t i, const Method& method, bool is_costly) {
    if (i + 1 < kRepetitions) return task_.repeated[i];
    const int before = task_.repeated.back();
    const double samples = is_costly ? kMaxSamplesOfCostly : kMaxSamples;
    return static_cast<int>(
        std::clamp<double>(samples / samples_of(method), kMinFactor * before,
                           (is_costly ? kMaxFactorOfCostly : kMaxFactor) * before));
  }

  /// `repetition`: index of the repetition; nullopt for the first comparison. Returns nullopt if
  /// some values aren't finite.
  std::optional<Comparison> comparison(const Method& method, const Method& other,
                                       std::optional<size_t> repetition) {
    Renders own, others;
    if (repetition) {
      const bool is_costly = !is_cheap(method) || !is_cheap(other);
      const int count = renders_of_repetition(*repetition, method, is_costly);
      const uint64_t seed = 200'001 + 400'000 * uint64_t{*repetition};
      own = render_often(scene_of(method), count, seed);
      others = render_often(scene_of(other), count, method.same_seeds ? seed : seed + 100'000);
    } else {
      own = renders_of(method);
      others = renders_of(other);
    }
    const bool is_own_finite = is_finite(method, own);
    if (!is_finite(other, others) || !is_own_finite) return {};
    auto own_tiles = estimate_tiles_of(own, kTiles),
         other_tiles = estimate_tiles_of(others, kTiles);
    Comparison result;
    result.largest = std::max(own.tails().largest, others.tails().largest);
    result.missing = missing_light(own_tiles, other_tiles);
    result.lost = missing_light(other_tiles, own_tiles);
    result.has_constant_side = is_constant(own_tiles) || is_constant(other_tiles);
    if (method.same_seeds) {
      const auto difference = estimate_tile_differences(own, others, kTiles);
      std::vector<double> scale;
      for (const TileEstimate& tile : other_tiles) scale.push_back(std::abs(tile.estimate.mean));
      result.agreement = compare(difference, exact_zeros(difference.size()), scale);
      return result;
    }
    if (repetition && *repetition + 1 == kRepetitions) {
      // If a thousand renders are identical, that isn't chance but the method's result: a method
      // that loses all samples is black.
      const bool is_light_tracing = method.name.starts_with("ptracer");
      // A hundred photons give a rough estimate of the variance; an image without light needs more.
      const double few = is_constant(own_tiles) ? 3000 : 100;
      result.is_chance =
          is_light_tracing && has_small_sight(scene_of(method), number_of_pixels(own), few);
      // Splats also show the tails of a filter, which camera rays hardly ever reach.
      const bool may_be_missed =
          has_faint_lobes(text_) ||
          (is_light_tracing && (text_.find("\"box\"") == std::string::npos ||
                                is_hardly_seen(scene_of(other), number_of_pixels(others))));
      if (is_constant(own_tiles)) make_exact(own_tiles);
      if (is_constant(other_tiles)) {
        result.is_chance |= may_be_missed;
        make_exact(other_tiles);
      }
    }
    result.agreement = compare(own_tiles, other_tiles);
    return result;
  }

  /// Returns nullopt if some values aren't finite.
  std::optional<std::vector<TileEstimate>> long_tiles_of(const Method& method, uint64_t seed) {
    const int count = renders_of_repetition(kRepetitions - 1, method, !is_cheap(method));
    const Renders renders = render_often(scene_of(method), count, seed);
    if (!is_finite(method, renders)) return {};
    auto tiles = estimate_tiles_of(renders, kTiles);
    if (is_constant(tiles)) make_exact(tiles);
    return tiles;
  }

  /// Returns the reason why a path with a bounce, the standard, is too dark by chance; empty if it
  /// isn't. A path chooses one direction, while light points and photons reach all lit surfaces.
  /// Light from a speck may be missed by a hundred thousand samples, and their variance doesn't
  /// show it. This is accepted in two cases: the longest run agrees and most of the difference is
  /// gone, or that run, too, would expect only a few hits of the brightest reflection for all the
  /// missing light.
  std::string luck_of(const Method& standard, const Method& method, double missing_before) {
    if (standard.name != "path, one bounce") return "";
    const auto tiles = long_tiles_of(method, 3'500'001);
    if (!long_standard_) long_standard_ = long_tiles_of(standard, 2'000'001);
    if (!tiles || !long_standard_) return "";
    if (missing_light(*long_standard_, *tiles) > 0) return "";  // light that only paths find
    const double missing = missing_light(*tiles, *long_standard_);
    if (!(missing > 0)) return "";  // the difference is in the sum of all tiles
    if (compare(*tiles, *long_standard_).p >= kCertain && missing < 0.5 * missing_before) {
      return "longer paths find it";
    }
    // Samples of each pixel, because tiles sum the radiances of pixels.
    const double samples =
        renders_of_repetition(kRepetitions - 1, standard, false) *
        static_cast<double>(scene_of(standard).sensors().at(0)->sampler().sample_count());
    const double hits = samples * missing / brightest_reflection(scene_of(standard));
    return hits < kMinHits ? fmt::format("paths would find it {:.2g} times", hits) : "";
  }

  /// Returns the reason why `product` is too dark by chance. It distributes rays by unoccluded
  /// light. Bright light that is hidden takes nearly all of them, so that few are left for dim
  /// light.
  std::string luck_of_product(const Method& method, const Comparison& comparison) {
    if (method.name != "product") return "";
    if (!(comparison.lost > 0) || comparison.missing > 0) return "";
    const double hidden = brightest_hidden(scene_of(method));
    if (!(hidden > 0)) return "";
    const double rays =
        kRaysPerPixel * renders_of_repetition(kRepetitions - 1, method, true);
    const double hits = rays * comparison.lost / hidden;
    return hits < kMinHiddenHits ? fmt::format("beside hidden light it is met {:.2g} times", hits)
                                 : "";
  }

  void compare_with_other(const Method& method) {
    if (method.against.empty() || !has_expectation_of(method)) return;
    const Method& other = method_named(method.against);
    if (out_.contains(other.name)) return;
    if (not_finite_.contains(method.name) || not_finite_.contains(other.name)) return;
    const auto first = comparison(method, other, std::nullopt);
    if (!first) return;
    ++report_.comparisons;
    if (first->agreement.p >= kSuspicious) return;
    std::optional<Comparison> longer;
    std::string sure;  // the result of a thousand renders
    const auto leave_open = [&](const std::string& excuse) {
      ++report_.open;
      report_.excuses.push_back(fmt::format("{} and {}: {}", method.name, other.name, excuse));
    };
    const size_t repetitions = kRepetitions;
    for (size_t i = 0; i < repetitions; ++i) {
      longer = comparison(method, other, i);
      if (!longer) return;
      const bool is_last = i + 1 == repetitions;
      const bool differs = longer->agreement.p < kCertain;
      if (!sure.empty() && (!differs || longer->is_open())) {
        const char* const why = !differs            ? "more renders aren't sure"
                                : longer->is_chance ? "one method hardly ever finds it"
                                                    : "of more renders few samples decide";
        return leave_open(fmt::format("{}: {}: {}", sure, why, longer->agreement.text));
      }
      if (!differs) return;
      if (!longer->is_open()) {
        if (i + 2 == repetitions) sure = longer->agreement.text;
        continue;
      }
      // Light that a hundred renders miss may be found by a thousand. If one method finds none, a
      // thousand renders show whether it ever does. If both find some, and a few samples decide,
      // more renders hardly help: they may find only the dim part, with a plausible variance, and
      // still miss the bright part. That took much time and gave two false alarms in 150 scenes: a
      // lamp too thin for rays from the sensor, and a lobe that samples of a lamp as large as the
      // sky hardly ever meet.
      if (is_last || !longer->has_constant_side) {
        ++report_.open;
        return;
      }
    }
    std::string excuse;
    if (longer->agreement.has_more) {
      excuse = luck_of(other, method, longer->missing);
    } else {
      excuse = luck_of_product(method, *longer);
    }
    if (!excuse.empty()) return leave_open(longer->agreement.text + ": " + excuse);
    report_.findings.push_back(
        {"differs", method.name,
         fmt::format("from {}: z = {:.1f}, {}; largest contribution {:.2g} of the sum", other.name,
                     longer->agreement.worst_z, longer->agreement.text, longer->largest)});
  }

  const std::string text_, folder_;
  const CheckTask& task_;
  CheckReport report_;
  std::vector<const Method*> left_;   ///< the remaining methods of the task
  std::set<std::string> out_;         ///< methods that can't render the scene
  std::set<std::string> not_finite_;  ///< methods with values that aren't finite
  std::map<std::string, std::unique_ptr<Scene>> scenes_;
  std::map<std::string, Renders> renders_;                  ///< those of the first comparison
  std::optional<std::vector<TileEstimate>> long_standard_;  ///< see luck_of
};

}  // namespace

CheckReport check_scene(const std::string& text, const std::string& folder, const CheckTask& task) {
  return Checker(text, folder, task).run();
}

std::string reason_of(const std::string& error) {
  // "FOLDER/scene.xml:LINE:COLUMN: "
  const std::string file = "/scene.xml:";
  const size_t at = error.find(file);
  if (at == std::string::npos) return error;
  const size_t end = error.find_first_not_of("0123456789: ", at + file.size());
  return end == std::string::npos ? error : error.substr(end);
}

}  // namespace kinome::test
