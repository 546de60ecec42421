#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kinome/film_layers.h"
#include "kinome/integrator.h"
#include "kinome/light_groups.h"
#include "kinome/plugin.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"
#include "reserved_names.h"

namespace kinome {

/// An integrator that renders nested integrators, each into its own layers of the film. The colour
/// of the first one is the film's. Their other channels are named as in Mitsuba: by the nested
/// integrator's name in the scene ("_arg_0" and so on if it has none).
class NestingIntegrator : public Integrator, public RefersToEmitters {
 public:
  explicit NestingIntegrator(const Properties& props) {
    int layers = 0;
    for (auto& [name, where, integrator] : props.nested<Integrator>()) {
      if (is_reserved(name)) {
        throw Error(where, "the name '" + name + "' is reserved for other channels of the image");
      }
      const int first = layers;
      layers += static_cast<int>(integrator->layers().size());
      nested_.push_back({name, where, std::move(integrator), first});
    }
  }

  std::vector<std::vector<std::string>> layers() const override { return layers_; }
  std::vector<FilmChannel> channels() const override { return channels_; }
  void set_emitters(std::span<const Emitter* const> emitters) override {
    const auto before = nested_layers();
    for (const Nested& nested : nested_) {
      if (auto* const refers = dynamic_cast<RefersToEmitters*>(nested.integrator.get())) {
        refers->set_emitters(emitters);
      }
    }
    // A render may read lists that don't change while its scene is edited.
    if (nested_layers() != before) list();
  }

  std::vector<Stage> stages() const override {
    std::vector<Stage> stages;
    for (const Nested& nested : nested_) {
      for (const Stage& stage : nested.integrator->stages()) {
        const bool is_new = std::none_of(stages.begin(), stages.end(), [&](const Stage& other) {
          return std::string_view(other.name) == stage.name;
        });
        if (is_new) stages.push_back(stage);
      }
    }
    return stages;
  }

  /// Returns the default of the first nested integrator that has one.
  const char* default_indirect_emitter() const override {
    for (const Nested& nested : nested_) {
      if (const char* name = nested.integrator->default_indirect_emitter()) return name;
    }
    return nullptr;
  }
  bool traces_media() const override {
    return std::all_of(nested_.begin(), nested_.end(),
                       [](const Nested& nested) { return nested.integrator->traces_media(); });
  }
  bool gives_samples() const override {
    return std::all_of(nested_.begin(), nested_.end(), [](const Nested& nested) {
      return nested.integrator->gives_samples();
    });
  }
  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override {
    if (nested_.empty()) return Integrator::begin(scene, sensor, context, seconds);
    return std::make_unique<NestedPasses>(*this, scene, sensor, context, seconds);
  }
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  const Vec2& film_position) const override {
    if (nested_.empty()) return Integrator::inspect(scene, sensor, context, film_position);
    return nested_[0].integrator->inspect(scene, sensor, context, film_position);
  }
  void warn_of_ignored_light(const Scene& scene, const Sensor& sensor,
                             RenderContext& context) const override {
    for (const Nested& nested : nested_) {
      nested.integrator->warn_of_ignored_light(scene, sensor, context);
    }
  }
  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    for (const Nested& nested : nested_) {
      const FilmLayers first(sensor.film(), nested.first_layer);
      nested.integrator->render(scene, sensor, context);
    }
  }

 protected:
  struct Nested {
    std::string name;
    Location where;
    std::shared_ptr<Integrator> integrator;
    int first_layer;
  };
  const std::vector<Nested>& nested() const { return nested_; }
  /// Lists the layers and channels. Must be called by constructors of derived classes, and whenever
  /// the lists of a nested integrator change.
  void list() {
    layers_ = nested_layers();
    channels_.clear();
    list_channels();
  }
  /// Lists the channels, and the layers of this integrator itself. Called by list().
  virtual void list_channels() = 0;
  /// Layers of all nested integrators, at least one.
  std::vector<std::vector<std::string>> nested_layers() const {
    std::vector<std::vector<std::string>> all;
    for (const Nested& nested : nested_) {
      const auto layers = nested.integrator->layers();
      all.insert(all.end(), layers.begin(), layers.end());
    }
    if (all.empty()) all.emplace_back();  // the film's colour
    return all;
  }
  /// Renders the layers of this integrator itself. Called after the nested integrators of a pass,
  /// with the pass's share of the scene's samples.
  virtual void render_own(const Scene& /*scene*/, const Sensor& /*sensor*/,
                          RenderContext& /*context*/) const {}

  /// Adds a layer of this integrator's own, whose values have these names. Returns its number.
  int add_layer(const std::vector<std::string>& names) {
    layers_.push_back(names);
    return static_cast<int>(layers_.size()) - 1;
  }
  void add_channel(FilmChannel channel) { channels_.push_back(std::move(channel)); }
  /// Adds components of a nested integrator's colour as channels, such as NAME.R.
  void add_color(const Nested& nested, std::initializer_list<std::pair<const char*, int>> parts) {
    for (const auto& [suffix, value] : parts) {
      add_channel({nested.name + "." + suffix, nested.first_layer, value});
    }
  }
  /// Adds all channels of a nested integrator other than its colour. Light groups of the film's
  /// colour keep their names.
  void add_channels_of(const Nested& nested) {
    for (FilmChannel channel : nested.integrator->channels()) {
      const bool keeps_name =
          nested.first_layer == 0 && channel.name.starts_with(LightGroups::kPrefix);
      if (!keeps_name) channel.name = nested.name + "." + channel.name;
      channel.layer += nested.first_layer;
      add_channel(std::move(channel));
    }
  }

 private:
  /// Passes of all nested integrators, which prepare themselves only once. The first one sets the
  /// number of samples.
  class NestedPasses final : public Passes {
   public:
    NestedPasses(const NestingIntegrator& owner, const Scene& scene, const Sensor& sensor,
                 RenderContext& context, double seconds)
        : owner_(owner), scene_(scene), sensor_(sensor), context_(context) {
      for (const Nested& nested : owner.nested_) {
        const FilmLayers first(sensor.film(), nested.first_layer);
        passes_.push_back(nested.integrator->begin(scene, sensor, context, seconds));
      }
    }
    double samples() const override { return passes_.front()->samples(); }
    double seconds_per_sample() const override { return passes_.front()->seconds_per_sample(); }
    double render(double samples) override {
      const double rendered = render_nested(0, samples);
      // A sample may be a different amount of work for each integrator.
      const double share = rendered / this->samples();
      for (size_t i = 1; i < passes_.size(); ++i) {
        render_nested(i, std::max(1., share * passes_[i]->samples()));
      }
      const double own = std::round(share * sensor_.sampler().sample_count());
      const auto count = static_cast<uint32_t>(std::clamp(own, 1., 0x1p30));
      owner_.render_own(scene_, *sensor_.with_sample_count(count), context_);
      return rendered;
    }

   private:
    double render_nested(size_t index, double samples) {
      const FilmLayers first(sensor_.film(), owner_.nested_[index].first_layer);
      return passes_[index]->render(samples);
    }
    const NestingIntegrator& owner_;
    const Scene& scene_;
    const Sensor& sensor_;
    RenderContext& context_;
    std::vector<std::unique_ptr<Passes>> passes_;
  };

  std::vector<Nested> nested_;
  std::vector<std::vector<std::string>> layers_;
  std::vector<FilmChannel> channels_;
};

}  // namespace kinome
