#include "check.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "kinome/bsdf.h"
#include "kinome/error.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "measure.h"
#include "support/render.h"
#include "xml.h"

namespace kinome::test {
namespace {

constexpr double kSuspicious = 1e-4, kCertain = 1e-6;
/// Of the first comparison, and how many times as many of those that repeat it where it is
/// suspicious.
constexpr int kRenders = 16;
constexpr int kRepetitions[] = {8, 64};
constexpr int kTiles = 2;
/// Of a picture; what was made wrong on purpose may be large.
constexpr double kMostSamples = 4096;
/// A sum of which one sample is this much says nothing yet.
constexpr double kTooMuch = 0.05;

struct Method {
  std::string name;
  std::string integrator;
  std::string against;      ///< the method whose expectation it has; empty: none
  bool same_seeds = false;  ///< differences of renders of one seed
};

std::string clustered(const std::string& importance, int max_depth) {
  return xml::integrator("clustered",
                         xml::text("importance", importance) + xml::integer("light_samples", 100) +
                             xml::integer("cut_size", 20) + xml::integer("emitter_samples", 4) +
                             xml::integer("brdf_samples", 4) + xml::number("rays_per_pixel", 12) +
                             xml::integer("max_depth", max_depth));
}
std::string with_depth(const std::string& type, int max_depth) {
  return xml::integrator(type, xml::integer("max_depth", max_depth));
}
std::string truth(int max_depth) {
  return xml::integrator("groundtruth",
                         xml::integer("light_samples", 100) + xml::integer("max_depth", max_depth));
}

const std::vector<Method>& all_methods() {
  static const std::vector<Method> all = {
      {"direct", xml::integrator("direct"), "emitter sampling"},
      {"emitter sampling",
       xml::integrator("direct",
                       xml::integer("emitter_samples", 1) + xml::integer("bsdf_samples", 0)),
       ""},
      {"path", with_depth("path", 2), "direct"},
      {"ptracer", with_depth("ptracer", 2), "direct"},
      {"product", clustered("product", 2), "direct"},
      {"groundtruth", truth(2), ""},
      {"joint", clustered("joint", 2), "groundtruth", true},
      {"luminance", clustered("luminance", 2), "groundtruth", true},
      {"brdf", clustered("brdf", 2), "groundtruth", true},
      {"path, one bounce", with_depth("path", 3), ""},
      {"ptracer, one bounce", with_depth("ptracer", 3), "path, one bounce"},
      {"product, one bounce", clustered("product", 3), "path, one bounce"},
      {"groundtruth, one bounce", truth(3), ""},
      {"joint, one bounce", clustered("joint", 3), "groundtruth, one bounce", true},
      {"path, any length", xml::integrator("path"), ""},
  };
  return all;
}

const Method& method_named(const std::string& name) {
  for (const Method& method : all_methods()) {
    if (method.name == name) return method;
  }
  throw Error("no method '" + name + "'");
}

class Checker {
 public:
  Checker(const std::string& text, const std::string& folder) : text_(text), folder_(folder) {}

  CheckReport run(const std::string& only) {
    for (const Method& method : all_methods()) {
      if (!only.empty() && method.name != only) continue;
      try {
        if (!check(method)) break;
      } catch (const Error& error) {
        // Of a scene that had been loaded before: as good as one at loading.
        report_.refused = error.what();
        break;
      } catch (const std::exception& error) {
        report_.findings.push_back({"exception", method.name, error.what()});
      }
    }
    return report_;
  }

 private:
  const Scene& scene_of(const Method& method) {
    auto& scene = scenes_[method.name];
    if (!scene) {
      const size_t at = text_.find("<sensor");
      std::string whole = text_;
      whole.insert(at == std::string::npos ? text_.rfind("</scene") : at, integrator(method));
      LoadOptions options;
      options.search_paths = {folder_};
      options.threads = 1;
      scene = load_scene_from_string(whole, folder_ + "/scene.xml", options, registry());
    }
    return *scene;
  }

  /// `ptracer` doesn't show environments: where there is one, no integrator is to.
  std::string integrator(const Method& method) const {
    std::string xml = method.integrator;
    const bool has_sky = text_.find("\"constant\"") != std::string::npos ||
                         text_.find("\"envmap\"") != std::string::npos;
    if (has_sky) xml.insert(xml.rfind("</"), xml::boolean("hide_emitters", true));
    return xml + "\n";
  }

  const Renders& renders_of(const Method& method) {
    auto& renders = renders_[method.name];
    if (renders.pixels.empty()) {
      renders = render_often(scene_of(method), kRenders, first_seed(method));
    }
    return renders;
  }
  /// Independent estimates have seeds of their own; those that are compared seed by seed share one.
  uint64_t first_seed(const Method& method) const {
    if (method.name.starts_with("groundtruth") || method.same_seeds) return 1;
    uint64_t number = 1;
    for (const Method& m : all_methods()) {
      if (&m == &method) break;
      ++number;
    }
    return number * 1000;
  }

