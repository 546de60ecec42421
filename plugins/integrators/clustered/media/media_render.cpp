#include "clustered/media/media_render.h"

#include <algorithm>
#include <cmath>

#include "clustered/media/fog_block.h"
#include "clustered/method.h"
#include "kinome/stats.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/media/paths/volume_block.h"

namespace kinome {
namespace {

/// A trial is repeated for a pass whose trial has this many times as many blocks.
constexpr size_t kMinTrialGrowth = 2;
/// Ratio of the times of a sample of both methods that is allowed for when the method changes.
constexpr double kMaxSlowdown = 4;

/// True if the film's alpha depends on light that goes straight through surfaces. FogBlock doesn't
/// follow alpha behind them.
bool has_alpha_behind_surfaces(const Scene& scene, const Sensor& sensor, bool hide_emitters) {
  if (!sensor.film().has_alpha() || (scene.environment() && !hide_emitters)) return false;
  return std::any_of(scene.shapes().begin(), scene.shapes().end(), [](const auto& shape) {
    return shape->bsdf().has_null_lobe() && !shape->bsdf().is_invisible();
  });
}

}  // namespace

const char* MediaRender::why_paths(const Scene& scene, const Sensor& sensor,
                                   const PathSettings& settings) {
  const bool has_grids = std::any_of(scene.media().begin(), scene.media().end(),
                                     [](const Medium* medium) { return !medium->is_uniform(); });
  if (has_grids) return "the scene has media that vary in space";
  if (settings.length.max_depth < 2 || scene.emitters().empty() ||
      has_alpha_behind_surfaces(scene, sensor, settings.hide_emitters)) {
    return "candidates in media don't suit this scene";
  }
  const transport::MediaTable media(scene, sensor);
  const uint32_t start = media.start();
  const bool is_open = start == transport::MediaTable::kVacuum || media.emitter_weight(start) == 1;
  return is_open ? nullptr : "the camera is inside of a medium with a surface";
}

MediaRender::MediaRender(const Scene& scene, const Sensor& sensor, const PathSettings& settings,
                         bool has_trial, RenderContext& context)
    : sensor_(sensor),
      settings_(settings),
      has_trial_(has_trial),
      context_(context),
      media_(scene, sensor),
      table_(scene, media_.phases()) {
  const StageTimer timer(context.job.stats().counters.stage_seconds["cells"]);
  sources_ = std::make_unique<FogSources>(scene, context.scheduler);
}

/// Divides the sunlight and learns its beams for FogBlock, once.
void MediaRender::find_sunlight() {
  if (has_sunlight_) return;
  has_sunlight_ = true;
  const StageTimer timer(context_.job.stats().counters.stage_seconds["cells"]);
  const double samples =
      static_cast<double>(sensor_.film().crop().area()) * sensor_.sampler().sample_count();
  sources_->find_suns(table_, media_, samples, context_);
  if (settings_.length.max_depth > 2) {
    sources_->find_beams(table_, media_, sensor_, samples, context_);
  }
}

void MediaRender::choose(const Sensor& sensor) {
  const size_t blocks = has_trial_ ? blocks_of_trial(sensor) : 0;
  if (has_trial_ && blocks == 0 && tried_ == 0) choice_ = choose_untried(settings_, *sources_);
  const bool tries = blocks > 0 && blocks >= kMinTrialGrowth * tried_;
  if (tries || !choice_.uses_paths) find_sunlight();
  if (!tries) return;
  choice_ = try_methods(table_, media_, *sources_, sensor, settings_, blocks, context_);
  tried_ = blocks;
}

void MediaRender::render(const Sensor& sensor) const {
  if (choice_.uses_paths) {
    const char* const reason = "paths from the camera alone do as well in the media for less";
    context_.job.skip("product", reason);
    report_method(context_, kVolpath, reason);
    return transport::render_volumes(table_, media_, settings_, sensor, context_);
  }
  report_method(context_, "candidates in media",
                has_trial_ ? "in a trial, volpath took more work for the same error"
                           : "the parameter 'trial' is false");
  transport::render_tiles<FogBlock>(
      sensor, context_, 0,
      [&] {
        return std::make_unique<FogBlock>(table_, media_, *sources_, sensor, settings_,
                                          choice_.paths);
      },
      [](FogBlock& block, const PixelSamples& samples, Tile& tile) {
        block.render(samples, tile);
      });
}

namespace {

class MediaPasses final : public Passes {
 public:
  MediaPasses(const Scene& scene, const Sensor& sensor, const PathSettings& settings,
              bool has_trial, RenderContext& context)
      : sensor_(sensor),
        render_(scene, sensor, settings, has_trial, context),
        prepared_(render_),
        passes_(prepared_.Integrator::begin(scene, sensor, context, 0)) {}

  double samples() const override { return passes_->samples(); }

  double render(double samples) override {
    const MediaChoice before = render_.choice();
    constexpr double kMaxCount = 1 << 30;
    const auto count = static_cast<uint32_t>(std::clamp(samples, 1., kMaxCount));
    render_.choose(*sensor_.with_sample_count(count));
    const bool changes = rendered_ > 0 && render_.choice() != before;
    const double most = changes ? std::min(samples / kMaxSlowdown, rendered_) : samples;
    const double rendered = passes_->render(std::max(1., most));
    rendered_ += rendered;
    return rendered;
  }

 private:
  class Prepared final : public Integrator {
   public:
    explicit Prepared(const MediaRender& prepared) : render_(prepared) {}
    void render(const Scene& /*scene*/, const Sensor& sensor,
                RenderContext& /*context*/) const override {
      render_.render(sensor);
    }

   private:
    const MediaRender& render_;
  };

  const Sensor& sensor_;
  MediaRender render_;
  Prepared prepared_;
  std::unique_ptr<Passes> passes_;
  double rendered_ = 0;  ///< samples per pixel of all passes
};

}  // namespace

std::unique_ptr<Passes> media_passes(const Scene& scene, const Sensor& sensor,
                                     const PathSettings& settings, bool has_trial,
                                     RenderContext& context) {
  return std::make_unique<MediaPasses>(scene, sensor, settings, has_trial, context);
}

}  // namespace kinome
