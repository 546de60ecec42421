// `kinome merge`: adds the files of parts to one image.

#include <cmath>

#include <fmt/format.h>

#include "base/clock.h"
#include "commands.h"
#include "crash.h"
#include "images/denoising.h"
#include "images/image_formats.h"
#include "kinome/log.h"
#include "kinome/output_files.h"
#include "kinome/parts.h"
#include "kinome/plugin_registry.h"
#include "kinome/read_files.h"
#include "output_files/file_writer.h"
#include "render/render_image.h"
#include "say.h"

namespace kinome::app {
namespace {

/// Returns the output files. Throws Error if they can't be written or are among the parts.
Output output_of(const Options& options) {
  Output output;
  output.image = image_path(options.output, ".exr");
  check_format_of_denoised(options, lower_extension(output.image));
  if (options.png && lower_extension(output.image) != ".png") {
    output.png = png_beside(output.image);
  }
  for (const std::string& part : options.files) record_read_file(part);
  for (const std::string& file : output.files()) check_writable(file);
  return output;
}

/// Describes missing and incomplete parts; "" if there are none.
std::string incompleteness(const MergedParts& merged) {
  std::string text;
  const auto add = [&](const std::vector<uint32_t>& parts, const std::string& attribute,
                       const char* what) {
    if (parts.empty()) return;
    const std::string& numbers = merged.metadata.at(attribute);
    text += fmt::format("; part{} {} {} {}", parts.size() == 1 ? "" : "s", numbers,
                        parts.size() == 1 ? "is" : "are", what);
  };
  add(merged.missing, "kinome:missing_parts", "missing");
  add(merged.incomplete, "kinome:incomplete_parts", "incomplete");
  if (merged.gaps > 0) {
    text += fmt::format(", {} % of the pixels missing (alpha 0)", std::ceil(100 * merged.gaps));
  }
  return text;
}

}  // namespace

int merge_command(const Options& options, Clock::time_point start) {
  set_up_log(options);
  warn_of_missing_folders(options);
  const Output output = output_of(options);
  set_activity("merging parts");
  PluginRegistry registry(PluginRegistry::default_folders(options.plugin_paths),
                          choose_instruction_set(options.isa));
  const std::optional<Denoising> denoising = denoising_of(options);
  MergedParts merged =
      merge_parts(options.files, options.allow_missing, registry, denoising.has_value());
  if (merged.is_mixed) {
    log_warn(
        fmt::format("the parts were rendered with several instruction sets ({}), so that no single "
                    "machine would render the same bits; to avoid this, render all with one --isa",
                    merged.metadata.at("kinome:isa")));
  }
  if (merged.non_finite > 0) {
    log_warn(fmt::format("dropped samples that were not finite: {}", merged.non_finite));
  }
  if (denoising) {
    merged.image = denoising->denoise(merged.image, merged.metadata);
    merged.metadata["kinome:denoised"] = options.denoise_as_layer ? "layer" : "image";
  } else {
    remove_guides(merged.image, merged.metadata);
  }
  warn_of_lost_channels(merged.image, output.image, merged.film.get());
  set_activity("writing the image");
  write_image_files(options, *merged.film, merged.image, merged.metadata, output, nullptr);
  if (!options.quiet) {
    say("wrote {}: {} of {} parts{} ({:.2f} s)\n", output.image,
        merged.count - merged.missing.size(), merged.count, incompleteness(merged),
        seconds_since(start));
  }
  return 0;
}

}  // namespace kinome::app
