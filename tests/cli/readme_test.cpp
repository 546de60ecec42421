// The README says nothing that isn't so: its commands run, its listings are the files themselves,
// its tables are what the program prints.

#include <regex>
#include <set>

#include "cli.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;

/// All of `text` that lies between `begin` and `end`, in order.
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

std::vector<std::string> blocks(const std::string& readme, const std::string& language) {
  return between(readme, "```" + language + "\n", "```");
}

/// A command of the README in its small form. A render keeps all that the README says but its
/// size; run.sh keeps all but the number of tests (it is running us).
std::string small_form(std::string command) {
  if (std::regex_search(command, std::regex("^sh tests/run\\.sh$"))) {
    return command + " -R '^math\\.'";
  }
  const bool renders = command.find("scenes/render.sh") != std::string::npos ||
                       command.find(".xml") != std::string::npos;
  if (!renders) return command;
  command = std::regex_replace(command, std::regex("spp=[0-9]+"), "spp=1");
  if (command.find("spp=") == std::string::npos) command += " -D spp=1";
  if (command.find("first.xml") == std::string::npos) command += " -D width=64 -D height=64";
  return command;
}

class Readme : public Cli {
 protected:
  Readme() : readme_(read_text(std::string(KINOME_TEST_SOURCE) + "/README.md")) {}

  /// A clone's top folder as the README's reader sees it, whose build folder is ours.
  void make_clone() {
    for (const auto& entry : fs::directory_iterator(KINOME_TEST_SOURCE)) {
      const std::string name = entry.path().filename().string();
      if (name[0] == '.' || name == "out" || name.rfind("build", 0) == 0) continue;
      fs::create_symlink(entry.path(), folder_.path(name));
    }
    fs::create_symlink(KINOME_TEST_BUILD, folder_.path("build"));
    const std::regex name("<!-- ([a-z]+\\.xml): ");
    for (const std::string& xml : blocks(readme_, "xml")) {
      std::smatch match;
      ASSERT_TRUE(std::regex_search(xml, match, name)) << "an XML example without a file name";
      folder_.write(match[1], xml);
    }
  }
  /// Runs a shell script in that folder.
  ProcessResult shell(const std::string& script) {
    std::string flags;
    if (std::string(KINOME_TEST_SANITIZER) == "asan") flags = "-fsanitize=address,undefined";
    if (std::string(KINOME_TEST_SANITIZER) == "tsan") flags = "-fsanitize=thread";
    return run_process({"env", "CXX=" KINOME_TEST_CXX, "CXXFLAGS=" + flags, "sh", "-c",
                        "cd \"$1\" && eval \"$2\"", "sh", folder_.folder(), script},
                       600);
  }

  std::string readme_;
};

TEST_F(Readme, EveryCommandRuns) {
  make_clone();
  int commands = 0;
  for (const std::string& block : blocks(readme_, "sh")) {
    std::istringstream lines_of_block(block);
    for (std::string command; std::getline(lines_of_block, command);) {
      const ProcessResult result = shell(small_form(command));
      EXPECT_EQ(result.status, 0) << command << "\n" << result.out << result.err;
      ++commands;
      if (command == "sh tests/run.sh") {
        const size_t last = result.out.rfind('\n', result.out.size() - 2) + 1;
        EXPECT_TRUE(
            std::regex_match(result.out.substr(last), std::regex("[1-9][0-9]* passed, 0 failed\n")))
            << result.out;
      }
    }
  }
  EXPECT_GE(commands, 12);
  for (const char* file : {"out/hebe.exr", "out/hebe.png", "out/car.exr", "out/car.png",
                           "out/grace.exr", "first.exr", "first.png", "path.exr"}) {
    EXPECT_TRUE(fs::exists(folder_.path(file))) << file;
  }
}

TEST_F(Readme, ListingsAreTheFilesThemselves) {
  const std::string project = std::string(KINOME_TEST_SOURCE) + "/tests/sdk/project/";
  EXPECT_EQ(blocks(readme_, "cpp"),
            std::vector<std::string>{read_text(project + "sky_gradient.cpp")});
  EXPECT_EQ(blocks(readme_, "cmake"),
            std::vector<std::string>{read_text(project + "CMakeLists.txt")});
}

TEST_F(Readme, PluginTableIsWhatTheProgramPrints) {
  const auto tables =
      between(readme_, "<!-- plugins: kinome plugins --markdown -->\n", "<!-- /plugins -->");
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(kinome({"plugins", "--markdown"}).out, tables[0]);
}

TEST_F(Readme, MitsubasPluginsAreWhatTheProgramPrints) {
  const auto tables = between(
      readme_, "<!-- mitsuba: kinome plugins --mitsuba --markdown -->\n", "<!-- /mitsuba -->");
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(kinome({"plugins", "--mitsuba", "--markdown"}).out, tables[0]);
  // One a line, for people.
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
  const auto tables = between(readme_, "| option | meaning |\n", "\n\n");
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(options_in(tables[0]), options_in(kinome({"--help"}).out));
}

TEST_F(Readme, LinksLeadSomewhere) {
  const std::regex link("\\]\\(([^)#]+)\\)");
  int links = 0;
  for (std::sregex_iterator i(readme_.begin(), readme_.end(), link), end; i != end; ++i) {
    const std::string target = (*i)[1];
    if (target.find("://") != std::string::npos) continue;
    EXPECT_TRUE(fs::exists(fs::path(KINOME_TEST_SOURCE) / target)) << target;
    ++links;
  }
  EXPECT_GE(links, 4);
}

}  // namespace
}  // namespace kinome::test
