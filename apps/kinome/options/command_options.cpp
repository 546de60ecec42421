#include "options/command_options.h"

// CLI11 takes long to compile: only files about options include it.
#include <CLI/CLI.hpp>

namespace kinome::app {
namespace {

/// Declares an option with a value, whose `type` the help prints. CLI11 writes the value into
/// `variable`, if there is one.
template <class... Variable>
CLI::Option* option(CLI::App& app, const char* names, const char* type,
                    const std::string& description, Variable&... variable) {
  return app.add_option(names, variable..., description)->type_name(type);
}
/// Declares an option that can be repeated.
void list(CLI::App& app, const char* names, const char* type, const char* description,
          std::vector<std::string>& values) {
  option(app, names, type, description, values)->allow_extra_args(false);
}
/// Declares a flag without a value.
template <class Variable>
void flag(CLI::App& app, const char* names, const char* description, Variable& variable) {
  app.add_flag(names, variable, description)->disable_flag_override();
}

/// Returns a check that accepts only numbers between `low` and `high`.
template <class T>
auto in_range(T low, T high) {
  return [low, high](const std::string& text) {
    T number{};
    return parse_in_range(text, low, high, number);
  };
}

/// Declares options of all commands that write images.
void declare_verbosity(CLI::App& app, Options& options) {
  flag(app, "-v,--verbose", "Print more messages (repeat for still more)", options.verbosity);
  flag(app, "-q,--quiet", "Print only errors, and the reason for exit status 3", options.quiet);
}
void declare_png(CLI::App& app, Options& options) {
  flag(app, "--png", "Also write a PNG (sRGB) beside the image", options.png);
  option(app, "--exposure", "STOPS", "Exposure of 8-bit images, in stops; default: 0",
         options.exposure);
}

void declare_denoise(CLI::App& app) {
  app.add_flag("--denoise")
      ->description(
          "Denoise the image by Open Image Denoise, and keep the noisy one as channels noisy.R, "
          ".G, .B; --denoise=layer: keep the noisy image, with channels denoised.R, .G, .B")
      ->type_name("[=layer]");
}

/// Declares the options about the scene of all commands that render.
void declare_scene(CLI::App& app, Options& options, RawOptions& raw) {
  app.add_option("scene.xml", options.scene, "Scene file in Mitsuba's XML format")->required();
  begin_group(app, "Scene");
  list(app, "-D,--define", "KEY=VALUE", "Set $KEY in the scene file (repeat for more)",
       raw.defines);
  option(app, "-s,--sensor", "SENSOR", "Sensor to render, by index or id; default: 0",
         options.sensor);
  list(app, "-a,--append", "PATH;PATH", "Also search these folders for the scene's files",
       raw.search_paths);
  flag(app, "--lenient",
       "Leave out unsupported features of Mitsuba; exit with status 0, not 3, if plugins return "
       "impossible values",
       options.lenient);
  option(app, "-m,--mode", "VARIANT", "Mitsuba's variant; ignored, because there is only one",
         options.variant);
}

/// Declares the options about quality, messages and the machine of all commands that render.
void declare_render(CLI::App& app, Options& options) {
  begin_group(app, "Quality");
  option(app, "--time", "SECONDS",
         "Render the best image within this time, from the program's start to the written file",
         options.seconds);
  option(app, "--error", "RELMSE",
         "Render until the estimated relMSE of the image is about this value", options.rel_mse);
  option(app, "--seed", "N", "Seed of all random numbers; default: 0");
  app.add_flag("--variance{16}")
      ->description(
          "Render the samples in COUNT independent sets (default: 16), and write the image's "
          "variance as channels variance.R, .G, .B, for kinome-compare")
      ->type_name("[=COUNT]");
  declare_denoise(app);
  begin_group(app, "Messages and statistics");
  declare_verbosity(app, options);
  app.add_flag("--stats")
      ->description("Print times and counts to stderr; --stats=json: one JSON object to stdout")
      ->type_name("[=json]");
  option(app, "--display", "HOST:PORT",
         "Show the image during the render in the viewer tev at this address (tev's default: "
         "localhost:14158)",
         options.display);
}

void declare_threads(CLI::App& app, Options& options) {
  begin_group(app, kProgramGroup);
  option(app, "-t,--threads", "COUNT", "Number of threads; default: one per core", options.threads)
      ->check(in_range(1, 1024));
}

void declare_crop(CLI::App& app) {
  option(app, "--crop", "X,Y,W,H", "Render only W x H pixels from column X and row Y of the film");
}

void declare_image(CLI::App& app, Options& options, RawOptions& raw) {
  declare_scene(app, options, raw);
  flag(app, "--check",
       "Instead of rendering, list all errors in the scene and its files, with file and line",
       options.check);
  begin_group(app, "Image");
  option(app, "-o,--output", "FILE",
         "Image file, in the format of its extension (.exr, .png, .jpg, ...); default: the scene's "
         "name, beside the scene file",
         options.output);
  declare_png(app, options);
  declare_crop(app);
  option(app, "--inspect", "X,Y",
         "Instead of rendering, write an image and a table that show how the light of this pixel "
         "is sampled");
  declare_render(app, options);
  option(app, "--trace", "FILE",
         "Write the work of each thread to this file, in Chrome's trace format (JSON)",
         options.trace);
  begin_group(app, "Long renders and several machines");
  option(app, "--checkpoint", "FILE",
         "Save finished tiles to this file, until the image is written", options.checkpoint);
  option(app, "--every", "SECONDS", "Seconds between checkpoints; default: 60", options.every);
  flag(app, "--resume", "Continue from the checkpoint if there is one", options.resume);
  option(app, "--part", "I/N",
         "Render the I-th of N parts of the samples, into a file for kinome merge; all/N: render "
         "all parts and merge them into one image");
#ifdef KINOME_HAS_MPI
  option(app, "--mpi", "auto|on|off",
         "Render one image with all processes of an MPI launcher (mpirun, srun): on, off or auto "
         "(if there is a launcher); default: auto");
#endif
  declare_threads(app, options);
}

void declare_film(CLI::App& app, Options& options, RawOptions& raw) {
  FilmOptions& film = options.film;
  declare_scene(app, options, raw);
  begin_group(app, "Animation");
  option(app, "-o,--output", "FILE",
         "FILE.mp4, or names of frames with a number, such as frames/%04d.exr or .png; default: "
         "the scene's name with .mp4, beside the scene file",
         options.output);
  option(app, "--path", "orbit|ellipse|FILE",
         "Path of the camera: orbit (around its target), ellipse (on a sphere about its target), "
         "or a JSON file with keys of the camera and other parameters",
         film.path)
      ->required();
  option(app, "--frames", "COUNT", "Number of frames", film.frames)->required();
  option(app, "--fps", "RATE", "Frames per second; default: 25", film.rate);
  option(app, "--frame", "I", "Render only this frame, counted from 0");
  option(app, "--range", "FIRST:LAST", "Render only the frames FIRST to LAST");
  option(app, "--target", "X,Y,Z",
         "Target of orbit and ellipse; default: the point at the centre of the image of the "
         "scene's sensor");
  option(app, "--up", "X,Y,Z", "Up direction; default: the axis nearest to the camera's");
  option(app, "--angles", "A,B",
         "Half axes of the ellipse, to the side and up, in degrees as seen from the target; "
         "default: 30,10");
  declare_png(app, options);
  declare_crop(app);
  declare_render(app, options);
  declare_threads(app, options);
}

void declare_merge(CLI::App& app, Options& options, RawOptions& /*raw*/) {
  app.add_option("PART.exr", options.files, "Files of all parts, in any order")->required();
  begin_group(app, "Image");
  option(app, "-o,--output", "FILE", "Image file", options.output)->required();
  declare_png(app, options);
  declare_denoise(app);
  option(app, "-t,--threads", "COUNT", "Number of threads for --denoise; default: one per core",
         options.threads)
      ->check(in_range(1, 1024));
  flag(app, "--allow-missing", "Merge although parts are missing or were interrupted",
       options.allow_missing);
  begin_group(app, "Messages");
  declare_verbosity(app, options);
}

void declare_relight(CLI::App& app, Options& options, RawOptions& raw) {
  app.add_option("IMAGE.exr", options.image, "Image with light groups")->required();
  app.add_option("GROUP=FACTOR", raw.gains,
                 "Factor of a group's light: a number, or R,G,B; other groups keep their light")
      ->required();
  begin_group(app, "Image");
  option(app, "-o,--output", "FILE", "Image file", options.output)->required();
  declare_png(app, options);
  begin_group(app, "Messages");
  declare_verbosity(app, options);
}

void declare_list(CLI::App& app, Options& options, RawOptions& /*raw*/) {
  app.add_option("NAME", options.plugin_name, "Name, CATEGORY/NAME or CATEGORY");
  begin_group(app, "Format");
  flag(app, "--markdown", "Print a table in Markdown, or a page about one plugin",
       options.markdown);
  flag(app, "--mitsuba", "List all plugins of Mitsuba, and which of them are supported",
       options.mitsuba);
}

void declare_check(CLI::App& app, Options& options, RawOptions& raw) {
  app.add_option("PLUGIN", options.plugin_name,
                 "Name, CATEGORY/NAME, or the path of CATEGORY/NAME.so")
      ->required();
  begin_group(app, "Plugin");
  list(app, "-D,--define", "PARAMETER=VALUE",
       "Set a parameter of the plugin; a VALUE that begins with '<' is XML (repeat for more)",
       raw.defines);
  option(app, "--against", "NAME",
         "Integrator or emitter, by name or as XML, that must give the same result as PLUGIN",
         options.against);
  begin_group(app, "Checks");
  list(app, "--only", "CHECK", "Run only this check (repeat for more)", options.only);
  list(app, "--except", "CHECK", "Leave out this check (repeat for more)", options.except);
  option(app, "--effort", "FACTOR", "Multiply the usual number of random samples; default: 1",
         options.effort)
      ->check(in_range(0.01, 1000.0));
  option(app, "--seed", "N", "Seed of all random numbers; default: 0");
}

void declare_new(CLI::App& app, Options& options, RawOptions& /*raw*/) {
  app.add_option("CATEGORY", options.category,
                 "bsdf, emitter, film, integrator, medium, phase, rfilter, sampler, sensor, shape, "
                 "texture or volume")
      ->required();
  app.add_option("NAME", options.plugin_name, "Name of the plugin")->required();
  begin_group(app, "Plugin");
  option(app, "--output", "FOLDER", "Folder to create; default: NAME", options.folder);
}

constexpr Command kRender = {"", Options::Command::kRender,
                             "Renders a scene in Mitsuba's format into an image.\n\n"
                             "Other commands (kinome COMMAND --help describes each):\n"
                             "  kinome film SCENE           renders an animation\n"
                             "  kinome merge PART.exr...    adds the parts of an image\n"
                             "  kinome relight IMAGE.exr    changes the light of an image\n"
                             "  kinome plugins [NAME]       lists plugins or parameters\n"
                             "  kinome check PLUGIN         checks a plugin for errors\n"
                             "  kinome new CATEGORY NAME    starts a plugin",
                             declare_image};
constexpr Command kMerge = {"merge", Options::Command::kMerge,
                            "Adds the parts of an image that kinome --part has rendered. The\n"
                            "result is that of --part all/N. kinome-merge is another name for\n"
                            "this command.",
                            declare_merge};
constexpr Command kOtherCommands[] = {
    {"film", Options::Command::kFilm,
     "Renders an animation, with a moving camera and changing parameters, as\n"
     "frames and a video. If it was interrupted, the same command continues\n"
     "with the missing frames.",
     declare_film},
    kMerge,
    {"relight", Options::Command::kRelight,
     "Multiplies the light of some of an image's light groups by factors,\n"
     "without rendering it again.",
     declare_relight},
    {"plugins", Options::Command::kListPlugins,
     "Lists all plugins, the plugins of a category, or the parameters of a\nplugin.",
     declare_list},
    {"check", Options::Command::kCheckPlugin,
     "Checks whether a plugin fulfils the contract of its category, and\n"
     "prints a line per check. Exit status: 1 if a check fails, 2 if the\n"
     "command line is wrong.",
     declare_check},
    {"new", Options::Command::kNewPlugin,
     "Creates a folder with the source of a new plugin, a CMakeLists.txt,\n"
     "a scene and tests.",
     declare_new}};

}  // namespace

const Command& rendering_command() { return kRender; }
const Command& merging_command() { return kMerge; }
std::span<const Command> other_commands() { return kOtherCommands; }

/// Sets the group of the help to which the options declared next belong.
void begin_group(CLI::App& app, const char* name) {
  app.option_defaults()->group(name);
}

void declare_plugin_options(CLI::App& app, Options& options) {
  begin_group(app, kProgramGroup);
  list(app, "--plugin-path", "FOLDER", "Also search this folder for plugins (repeat for more)",
       options.plugin_paths);
  option(app, "--isa", "NAME",
         "Best instruction set that plugins may use (x86-64-v2, x86-64-v3, x86-64-v4); default: "
         "the processor's",
         options.isa);
}

}  // namespace kinome::app
