// Images of a RenderSession: previews, passes and renders with a given number of samples.

#include "session/render_session.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>
#include <utility>
#include <variant>

#include "kinome/light_groups.h"
#include "kinome/primary_rays.h"
#include "session/preview_sensor.h"

namespace kinome::viewer {
namespace {

/// Width of the first preview as a fraction of the film's.
constexpr double kInitialScale = 0.18;
constexpr double kMinScale = 1. / 16;

/// Integrators of previews, for scenes without media and with media.
constexpr const char* kPreviewIntegrator = "path";
constexpr const char* kMediaPreviewIntegrator = "volpath";

/// Returns true if an integrator has a preparation stage, such as learning, before the camera rays.
/// Such a stage takes too long for a preview.
bool is_slow_to_begin(const Integrator& integrator) {
  for (const Stage& stage : integrator.stages()) {
    if (std::string_view(stage.name) == kPrimaryStage.name) return false;
    if (stage.is_alone) return true;
  }
  return false;
}

/// Returns the path of the integrator that renders the image's colour. `aov` and `moment` take the
/// colour from the first integrator nested in them. Returns "" if the scene has no other integrator.
std::string path_of_color(const SceneEditor& editor) {
  for (const SceneObject& object : editor.objects()) {
    const bool is_nesting =
        object.plugin == "integrator/aov" || object.plugin == "integrator/moment";
    if (object.plugin.starts_with("integrator/") && !is_nesting) return object.path;
  }
  return "";
}

/// Adds a parameter's value to a description, if it has one.
void copy_value(const SceneParameter& parameter, const std::string& name,
                ObjectDescription& description) {
  if (!parameter.value) return;
  std::visit(
      [&](const auto& value) {
        if constexpr (std::is_constructible_v<Properties::Value, decltype(value)>) {
          description.values.push_back({name, value, description.where});
        }
      },
      *parameter.value);
}

/// Returns the integrator of previews of a scene whose own integrator is slow to begin. It has the
/// same number of bounces and the same light groups.
ObjectDescription preview_integrator(const SceneEditor& editor, const Integrator& own,
                                     bool has_media) {
  ObjectDescription preview{.tag = "integrator",
                            .type = has_media ? kMediaPreviewIntegrator : kPreviewIntegrator,
                            .where = {"preview"}};
  if (editor.path_of(own).empty()) return preview;
  ObjectDescription groups{.tag = "integrator", .type = "aov", .where = {"preview"}};
  const std::string color = path_of_color(editor);
  for (const SceneParameter& parameter : editor.parameters()) {
    for (const char* const name : {"max_depth", "hide_emitters"}) {
      if (parameter.path == color + "." + name) copy_value(parameter, name, preview);
    }
    const bool divides_light = parameter.plugin == "integrator/aov" && parameter.is_set &&
                               parameter.path.ends_with(".light_groups");
    if (divides_light && groups.values.empty()) copy_value(parameter, "light_groups", groups);
  }
  // Groups of an integrator that doesn't render the image's colour have longer names.
  const bool has_groups = std::ranges::any_of(own.channels(), [](const FilmChannel& channel) {
    return channel.name.starts_with(LightGroups::kPrefix);
  });
  if (!has_groups || groups.values.empty()) return preview;
  groups.parts.push_back(std::move(preview));
  return groups;
}

uint64_t rays_of(const RenderStats& stats) {
  return std::accumulate(stats.counters.rays.begin(), stats.counters.rays.end(), uint64_t{0});
}

}  // namespace

std::string RenderSession::name_of(const Integrator& integrator) {
  const std::string& plugin = integrator.plugin();
  return plugin.substr(plugin.find('/') + 1);
}

/// Returns the scene for previews. Its integrator is that of preview_integrator() if the scene's
/// own integrator is slow to begin.
const Scene& RenderSession::preview_scene() {
  const Integrator& own = scene_->integrator();
  if (!is_slow_to_begin(own)) return *scene_;
  if (preview_scene_) return *preview_scene_;
  const bool has_media = own.traces_media() && !scene_->media().empty();
  try {
    preview_scene_ = editor_->scene_with(preview_integrator(*editor_, own, has_media));
  } catch (const Error&) {
    preview_scene_ = scene_;  // slower, but works
  }
  return *preview_scene_;
}

/// Renders a preview. Its number of pixels follows from the time of the last preview.
void RenderSession::preview() {
  set_activity(Activity::kPreview);
  const double start = context_->job.seconds();
  const Rect crop = sensor().film().crop();
  double scale = kInitialScale;
  if (seconds_per_pixel_ > 0) {
    scale = std::sqrt(options_.preview_seconds / (seconds_per_pixel_ * std::max(1, crop.area())));
  }
  scale = std::clamp(scale, kMinScale, 1.);
  const auto side = [&](int pixels) { return std::max(1, static_cast<int>(pixels * scale + 0.5)); };
  const double pixels = preview_of(side(crop.width()), side(crop.height()), start);
  seconds_per_pixel_ = (context_->job.seconds() - start) / pixels;
  wants_preview_ = false;
  // Renders a full-size preview next if the first pass of the integrator takes long.
  wants_whole_preview_ = scale < 1 && is_slow_to_begin(scene_->integrator());
  if (is_paused_) set_activity(Activity::kPaused);
}

/// Renders a preview of width x height pixels with one sample each. Returns the number of pixels.
double RenderSession::preview_of(int width, int height, double start) {
  const Scene* scene = nullptr;
  {
    const std::lock_guard lock(scene_mutex_);
    scene = &preview_scene();
    if (denoiser_ && !guide_scene_) guide_scene_ = PreviewDenoiser::guides_of(*editor_);
  }
  const auto film_sensor = with_own_film(sensor(), width, height, 1, denoiser_ != nullptr);
  auto image = render_once(*scene, *film_sensor, *context_);
  if (image && denoiser_ && !denoiser_->denoise(*image, *guide_scene_, *film_sensor, *context_)) {
    image.reset();
  }
  if (image) {
    publish(*scene, std::move(*image), Shows::kPreview, context_->job.seconds() - start, -1);
  }
  return static_cast<double>(width) * height;
}

void RenderSession::improve() {
  set_activity(Activity::kRendering);
  if (std::exchange(wants_whole_preview_, false)) {
    const Rect crop = sensor().film().crop();
    preview_of(crop.width(), crop.height(), context_->job.seconds());
    return;
  }
  if (!live_) {
    live_ = std::make_unique<LiveRender>(*scene_, sensor(), *context_, options_.max_samples);
  }
  if (cancel_) return live_.reset();  // its preparation may be incomplete
  // The session's thread waits for the pass, so that another thread may publish its images.
  const double seconds = live_->seconds(), rel_mse = live_->rel_mse();
  const auto publish_part = [&](Image image) {
    publish(*scene_, std::move(image), Shows::kPart, seconds, rel_mse);
    notify();
  };
  if (!live_->pass(region_, publish_part)) {
    if (!live_->is_whole()) live_.reset();
    has_finished_tiles_ = true;
    return;
  }
  is_coarse_ = false;
  is_done_ = live_->samples() >= options_.max_samples;
  publish_live();
  if (is_done_ || is_paused_) set_activity(is_done_ ? Activity::kFinished : Activity::kPaused);
}

/// Publishes the progressive image so far.
void RenderSession::publish_live() {
  has_finished_tiles_ = false;
  publish(*scene_, live_->develop(), is_done_ ? Shows::kAll : Shows::kPasses, live_->seconds(),
          live_->rel_mse());
}

void RenderSession::render_exactly() {
  set_activity(Activity::kRendering);
  const auto samples = sensor().with_sample_count(*exact_samples_);
  sensor().film().set_lane(0);
  scene_->integrator().warn_of_ignored_light(*scene_, sensor(), *context_);
  auto image = render_once(*scene_, *samples, *context_);
  if (!image) return;
  is_done_ = true;
  publish(*scene_, std::move(*image), Shows::kAll, context_->job.stats().render_seconds, -1);
  set_activity(Activity::kFinished);
}

void RenderSession::publish(const Scene& scene, Image image, Shows shows, double seconds,
                            double rel_mse) {
  auto picture = std::make_shared<Picture>();
  picture->image = std::move(image);
  picture->stats = context_->job.stats();
  picture->generation = ++generation_;
  picture->edition = edition_;
  picture->crop = sensor().film().crop();
  picture->is_preview = shows == Shows::kPreview;
  picture->is_part = shows == Shows::kPart;
  picture->is_final = shows == Shows::kAll;
  picture->integrator = name_of(scene.integrator());
  picture->samples = picture->stats.samples;
  if (!sensor().is_surface()) picture->sensor = scene_->sensors()[sensor_];
  picture->seconds = seconds;
  picture->rel_mse = rel_mse;
  picture->rays_per_second =
      seconds > 0 ? static_cast<double>(rays_of(picture->stats)) / seconds : 0;
  report_non_finite_samples(picture->stats);
  const std::lock_guard lock(mutex_);
  picture_ = std::move(picture);
}

}  // namespace kinome::viewer
