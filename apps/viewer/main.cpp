// kinome-view: displays a scene while it is rendered and edited.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <thread>

#include "kinome/error.h"
#include "kinome/image_files.h"
#include "kinome/output_files.h"
#include "kinome/read_files.h"
#include "options/interpret_options.h"
#include "options/option_errors.h"
#include "session/script.h"
#include "window/viewer_window.h"

namespace {

using kinome::Error;
using kinome::viewer::RenderSession;
using kinome::viewer::run_script;
using kinome::viewer::ViewerWindow;

struct Arguments {
  RenderSession::Options session;
  ViewerWindow::Options window;
  std::string script;  ///< "" opens a window
};

/// Time after which the program exits once its window is closed, even if a plugin ignores the
/// cancellation of its render. Pending saves are always finished.
constexpr std::chrono::milliseconds kMaxClosingTime{200};

/// Returns nullopt if the program should exit with `status`, for instance after --help.
std::optional<Arguments> parse(int argc, char** argv, int& status) {
  Arguments all;
  CLI::App app("Shows a scene while it is rendered, and while it is edited.", "kinome-view");
  std::vector<std::string> defines;
  std::string size;
  RenderSession::Options& session = all.session;
  app.add_option("scene.xml", session.scene, "Scene file in Mitsuba's XML language")->required();
  app.add_option("-D,--define", defines, "Set $KEY in the scene file (repeat for more)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--integrator", session.integrator, "Integrator plugin; default: the scene's own")
      ->type_name("NAME");
  app.add_option("-t,--threads", session.threads, "Threads; default: one per core")
      ->type_name("COUNT");
  app.add_option("--size", size, "Size of the image; default: the scene's")->type_name("WxH");
  app.add_option("-s,--sensor", session.sensor, "Sensor, by index or id; default: 0")
      ->type_name("SENSOR");
  app.add_option("-a,--append", session.load.search_paths,
                 "Also search these folders for the scene's files")
      ->allow_extra_args(false);
  app.add_option("--plugin-path", session.plugin_folders,
                 "Also search this folder for plugins (repeat for more)")
      ->allow_extra_args(false);
  app.add_option("--seed", session.seed, "Seed of all random numbers; default: 0")->type_name("N");
  app.add_flag("--lenient", session.load.lenient, "Leave out unsupported features of Mitsuba");
  app.add_option("--screenshot", all.window.screenshot,
                 "File that the key F12 writes; default: kinome-view.png")
      ->type_name("FILE");
  app.add_flag("--trace", all.window.trace, "Print a line for each image that is shown");
  app.add_option("--script", all.script,
                 "Run the commands in this file instead of opening a window ('-': standard input)")
      ->type_name("FILE");
  app.set_version_flag("--version", "kinome-view " KINOME_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& requested) {
    status = app.exit(requested);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw Error(kinome::app::describe_error(app, error, {argv + 1, argv + argc}, {}) +
                " (kinome-view --help lists the options)");
  }
  session.load.defines = kinome::app::parse_defines(defines);
  session.load.threads = session.threads;
  kinome::set_image_file_threads(session.threads);
  int used = 0;
  if (!size.empty() &&
      (std::sscanf(size.c_str(), "%dx%d%n", &session.width, &session.height, &used) != 2 ||
       used != static_cast<int>(size.size()) || session.width < 1 || session.height < 1)) {
    throw Error("--size: expected WxH in pixels, such as 640x480, got '" + size + "'");
  }
  all.window.title = session.scene + " - kinome-view";
  return all;
}

void view(Arguments all) {
  // The session may request a frame before the window exists.
  static std::atomic<bool> has_window = false;
  all.session.on_change = [] {
    if (has_window) ViewerWindow::wake();
  };
  RenderSession session(all.session);
  {
    ViewerWindow window(all.window);
    has_window = true;
    window.run(session);
    has_window = false;
    std::thread([&session] {
      do {
        std::this_thread::sleep_for(kMaxClosingTime);
      } while (session.is_to_save());
      kinome::remove_temporary_files();
      _exit(0);
    }).detach();
    session.close();
  }
}

int follow_script(const Arguments& all) {
  RenderSession session(all.session);
  if (all.script == "-") return run_script(std::cin, "-", session) > 0 ? 1 : 0;
  std::ifstream file(all.script);
  std::error_code failed;
  if (std::filesystem::is_directory(all.script, failed)) {
    throw Error(kinome::Location{all.script}, "it is a folder, not a file");
  }
  if (!file) {
    throw Error(kinome::Location{all.script},
                std::filesystem::exists(all.script, failed) ? "can't be read" : "no such file");
  }
  kinome::record_read_file(all.script);
  return run_script(file, all.script, session) > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  kinome::protect_read_files();
  try {
    int status = 0;
    auto all = parse(argc, argv, status);
    if (!all) return status;
    if (!all->script.empty()) {
      status = follow_script(*all);
      if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
      throw Error("stdout can't be written");
    }
    view(std::move(*all));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kinome-view: %s\n", error.what());
    return 1;
  }
}
