// Tests that README and docs are correct: their commands run, their listings equal the files, and
// their tables equal the program's output. (docs_test.py checks links.)

#include <map>
#include <regex>
#include <set>

#include "cli.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;

/// Returns all parts of `text` between `begin` and `end`, in order.
std::vector<std::string> between(const std::string& text, const std::string& begin,
                                 const std::string& end) {
  std::vector<std::string> found;
  for (size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    at += begin.size();
    const size_t stop = text.find(end, at);
    if (stop == std::string::npos) break;
    found.push_back(text.substr(at, stop - at));
    at = stop + end.size();
  }
  return found;
}

std::vector<std::string> blocks(const std::string& page, const std::string& language) {
  return between(page, "```" + language + "\n", "```");
}

/// Returns a command of these pages in a small form. A render keeps everything except its size and
/// budget. run.sh runs fewer tests, because it is running this test. One plugin is built.
std::string small_form(std::string command) {
  if (std::regex_search(command, std::regex("^sh tests/run\\.sh$"))) {
    return command + " -R '^base\\.'";
  }
  // tests/sdk builds all plugins of the project.
  if (command == "cmake --build my-plugins") {
    return command + " --target kinome_emitter_sky_gradient";
  }
  const bool renders = command.find("scenes/render.sh") != std::string::npos ||
                       command.find(".xml") != std::string::npos;
  if (!renders) return command;
  command = std::regex_replace(command, std::regex("spp=[0-9]+"), "spp=1");
  command = std::regex_replace(command, std::regex("--time [0-9.]+"), "--time 0.5");
  command = std::regex_replace(command, std::regex("--error [0-9.]+"), "--error 0.1");
  if (command.find("spp=") == std::string::npos) command += " -D spp=1";
  if (command.find("first.xml") == std::string::npos) command += " -D width=64 -D height=64";
  return command;
}

class Readme : public Cli {
 protected:
  /// README and docs, by their names in the repository.
  Readme() {
    const fs::path root = KINOME_TEST_SOURCE;
    pages_["README.md"] = read_text(root / "README.md");
    for (const auto& entry : fs::directory_iterator(root / "docs")) {
      if (entry.path().extension() != ".md") continue;
      pages_["docs/" + entry.path().filename().string()] = read_text(entry.path());
    }
  }

  /// Makes the top folder of a clone, with this build folder.
  void make_clone() {
    for (const auto& entry : fs::directory_iterator(KINOME_TEST_SOURCE)) {
      const std::string name = entry.path().filename().string();
      if (name[0] == '.' || name == "out" || name.rfind("build", 0) == 0) continue;
      fs::create_symlink(entry.path(), folder_.path(name));
    }
    fs::create_symlink(KINOME_TEST_BUILD, folder_.path("build"));
    const std::regex name("<!-- ([a-z]+\\.xml): ");
    for (const auto& [page, text] : pages_) {
      for (const std::string& xml : blocks(text, "xml")) {
        std::smatch match;
        if (std::regex_search(xml, match, name)) folder_.write(match[1], xml);
      }
    }
    ASSERT_TRUE(fs::exists(folder_.path("first.xml")));
  }
  /// Runs a shell script in that folder.
  ProcessResult shell(const std::string& script) {
    const std::string sanitizer = KINOME_TEST_SANITIZER;
    std::string flags;
    if (sanitizer == "asan" || sanitizer == "fuzz") flags = "-fsanitize=address,undefined";
    if (sanitizer == "tsan") flags = "-fsanitize=thread";
    return run_process({"env", "CXX=" KINOME_TEST_CXX, "CXXFLAGS=" + flags, "sh", "-c",
                        "cd \"$1\" && eval \"$2\"", "sh", folder_.folder(), script},
                       600);
  }

  std::map<std::string, std::string> pages_;
};

