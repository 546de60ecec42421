#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "clustered/product/choice/cell_light.h"
#include "clustered/product/tiles/groups.h"
#include "clustered/product/rays/ray_comb.h"
#include "clustered/product/rays/shadow_rays.h"
#include "plugins/integrators/kernels/kernel_helpers.h"
#include "kinome/image_files.h"
#include "kinome/clustered_light.h"
#include "kinome/sensor.h"
#include "support/render.h"
#include "support/sanitizer.h"

/// A tile of a small scene, for tests of the estimator's stages.
namespace kinome::test {

/// False-alarm rate of each statistical test.
inline constexpr double kAlpha = 1e-4;

inline std::string floor_xml(const std::string& material) {
  return R"(<shape type="rectangle"><transform name="to_world"><scale value="9"/>
      <rotate x="1" angle="-90"/></transform>)" +
         material + "</shape>";
}
inline std::string ball_xml(const std::string& material) {
  return R"(<shape type="sphere"><point name="center" x="0" y="0" z="0"/>
      <float name="radius" value=".5"/>)" +
         material + "</shape>";
}
inline std::string rough_xml(const std::string& type, double alpha) {
  return "<bsdf type=\"" + type + "\"><float name=\"alpha\" value=\"" + std::to_string(alpha) +
         "\"/></bsdf>";
}
inline const std::string kGrey =
    R"(<bsdf type="diffuse"><rgb name="reflectance" value=".6 .5 .4"/></bsdf>)";

/// Returns a normal map of one texel around `material`.
inline std::string normal_map_xml(const Rgb& texel, const std::string& material) {
  static const TemporaryFolder folder;
  static int count = 0;
  const std::string path = folder.path("normal" + std::to_string(count++) + ".pfm");
  write_pfm(path, Image{1, 1, {"R", "G", "B"}, {texel.x, texel.y, texel.z}});
  return R"(<bsdf type="normalmap"><texture name="normalmap" type="bitmap">
      <string name="filename" value=")" +
         path + R"("/><boolean name="raw" value="true"/></texture>)" + material + "</bsdf>";
}
/// Wraps `material` in two normal maps that don't turn the normal. Kernels don't support nested
/// normal maps, so such points use the scalar functions.
inline std::string asked_xml(const std::string& material) {
  const Rgb flat(0.5f, 0.5f, 1);
  return normal_map_xml(flat, normal_map_xml(flat, material));
}

/// Returns a sky that is brighter on one side and has no small bright regions.
inline std::string sky_xml() {
  static const TemporaryFolder folder;
  const std::string path = folder.path("sky.pfm");
  Image image{16, 9, {"R", "G", "B"}, {}};
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 16; ++x) {
      const auto a = static_cast<float>(x), b = static_cast<float>(y);
      const float shade = 1.5f + std::sin(0.4f * a) + 0.3f * std::cos(0.7f * b);
      image.data.insert(image.data.end(), {shade, 0.8f * shade, 0.3f + 0.1f * b});
    }
  }
  write_pfm(path, image);
  return "<emitter type=\"envmap\"><string name=\"filename\" value=\"" + path + "\"/></emitter>";
}