  /// False where the scene is refused: then it is by all.
  bool check(const Method& method) {
    try {
      scene_of(method);
    } catch (const Error& error) {
      report_.refused = error.what();
      if (report_.refused.find('\n') != std::string::npos) {
        report_.findings.push_back({"exception", "load", "an error of many lines"});
      }
      return false;
    }
    const Scene& scene = scene_of(method);
    const Sensor& sensor = *scene.sensors().at(0);
    if (double{1} * sensor.film().crop().area() * sensor.sampler().sample_count() > kMostSamples) {
      report_.refused = "a picture too large to be rendered many times";
      return false;
    }
    const Renders one = render_often(scene, 1, 7, 1), two = render_often(scene, 1, 7, 2);
    if (one.pixels[0].size() != two.pixels[0].size() ||
        std::memcmp(one.pixels[0].data(), two.pixels[0].data(),
                    one.pixels[0].size() * sizeof(float)) != 0) {
      report_.findings.push_back({"threads", method.name, "one thread and two give other bits"});
    }
    const Renders& renders = renders_of(method);
    if (renders.non_finite > 0) {
      report_.findings.push_back(
          {"not finite", method.name, std::to_string(renders.non_finite) + " values"});
      return true;
    }
    if (!method.against.empty() && has_expectation_of(method, scene)) compare_with_other(method);
    return true;
  }

  /// Whether both estimate the same in this scene, and find it within a few thousand samples: what
  /// mirrors show can't be found from the light, nor by emitter sampling, and what all but mirrors
  /// show hardly ever is.
  bool has_expectation_of(const Method& method, const Scene& scene) const {
    bool has_mirrors = false;
    for (const auto& shape : scene.shapes()) {
      has_mirrors |= any(shape->bsdf().lobes() & Lobe::kDelta);
    }
    const bool is_light_tracing = method.name.starts_with("ptracer");
    const bool is_product = method.name.starts_with("product");
    const bool has_bounce = method.name.ends_with("one bounce");
    const bool is_blunt = is_light_tracing || method.name == "direct";
    if (is_blunt && (has_mirrors || has_sharp_lobes())) return false;
    // With hide_emitters (see integrator_of), `ptracer` alone shows what surfaces that emit
    // reflect.
    if (is_light_tracing && scene.environment() && scene.has_surface_emitters()) return false;
    // It has light that lamps send on by mirrors, and nearly; `path` hasn't, or hardly ever.
    if (is_product && has_bounce && (has_mirrors || has_sharp_lobes())) return false;
    if (is_product && !has_bounce) {
      // As `joint`, it has the expectation of points where there is an environment among others.
      return scene.emitters().size() <= 1 || !scene.environment();
    }
    return true;
  }

  /// By the scene's text: whether anything is so smooth that its lobe is a matter of luck.
  bool has_sharp_lobes() const {
    constexpr double kLeastAlpha = 0.03, kLargestExponent = 1000;
    for (const char* name : {"\"alpha\"", "\"alpha_u\"", "\"alpha_v\"", "\"exponent\""}) {
      const bool is_exponent = std::string(name) == "\"exponent\"";
      for (size_t at = text_.find(name); at != std::string::npos; at = text_.find(name, at + 1)) {
        const size_t value = text_.find("value=\"", at);
        if (value == std::string::npos) break;
        const double v = std::strtod(text_.c_str() + value + 7, nullptr);
        if (is_exponent ? v > kLargestExponent : v < kLeastAlpha) return true;
      }
    }
    return false;
  }

  /// `repetition`: in kRepetitions; nullopt: the first comparison.
  Agreement agreement(const Method& method, const Method& other, std::optional<size_t> repetition,
                      double& largest) {
    Renders own, others;
    if (repetition) {
      const int count = kRenders * kRepetitions[*repetition];
      const uint64_t seed = 200'001 + 400'000 * uint64_t{*repetition};
      own = render_often(scene_of(method), count, seed);
      others = render_often(scene_of(other), count, method.same_seeds ? seed : seed + 100'000);
    } else {
      own = renders_of(method);
      others = renders_of(other);
    }
    largest = std::max(own.tails().largest, others.tails().largest);
    if (own.non_finite + others.non_finite > 0) return {};  // found elsewhere
    if (!method.same_seeds) {
      return compare(estimate_tiles_of(own, kTiles), estimate_tiles_of(others, kTiles));
    }
    const auto difference = estimate_tile_differences(own, others, kTiles);
    std::vector<double> scale;
    for (const TileEstimate& tile : estimate_tiles_of(others, kTiles)) {
      scale.push_back(std::abs(tile.estimate.mean));
    }
    return compare(difference, exact_zeros(difference.size()), scale);
  }

  void compare_with_other(const Method& method) {
    const Method& other = method_named(method.against);
    ++report_.comparisons;
    double largest = 0;
    if (agreement(method, other, std::nullopt, largest).p >= kSuspicious) return;
    Agreement longer;
    // Light that a hundred renders don't find once may be found by a thousand.
    for (size_t i = 0; i < std::size(kRepetitions); ++i) {
      longer = agreement(method, other, i, largest);
      if (longer.p >= kCertain) return;
      if (longer.is_open || largest > kTooMuch) {
        ++report_.open;
        return;
      }
    }
    report_.findings.push_back(
        {"differs", method.name,
         fmt::format("from {}: z = {:.1f}, {}; largest contribution {:.2g} of the sum", other.name,
                     longer.worst_z, longer.text, largest)});
  }

  const std::string text_, folder_;
  CheckReport report_;
  std::map<std::string, std::unique_ptr<Scene>> scenes_;
  std::map<std::string, Renders> renders_;
};

}  // namespace

std::vector<std::string> check_methods() {
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  return names;
}

std::string integrator_of(const std::string& method) {
  return method_named(method).integrator;
}

CheckReport check_scene(const std::string& text, const std::string& folder,
                        const std::string& only) {
  return Checker(text, folder).run(only);
}

}  // namespace kinome::test
