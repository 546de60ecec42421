#pragma once

#include <string>

#include "display.h"
#include "kinome/parts.h"
#include "kinome/plugin_registry.h"
#include "kinome/render_context.h"
#include "kinome/scene_loader.h"
#include "options.h"
#include "output.h"
#include "report.h"

/// What commands that render have in common.
namespace kinome::app {

void set_up_log(const Options& options);
/// Log and signals; warns of options that mean nothing and of folders that aren't there.
void begin_to_render(const Options& options);
LoadOptions load_options(const Options& options);
/// By index or id. Throws Error where there is none.
const Sensor& choose_sensor(const Scene& scene, const std::string& wanted);
/// Of channels that are rendered for nothing.
void warn_of_layers(const Scene& scene, const Film& film);

/// Renders a picture, or a `part` of it (may be nullptr), which a display (may be nullptr) shows in
/// the making.
Image render_picture(const Options& options, const Scene& scene, const Sensor& sensor,
                     RenderContext& context, Display* display, const PartRender* part = nullptr);
/// Writes it, with the checkpoint (may be nullptr) removed where it is whole, and asks plugins how
/// they did. Whatever else there is to know of it goes to the context's statistics.
RenderSummary finish_picture(const Options& options, const Scene& scene, const Sensor& sensor,
                             RenderContext& context, const PluginRegistry& registry,
                             const Image& image, const Output& output, Checkpoint* checkpoint,
                             const PartRender* part = nullptr);

/// Warns of what plugins did wrong.
void tell_faults(const Options& options, const RenderStats& stats);
/// What --stats asks for.
void tell_statistics(const Options& options, const RenderStats& stats,
                     const RenderSummary& summary);
/// By what plugins did wrong, and signals.
int exit_status(const Options& options, const RenderStats& stats);

}  // namespace kinome::app
