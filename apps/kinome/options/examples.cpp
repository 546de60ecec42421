#include "options/examples.h"

#include <utility>

namespace kinome::app {
namespace {

constexpr Example kRenderExamples[] = {
    {"kinome scene.xml --png", "Writes scene.exr, and scene.png for viewing."},
    {"kinome scene.xml -D spp=256 -t 8 -o image.exr",
     "Sets the scene's variable $spp, and uses 8 threads."},
    {"kinome scene.xml --crop 400,300,64,48 -o detail.jpg",
     "Renders 64 x 48 pixels into a JPEG file."},
    {"kinome scene.xml --time 60", "Renders the best image in a minute."},
    {"kinome scene.xml --error 0.01 --stats",
     "Renders to this relMSE, and prints times per stage."},
    {"kinome scene.xml --checkpoint scene.ck --resume",
     "Continues this command where it was interrupted."},
    {"kinome scene.xml --part 3/16", "Renders the third of 16 parts, for kinome merge."},
    {"kinome scene.xml --check", "Lists the scene's errors, and renders nothing."},
};
constexpr Example kFilmExamples[] = {
    {"kinome film scene.xml --path orbit --frames 100",
     "Renders a turn around the target, as scene.mp4."},
    {"kinome film scene.xml --path k.json --frames 9 -o %d.png",
     "Renders the keys of k.json, as 0.png to 8.png."},
};
constexpr Example kMergeExamples[] = {
    {"kinome merge scene-part*.exr -o scene.exr --png",
     "Adds the parts, and writes scene.png for viewing."},
};
constexpr Example kRelightExamples[] = {
    {"kinome relight scene.exr sun=1.5 lamps=0.2,0.3,0.4 -o evening.exr",
     "Makes the sun brighter, and the lamps darker and bluer."},
};
constexpr Example kPluginsExamples[] = {
    {"kinome plugins bsdf", "Lists all BSDFs."},
    {"kinome plugins roughplastic", "Lists the parameters of roughplastic."},
};
constexpr Example kCheckExamples[] = {
    {"kinome check roughplastic -D alpha=0.02", "Checks the BSDF with this roughness."},
    {"kinome check plugins/bsdf/chalk.so", "Checks the plugin in this file."},
};
constexpr Example kNewExamples[] = {
    {"kinome new bsdf chalk", "Creates the folder chalk with a new BSDF."},
};

constexpr std::pair<std::string_view, std::span<const Example>> kExamples[] = {
    {"", kRenderExamples},         {"film", kFilmExamples},       {"merge", kMergeExamples},
    {"relight", kRelightExamples}, {"plugins", kPluginsExamples}, {"check", kCheckExamples},
    {"new", kNewExamples}};

}  // namespace

std::span<const Example> examples_of(std::string_view word) {
  for (const auto& [command, examples] : kExamples) {
    if (word == command) return examples;
  }
  return {};
}

std::string examples_text(std::string_view word) {
  std::string text = "Examples:";
  for (const Example& example : examples_of(word)) {
    text += std::string("\n  ") + example.command + "\n      " + example.phrase;
  }
  return text;
}

}  // namespace kinome::app