TEST_F(Readme, EveryCommandRuns) {
  make_clone();
  int commands = 0;
  for (const auto& [page, text] : pages_) {
    std::string script;
    for (const std::string& block : blocks(text, "sh")) script += block;
    std::istringstream lines_of_page(script);
    for (std::string command; std::getline(lines_of_page, command);) {
      const ProcessResult result = shell(small_form(command));
      EXPECT_EQ(result.status, 0) << page << ": " << command << "\n" << result.out << result.err;
      ++commands;
      if (command == "sh tests/run.sh") {
        const size_t last = result.out.rfind('\n', result.out.size() - 2) + 1;
        EXPECT_TRUE(
            std::regex_match(result.out.substr(last), std::regex("[1-9][0-9]* passed, 0 failed\n")))
            << result.out;
      }
    }
  }
  EXPECT_GE(commands, 24);
  for (const char* file : {"out/hebe.exr", "out/hebe.png", "out/car.exr", "out/car.png",
                           "out/grace.exr", "first.exr", "first.png", "path.exr"}) {
    EXPECT_TRUE(fs::exists(folder_.path(file))) << file;
  }
}

TEST_F(Readme, ListingsAreTheFilesThemselves) {
  const std::string project = std::string(KINOME_TEST_SOURCE) + "/tests/sdk/project/";
  const std::string source = read_text(project + "sky_gradient.cpp");
  const std::string& page = pages_["docs/writing-plugins.md"];
  EXPECT_EQ(blocks(page, "cpp"), std::vector<std::string>{source});
  EXPECT_EQ(blocks(page, "cmake"),
            std::vector<std::string>{read_text(project + "CMakeLists.txt")});
  // The README contains all of another one but its first comment.
  const std::vector<std::string> excerpts = blocks(pages_["README.md"], "cpp");
  ASSERT_EQ(excerpts.size(), 1u);
  const std::string dawn = read_text(project + "dawn.cpp");
  EXPECT_EQ(excerpts[0], dawn.substr(dawn.find("#include")));
  EXPECT_LE(std::count(excerpts[0].begin(), excerpts[0].end(), '\n'), 20);
}

TEST_F(Readme, PluginTableMatchesTheProgram) {
  const auto tables = between(pages_["docs/plugins.md"],
                              "<!-- plugins: kinome plugins --markdown -->\n", "<!-- /plugins -->");
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(kinome({"plugins", "--markdown"}).out, tables[0]);
}

TEST_F(Readme, MitsubasPluginsMatchTheProgram) {
  const auto tables =
      between(pages_["docs/mitsuba.md"], "<!-- mitsuba: kinome plugins --mitsuba --markdown -->\n",
              "<!-- /mitsuba -->");
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(kinome({"plugins", "--mitsuba", "--markdown"}).out, tables[0]);
  // One per line, human-readable.
  EXPECT_NE(kinome({"plugins", "--mitsuba"}).out.find("bsdf        diffuse              yes\n"),
            std::string::npos);
}

TEST_F(Readme, OptionTableHoldsEveryOptionAndNoOther) {
  const auto options_in = [](const std::string& text) {
    std::set<std::string> found;
    const std::regex option("--[a-z][a-z-]+");
    for (std::sregex_iterator i(text.begin(), text.end(), option), end; i != end; ++i) {
      found.insert(i->str());
    }
    return found;
  };
  const auto tables = between(pages_["docs/command-line.md"], "| option | meaning |\n", "\n\n");
  ASSERT_EQ(tables.size(), 1u);
  const std::set<std::string> of_pictures = options_in(kinome({"--help"}).out);
  EXPECT_EQ(options_in(tables[0]), of_pictures);
  // For animations, the options that images lack, and --output.
  std::set<std::string> own = {"--output"};
  for (const std::string& option : options_in(kinome({"film", "--help"}).out)) {
    if (of_pictures.count(option) == 0) own.insert(option);
  }
  const auto of_films = between(pages_["docs/film.md"], "| option | meaning |\n", "\n\n");
  ASSERT_EQ(of_films.size(), 1u);
  EXPECT_EQ(options_in(of_films[0]), own);
}

}  // namespace
}  // namespace kinome::test
