#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinome/math.h"
#include "kinome/relight.h"

namespace kinome::app {

enum class StatsFormat { kNone, kText, kJson };

/// Options of `kinome film` beside those of all renders.
struct FilmOptions {
  std::string path;  ///< "orbit", "ellipse" or the name of a file of keys
  int frames = 0;
  double rate = 25;           ///< frames per second
  int first = 0, last = 0;    ///< frames to render, both included
  glm::dvec2 angles{30, 10};  ///< half axes of an ellipse, in degrees: to the side, and up
  std::optional<glm::dvec3> target, up;  ///< nullopt: derived from the scene's sensor
};

/// Options of a command line.
struct Options {
  enum class Command { kRender, kFilm, kMerge, kRelight, kListPlugins, kCheckPlugin, kNewPlugin };
  Command command = Command::kRender;

  std::string scene;
  std::map<std::string, std::string> defines;
  std::string output;  ///< "" for a file beside the scene file
  unsigned threads = 0;
  std::string sensor = "0";  ///< index or id
  std::vector<std::string> search_paths;
  std::vector<std::string> plugin_paths;
  std::string isa;  ///< best instruction set that plugins may use; "" selects KINOME_ISA
  uint64_t seed = 0;
  std::string variant;
  int verbosity = 0;
  bool quiet = false;
  StatsFormat stats = StatsFormat::kNone;
  std::string trace;  ///< file for the work of each thread, or ""
  bool png = false;
  float exposure = 0;
  std::optional<Rect> crop;       ///< --crop: pixels of the full film that replace the scene's crop
  double seconds = 0;             ///< --time; 0 if not given
  double rel_mse = 0;             ///< --error; 0 if not given
  uint32_t renders = 0;           ///< --variance; 0 if not given
  bool denoise = false;           ///< --denoise
  bool denoise_as_layer = false;  ///< --denoise=layer
  std::string checkpoint;         ///< "" if none is written
  double every = 60;              ///< seconds between checkpoints
  bool resume = false;
  /// --part: number of the part, counted from 1 (0 for all parts), and number of parts (0 if not
  /// given).
  uint32_t part = 0, parts = 0;
  std::string display;  ///< HOST:PORT, or ""
  enum class Mpi { kAuto, kOn, kOff };
  Mpi mpi = Mpi::kAuto;
  bool lenient = false;
  bool check = false;
  std::optional<Vec2> inspect;  ///< pixel whose clusters are drawn instead of rendering

  FilmOptions film;  ///< for `kinome film`

  // For `kinome merge`, whose -o is `output`.
  std::vector<std::string> files;  ///< files of parts
  bool allow_missing = false;

  // For `kinome relight`, whose -o is `output`.
  std::string image;  ///< file to change
  LightGains gains;

  std::string plugin_name;  ///< for `kinome plugins` ("" lists all), `check` and `new`
  bool markdown = false;
  bool mitsuba = false;

  // For `kinome check`, whose -D are `defines`.
  std::vector<std::string> only, except;  ///< names of checks
  std::string against;                    ///< integrator or emitter to compare with
  double effort = 1;

  // For `kinome new`.
  std::string category;
  std::string folder;  ///< "" for a subfolder with the plugin's name
};

/// Parses any number of command lines, each as parse_options() does. Declares the options only
/// once, which takes several times as long as parsing a line.
class OptionsParser {
 public:
  OptionsParser();
  ~OptionsParser();
  std::optional<Options> parse(int argc, const char* const* argv);

 private:
  struct Language;
  std::map<Options::Command, std::unique_ptr<Language>> languages_;
};

/// Parses a command line. Returns nullopt after printing what --help, --version and the like
/// request. Throws Error for an invalid command line.
std::optional<Options> parse_options(int argc, const char* const* argv);

/// Returns the exit status for errors: 2 for `kinome check`, whose status 1 means that the plugin
/// failed a check, and 1 for all other commands.
int failure_status_of(int argc, const char* const* argv);

/// Warns of search paths for plugins and files that aren't folders. These aren't errors, because a
/// list of paths may be meant for several machines.
void warn_of_missing_folders(const Options& options);

}  // namespace kinome::app