/// The camera rays of 4 x 4 pixels that look at the origin from above, with their patches. No
/// visibility of cells has been learned: v = 0.
class StageTile {
 public:
  explicit StageTile(const std::string& shapes_and_lights, uint16_t rays_of_pixel = 2,
                     uint32_t max_depth = 2)
      : scene_(scene_from(
            R"(<sensor type="perspective"><float name="fov" value="9"/>
               <transform name="to_world"><lookat origin="0,3,2" target="0,0,0" up="0,1,0"/>
               </transform><film type="hdrfilm"><integer name="width" value="4"/>
               <integer name="height" value="4"/><rfilter type="box"/></film></sensor>)" +
            shapes_and_lights)),
        table_(*scene_),
        all_({table_, sensor(), PathSettings{{}, true}}),
        primaries_(trace(rays_of_pixel)) {
    make_patches(primaries_, patches_);
    if (scene_->environment()) {
      cells_ = DistantCells(*scene_->environment(), *cell_grid_of(*scene_->environment()), 64,
                            context_.scheduler);
    }
    LocalLight::Settings settings;
    settings.points = LocalLight::kMinPoints;
    settings.length.max_depth = max_depth;
    local_ = std::make_unique<const LocalLight>(*scene_, settings,
                                                std::span<const SurfaceInteraction>(), 1, context_);
    if (local_->empty()) local_.reset();
    const size_t padded = cells_.padded_size() + (local_ ? local_->padded_size() : 0);
    visibility_.assign(patches_.size(), Visibility(padded));
    groups_.divide(primaries_, patches_, 0, static_cast<uint32_t>(primaries_.size()));
  }

  const Scene& scene() const { return *scene_; }
  const TilePrimaries& primaries() const { return primaries_; }
  std::vector<Patch>& patches() { return patches_; }
  std::vector<Visibility>& visibility() { return visibility_; }
  Groups& groups() { return groups_; }
  RenderCounters& counters() { return counters_; }
  GroupView view(uint32_t index) const {
    return groups_.view(index, patches_, visibility_, primaries_);
  }
  /// Draws new points on the light.
  CellLight light(uint64_t seed) {
    CellPoints points;
    if (cells_.size() > 0) points = cells_.draw_points(1 << 10, seed, context_.scheduler);
    LocalPoints local_points;
    if (local_) local_points = local_->draw(hash_words(seed, 1), context_);
    return {cells_, scene_->environment(), std::move(points), local_.get(),
            std::move(local_points)};
  }
  /// Sets the learned visibility to random values. Estimates must be unbiased with any values.
  void guess_visibility() {
    Random random(3);
    for (Visibility& visibility : visibility_) {
      for (size_t c = 0; c < visibility.v.size(); ++c) {
        visibility.v[c] = random.unit();
        visibility.sigma[c] = 0.1f + random.unit();
        visibility.sigma_mixed[c] = 0.1f + random.unit();
      }
    }
  }
  /// Returns the unoccluded light of the sky that the lobes of a group's members reflect, summed,
  /// by the midpoint rule.
  Rgb reflected_sky(const GroupView& group, Lobe lobes) const {
    constexpr int kRows = kHasSanitizer ? 64 : 256;
    Rgb sum(0.f);
    for (uint32_t k = 0; k < group.group.count; ++k) {
      const SurfaceInteraction& si = group.interaction(k);
      for (int row = 0; row < kRows; ++row) {
        const double height = 1 - 2 * (row + 0.5) / kRows, r = std::sqrt(1 - height * height);
        Rgb of_row(0.f);
        for (int column = 0; column < 2 * kRows; ++column) {
          const double phi = kPi * (column + 0.5) / kRows;
          const Vec3 d(r * std::cos(phi), height, r * std::sin(phi));
          of_row += si.shape->bsdf().eval_pdf(si, lobes, si.frame.to_local(d)).f *
                    scene_->environment()->eval_environment(d);
        }
        sum += of_row * (4 * kPi / (2.f * kRows * kRows));
      }
    }
    return sum;
  }

 private:
  const Sensor& sensor() const { return *scene_->sensors().front(); }
  TilePrimaries trace(uint16_t rays_of_pixel) {
    const std::vector<uint16_t> counts(16, rays_of_pixel);
    all_.add(sensor().film().crop(), counts);
    all_.trace(5, counters_);
    return all_.tile(0);
  }

  RenderContext context_{RenderOptions{.threads = 1}};
  RenderCounters counters_;
  std::unique_ptr<Scene> scene_;
  transport::SceneTable table_;
  Primaries all_;
  TilePrimaries primaries_;
  std::vector<Patch> patches_;
  DistantCells cells_;
  std::unique_ptr<const LocalLight> local_;
  std::vector<Visibility> visibility_;
  Groups groups_;
};

/// Means of each colour channel over draws.
class MeanRgb {
 public:
  void add(const Rgb& c) {
    for (int k = 0; k < 3; ++k) of_[k].add(c[k]);
  }
  Rgb mean() const {
    return {static_cast<float>(of_[0].mean()), static_cast<float>(of_[1].mean()),
            static_cast<float>(of_[2].mean())};
  }
  /// Tests each channel by a z-test; the false-alarm rate of all three together is kAlpha.
  void expect(const Rgb& expected, const char* what) const {
    expect({{expected.x, 0}, {expected.y, 0}, {expected.z, 0}}, what);
  }
  void expect(const MeanRgb& expected, const char* what) const {
    expect(expected.estimates(), what);
  }

 private:
  std::vector<Estimate> estimates() const {
    std::vector<Estimate> estimates;
    for (const Moments& m : of_) estimates.push_back({m.mean(), m.variance_of_mean()});
    return estimates;
  }
  void expect(const std::vector<Estimate>& expected, const char* what) const {
    const std::vector<Estimate> found = estimates();
    for (int k = 0; k < 3; ++k) {
      const Estimate &a = found[k], &b = expected[k];
      const double deviation = std::sqrt(a.variance_of_mean + b.variance_of_mean);
      EXPECT_GT(normal_two_sided((a.mean - b.mean) / deviation), kAlpha / 3)
          << what << ", channel " << k << ": " << a.mean << " for " << b.mean << " +- "
          << deviation;
      EXPECT_LT(deviation, 0.02 * b.mean) << what << ": too noisy";
    }
  }

  Moments of_[3];
};

inline constexpr int kDraws = kHasSanitizer ? 100 : 400;
inline constexpr size_t kRays = 24;

/// Returns the mean over draws of add(seed, strata) plus the light that shoot(seed, hits, answers,
/// rays) finds.
template <class Add, class Shoot>
MeanRgb estimate(StageTile& tile, const Add& add, const Shoot& shoot) {
  MeanRgb mean;
  StageTimes times;
  times.count_to(tile.counters());
  ShadowRays rays(times);
  rays.begin(tile.scene(), tile.counters());
  RayComb comb;
  for (uint64_t seed = 0; seed < kDraws; ++seed) {
    Strata strata;
    Rgb sum = add(seed, strata);
    comb.walk(strata, kRays, random_float(seed, 77),
              [&](const SegmentHits& hits) { shoot(seed, hits, Answers{{&sum}}, rays); });
    rays.trace();
    mean.add(sum);
  }
  return mean;
}

}  // namespace kinome::test
