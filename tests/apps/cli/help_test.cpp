// Tests of the program's help about plugins and options.

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <sstream>

#include "cli.h"
#include "kinome/instruction_set.h"

namespace kinome::test::help_test {
namespace {

class Help : public Cli {};

TEST_F(Help, ListsPluginsByCategory) {
  const ProcessResult all = kinome({"plugins"});
  EXPECT_EQ(all.status, 0) << all.out;
  const size_t bsdf = all.out.find("bsdf\n");
  const size_t diffuse = all.out.find("\n  diffuse ");
  const size_t emitter = all.out.find("\nemitter\n");
  ASSERT_NE(bsdf, std::string::npos);
  EXPECT_LT(bsdf, diffuse);
  EXPECT_LT(diffuse, emitter);
  EXPECT_NE(all.out.find("another name for sobol"), std::string::npos);
}

TEST_F(Help, ListsOneCategory) {
  const ProcessResult all = kinome({"plugins"}), emitters = kinome({"plugins", "emitter"});
  EXPECT_EQ(emitters.status, 0) << emitters.out << emitters.err;
  EXPECT_EQ(emitters.out.rfind("emitter\n  area ", 0), 0u) << emitters.out;
  EXPECT_NE(all.out.find(emitters.out), std::string::npos) << emitters.out;
  EXPECT_EQ(emitters.out.find("\nfilm\n"), std::string::npos) << emitters.out;
  EXPECT_NE(kinome({"plugins", "emiter"}).err.find("did you mean 'emitter'?"), std::string::npos);
}

TEST_F(Help, ListsParametersOfAPlugin) {
  const ProcessResult film = kinome({"plugins", "hdrfilm"});
  EXPECT_EQ(film.status, 0);
  EXPECT_EQ(film.out.rfind("film/hdrfilm\n", 0), 0u) << film.out;
  for (const char* part : {"parameter", "width", "integer", "768", "rfilter", "component_format"}) {
    EXPECT_NE(film.out.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(kinome({"plugins", "film/hdrfilm"}).out, film.out);
  EXPECT_NE(kinome({"plugins", "ply"}).out.find("required"), std::string::npos);
}

/// The pages from which the site is built.
TEST_F(Help, WritesAPluginsPage) {
  const ProcessResult film = kinome({"plugins", "--markdown", "film/hdrfilm"});
  EXPECT_EQ(film.status, 0) << film.err;
  EXPECT_EQ(film.out.rfind("# hdrfilm\n\nFilm of linear radiance", 0), 0u) << film.out;
  EXPECT_NE(film.out.find("\n| `width` | integer | `768` | "), std::string::npos) << film.out;
  EXPECT_NE(film.out.find("\n| *rfilter* | rfilter |  | "), std::string::npos) << film.out;
  EXPECT_NE(kinome({"plugins", "--markdown", "ply"}).out.find(" | required | "), std::string::npos);
  EXPECT_NE(kinome({"plugins", "--markdown", "ldsampler"}).out.find("Another name for `sobol`. "),
            std::string::npos);
  EXPECT_NE(kinome({"plugins", "--markdown", "null"}).out.find("\n\nThis bsdf has no parameters.\n"),
            std::string::npos);
}

TEST_F(Help, TakesOptionsOnEitherSideOfAPluginsName) {
  std::filesystem::create_directories(folder_.path("bsdf"));
  std::filesystem::copy_file(KINOME_TEST_PLUGINS "/bsdf/diffuse.so", folder_.path("bsdf/chalk.so"));
  const std::string folder = folder_.folder();
  const std::vector<std::vector<std::string>> lines = {
      {"plugins", "chalk", "--plugin-path", folder},
      {"plugins", "--plugin-path", folder, "chalk"},
      {"--plugin-path", folder, "plugins", "chalk"},
      {"--plugin-path=" + folder, "plugins", "bsdf/chalk"},
      {"--isa", KINOME_ABI_ISA, "--plugin-path=" + folder, "plugins", "chalk"},
  };
  for (const auto& line : lines) {
    const ProcessResult result = kinome(line);
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.out.rfind("bsdf/chalk (another name for diffuse)\n", 0), 0u) << result.out;
  }
}

/// Help is wrapped to COLUMNS, or to the width of a terminal (a test has none), without changing
/// words.
TEST_F(Help, WrapsTextsOfPluginsAndOptions) {
  const auto words_of = [](const std::string& text) {
    std::istringstream stream(text);
    return std::vector<std::string>{std::istream_iterator<std::string>(stream), {}};
  };
  const auto longest_of = [](const std::string& text) {
    std::istringstream stream(text);
    size_t longest = 0;
    for (std::string line; std::getline(stream, line);) longest = std::max(longest, line.size());
    return longest;
  };
  for (const std::vector<std::string>& line :
       {std::vector<std::string>{"plugins"}, {"plugins", "clustered"}, {"--help"}}) {
    const auto run = [&](const std::string& setting) {
      std::vector<std::string> words{"env", "-u", "COLUMNS"};
      if (!setting.empty()) words.push_back(setting);
      words.push_back(KINOME_TEST_PROGRAM);
      words.insert(words.end(), line.begin(), line.end());
      return run_process(words);
    };
    const ProcessResult whole = run("");
    EXPECT_GT(longest_of(whole.out), 130u);
    for (const size_t width : {60, 80, 120}) {
      const ProcessResult wrapped = run("COLUMNS=" + std::to_string(width));
      EXPECT_LE(longest_of(wrapped.out), width) << wrapped.out;
      EXPECT_EQ(words_of(wrapped.out), words_of(whole.out));
    }
  }
}

TEST_F(Help, HelpNamesEveryOption) {
  const ProcessResult help = kinome({"-h"});
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(help.err, "");
  for (const char* option :
       {"--define",  "--output",      "--threads",  "--sensor",   "--append", "--seed",
        "--verbose", "--quiet",       "--mode",     "--stats",    "--trace",  "--png",
        "--time",    "--error",       "--variance", "--exposure", "--check",  "--display",
        "--part",    "--plugin-path", "--isa",      "--version"}) {
    EXPECT_NE(help.out.find(option), std::string::npos) << option;
  }
  EXPECT_EQ(kinome({"--help"}).out, help.out);
}

TEST_F(Help, ListsOptionsInGroupsWithExamples) {
  const std::string text = kinome({"--help"}).out;
  size_t last = 0;
  for (const char* group :
       {"\nUsage: kinome [OPTION]... scene.xml\n", "\nArguments:\n", "\nScene:\n", "\nImage:\n",
        "\nQuality:\n", "\nProgram:\n", "\n  -h, --help ", "\nExamples:\n"}) {
    const size_t at = text.find(group);
    ASSERT_NE(at, std::string::npos) << group << text;
    EXPECT_GT(at, last) << group;
    last = at;
  }
  EXPECT_NE(text.find("\n  --variance[=COUNT] "), std::string::npos) << text;
  EXPECT_EQ(text.find('{'), std::string::npos) << text;
}

/// Every example is a correct command line, although the files that it names are missing.
TEST_F(Help, ExamplesAreAccepted) {
  folder_.write("kinome.sh", "cd \"$(dirname \"$0\")\" && " KINOME_TEST_PROGRAM " $1 2>&1");
  int examples = 0;
  for (const char* command : {"", "film", "merge", "plugins", "check", "new"}) {
    std::istringstream help(kinome(*command ? std::vector<std::string>{command, "--help"}
                                            : std::vector<std::string>{"--help"})
                                .out);
    for (std::string line; std::getline(help, line);) {
      const std::string start = "  kinome ";
      if (line.rfind(start, 0) != 0 || line.find("   ", 2) != std::string::npos) continue;
      const ProcessResult result =
          run_process({"sh", folder_.path("kinome.sh"), line.substr(start.size())});
      EXPECT_EQ(result.out.find("--help lists"), std::string::npos) << line << result.out;
      const bool is_missing = result.out.find("no such file") != std::string::npos ||
                              result.out.find("plugins/bsdf/chalk.so") != std::string::npos;
      EXPECT_TRUE(result.status == 0 || is_missing) << line << "\n" << result.out;
      ++examples;
    }
  }
  EXPECT_GE(examples, 12);
}

}  // namespace
}  // namespace kinome::test::help_test
