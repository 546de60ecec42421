#pragma once

#include "images/display.h"
#include "images/output.h"
#include "kinome/parts.h"
#include "kinome/plugin_registry.h"
#include "kinome/render_context.h"
#include "kinome/scene_loader.h"
#include "options/options.h"
#include "render/report.h"

/// Functions shared by the commands that render.
namespace kinome::app {

void set_up_log(const Options& options);
/// Sets up the log, signal handlers and threads for files. Warns of ignored options and missing
/// folders.
void set_up_render(const Options& options);
LoadOptions load_options(const Options& options);
/// Returns the best instruction set that a loaded plugin is built for, at most the registry's. The
/// bits of an image depend on it.
InstructionSet used_instruction_set(const PluginRegistry& registry);
/// Warns if --isa or KINOME_ISA requests an instruction set that no loaded plugin is built for.
void warn_of_unused_instruction_set(const Options& options, const PluginRegistry& registry);
/// Warns of channels that the image's file can't store.
void warn_of_layers(const Scene& scene, const Film& film, const Output& output);

/// Renders an image, or a `part` of it, while `display` shows it. Both may be nullptr.
Image render_image(const Options& options, const Scene& scene, const Sensor& sensor,
                   RenderContext& context, Display* display, const PartRender* part = nullptr);
/// Returns the attributes of the image's header, and adds the loaded plugins to the context's
/// statistics.
ImageMetadata describe_image(const Options& options, const Scene& scene, RenderContext& context,
                             const PluginRegistry& registry, const PartRender* part = nullptr);
/// Audits plugins, and adds their faults to the context's statistics.
void audit_render(const Scene& scene, const Sensor& sensor, RenderContext& context);
/// Call describe_image() before.
RenderSummary summary_of(const Options& options, const Sensor& sensor, RenderContext& context,
                         const Image& image, const Output& output);
/// Writes the image, removes the checkpoint (which may be nullptr) if the image is complete, and
/// audits plugins. Adds times and faults to the context's statistics. `setup`: that of the scene
/// for --denoise, or nullptr.
RenderSummary finish_image(const Options& options, const Scene& scene, const Sensor& sensor,
                           RenderContext& context, const PluginRegistry& registry,
                           const Image& image, const Output& output, Checkpoint* checkpoint,
                           const PartRender* part = nullptr,
                           const DenoisingSetup* setup = nullptr);

/// Warns of non-finite samples and faulty plugins.
void report_faults(const Options& options, const RenderStats& stats);
/// Prints the statistics that --stats requests.
void print_statistics(const Options& options, const RenderStats& stats,
                      const RenderSummary& summary);
/// Returns the exit status, which depends on signals and faulty plugins.
int exit_status(const Options& options, const RenderStats& stats);

}  // namespace kinome::app
