// `kinome relight`: changes the light of an image's light groups, without rendering it again.

#include <fmt/format.h>

#include "base/clock.h"
#include "commands.h"
#include "crash.h"
#include "images/image_formats.h"
#include "images/output.h"
#include "kinome/error.h"
#include "kinome/image_files.h"
#include "kinome/log.h"
#include "kinome/output_files.h"
#include "kinome/read_files.h"
#include "kinome/relight.h"
#include "output_files/file_writer.h"
#include "render/render_image.h"
#include "say.h"

namespace kinome::app {
namespace {

constexpr const char* kDefaultExtension = ".exr";

/// Returns the names of groups as a list: "sun, lamps".
std::string names_in_list(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Removes channels about the colour before it was changed. Returns their names without components.
std::vector<std::string> drop_stale_channels(Image& image) {
  constexpr const char* kStale[] = {"variance", "tile_variance", "noisy", "denoised"};
  std::vector<std::string> dropped;
  std::vector<size_t> kept;
  for (size_t c = 0; c < image.channels.size(); ++c) {
    const std::string layer = image.channels[c].substr(0, image.channels[c].find('.'));
    const bool is_stale = std::ranges::find(kStale, layer) != std::end(kStale);
    if (!is_stale) kept.push_back(c);
    if (is_stale && (dropped.empty() || dropped.back() != layer)) dropped.push_back(layer);
  }
  if (dropped.empty()) return dropped;
  Image rest{image.width, image.height, {}, {}};
  for (const size_t c : kept) rest.channels.push_back(image.channels[c]);
  for (size_t at = 0; at < image.data.size(); at += image.channels.size()) {
    for (const size_t c : kept) rest.data.push_back(image.data[at + c]);
  }
  image = std::move(rest);
  return dropped;
}

}  // namespace

int relight_command(const Options& options, Clock::time_point start) {
  set_up_log(options);
  set_activity("reading the image");
  const std::string output = image_path(options.output, kDefaultExtension);
  record_read_file(options.image);
  const bool has_png = options.png && lower_extension(output) != ".png";
  check_writable(output);
  if (has_png) check_writable(png_beside(output));
  ImageMetadata metadata;
  ExrWindow window;
  Image image = read_exr(options.image, {}, &metadata, &window);
  const std::vector<std::string> groups = light_groups_of(image);
  const Location where{options.image, 0, 0};
  if (metadata.contains("kinome:part")) {
    throw Error(where, "a part of an image can't be relit: merge the parts first");
  }
  if (groups.empty()) {
    throw Error(where,
                "the image has no light groups: render it with the parameter light_groups of "
                "the integrator aov");
  }
  try {
    image = relight(std::move(image), options.gains);
  } catch (const Error& error) {
    throw Error(where, error.message() + "; its groups are " + names_in_list(groups));
  }
  const std::vector<std::string> dropped = drop_stale_channels(image);
  if (!dropped.empty()) {
    log_warn(fmt::format("{}: left out the channels {}, which describe the image before the change",
                         options.image, names_in_list(dropped)));
  }
  // They describe the noise of the image before the change.
  for (const char* key : {"kinome:relmse", "kinome:renders", "kinome:variance_of_mean"}) {
    metadata.erase(key);
  }
  if (metadata.erase("kinome:denoised") > 0) {
    log_warn(
        fmt::format("{}: the image was denoised, but its light groups weren't: the result is "
                    "noisy",
                    options.image));
  }
  set_activity("writing the image");
  warn_of_lost_channels(image, output, nullptr);
  if (lower_extension(output) == kDefaultExtension) {
    write_exr(output, image, ExrSampleType::kFloat, metadata, window.crop_offset,
              window.full_size);
  } else {
    write_image(output, nullptr, image, metadata, options.exposure);
  }
  if (has_png) write_png(png_beside(output), image, options.exposure);
  if (!options.quiet) say("wrote {} ({:.2f} s)\n", output, seconds_since(start));
  return 0;
}

}  // namespace kinome::app
