#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "film_options.h"
#include "kinome/math.h"

namespace kinome::app {

enum class StatsFormat { kNone, kText, kJson };

/// What the command line asks for.
struct Options {
  enum class Command { kRender, kFilm, kMerge, kListPlugins, kCheckPlugin, kNewPlugin };
  Command command = Command::kRender;

  std::string scene;
  std::map<std::string, std::string> defines;
  std::string output;  ///< "": beside the scene file
  unsigned threads = 0;
  std::string sensor = "0";  ///< index or id
  std::vector<std::string> search_paths;
  std::vector<std::string> plugin_paths;
  std::string isa;  ///< the best instruction set that plugins may use; "": see KINOME_ISA
  uint64_t seed = 0;
  std::string variant;
  int verbosity = 0;
  bool quiet = false;
  StatsFormat stats = StatsFormat::kNone;
  bool png = false;
  float exposure = 0;
  double seconds = 0;      ///< --time; 0: not given
  double rel_mse = 0;      ///< --error; 0: not given
  uint32_t renders = 0;    ///< --variance; 0: not given
  std::string checkpoint;  ///< "": none is kept
  double every = 60;       ///< seconds between two checkpoints
  bool resume = false;
  /// --part: of a picture in so many, this one, counted from 1; 0: all of them. 0 parts: not given.
  uint32_t part = 0, parts = 0;
  std::string display;  ///< HOST:PORT; "": none
  enum class Mpi { kAuto, kOn, kOff };
  Mpi mpi = Mpi::kAuto;
  bool lenient = false;
  bool check = false;
  std::optional<Vec2> inspect;  ///< pixel whose clusters are shown in place of rendering

  FilmOptions film;  ///< of `kinome film`

  // Of `kinome merge`; its -o is `output`.
  std::vector<std::string> files;  ///< of parts
  bool allow_missing = false;

  std::string plugin_name;  ///< of `kinome plugins NAME` ("": all of them), `check` and `new`
  bool markdown = false;
  bool mitsuba = false;

  // Of `kinome check`; its -D are `defines`.
  std::vector<std::string> only, except;  ///< names of checks
  std::string against;                    ///< an integrator
  double effort = 1;

  // Of `kinome new`.
  std::string category;
  std::string folder;  ///< "": named as the plugin, in the current one
};

/// Reads any number of command lines, each as parse_options does. To declare all options takes
/// several times as long as to read a line of them, and is done once.
class OptionsParser {
 public:
  OptionsParser();
  ~OptionsParser();
  std::optional<Options> parse(int argc, const char* const* argv);

 private:
  struct Language;
  std::map<Options::Command, std::unique_ptr<Language>> languages_;
};

/// nullopt where the command line asked for help or the version: it is printed already. Throws
/// Error for a command line that makes no sense.
std::optional<Options> parse_options(int argc, const char* const* argv);

/// The exit status of a command that can't do what its command line asks for: 2 for `kinome check`,
/// whose status 1 says that the plugin is wrong, and 1 for all others.
int failure_status_of(int argc, const char* const* argv);

/// Of each place to look for plugins or files that is no folder: a mistake as a rule, but a list of
/// places may be meant for several machines.
void warn_of_missing_folders(const Options& options);

}  // namespace kinome::app
