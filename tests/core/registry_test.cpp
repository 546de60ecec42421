// Tests which plugins are found, which libraries are rejected, and how parameters are read.

#include "kinome/plugin_registry.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "support/plugins/probe_registry.h"
#include "support/render.h"

namespace kinome::test::registry_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProbe = KINOME_UNIT_PLUGINS "/texture/probe.so";

std::string find_error(PluginRegistry& registry, const std::string& name,
                       Category category = Category::kTexture) {
  return error_of([&] { registry.find(category, name, {"f.xml", 4, 9}); });
}

std::string contents_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string create_error(Properties props) {
  return error_of([&] { probe_registry().create(props); });
}

Properties probe_properties() {
  return Properties(Category::kTexture, "probe", {"f.xml", 1, 1});
}

TEST(Registry, LoadsOnFirstUseAndOnce) {
  PluginRegistry registry({KINOME_UNIT_PLUGINS});
  EXPECT_TRUE(registry.loaded().empty());
  EXPECT_EQ(registry.seconds(), 0);
  const PluginDescriptor& probe = registry.find(Category::kTexture, "probe");
  EXPECT_STREQ(probe.name, "probe");
  EXPECT_EQ(&registry.find(Category::kTexture, "probe"), &probe);
  EXPECT_EQ(registry.loaded(), std::vector<std::string>{"texture/probe"});
  EXPECT_GT(registry.seconds(), 0);
}

TEST(Registry, ListsNamesWithoutLoading) {
  PluginRegistry registry({"/no/such/folder", KINOME_UNIT_PLUGINS});
  EXPECT_EQ(registry.names(Category::kTexture),
            (std::vector<std::string>{"boundary", "foreign_abi", "no_descriptor", "probe",
                                      "strict", "unresolved", "uv_probe", "wide_probe"}));
  EXPECT_TRUE(registry.names(Category::kShape).empty());
  EXPECT_TRUE(registry.has(Category::kTexture, "probe"));
  EXPECT_FALSE(registry.has(Category::kShape, "probe"));
  EXPECT_FALSE(registry.has(Category::kTexture, "prob"));
  EXPECT_FALSE(registry.has(Category::kTexture, "../texture/probe"));
  EXPECT_TRUE(registry.loaded().empty());
}

TEST(Registry, EarlierFoldersWin) {
  const TemporaryFolder folder;
  folder.write("texture/probe.so", "text");
  PluginRegistry first({folder.folder(), KINOME_UNIT_PLUGINS});
  EXPECT_NE(find_error(first, "probe"), "no error");
  PluginRegistry second({KINOME_UNIT_PLUGINS, folder.folder()});
  EXPECT_EQ(find_error(second, "probe"), "no error");
}

TEST(Registry, SuggestsTheNearestName) {
  PluginRegistry registry({KINOME_UNIT_PLUGINS});
  EXPECT_EQ(find_error(registry, "prob"),
            "f.xml:4:9: unknown texture plugin 'prob' (did you mean 'probe'?)");
  EXPECT_EQ(find_error(registry, "zzzzzz"),
            "f.xml:4:9: unknown texture plugin 'zzzzzz' (available: boundary, "
            "foreign_abi, no_descriptor, probe, strict, unresolved, uv_probe, wide_probe)");
  EXPECT_EQ(find_error(registry, "sphere", Category::kShape),
            "f.xml:4:9: unknown shape plugin 'sphere' (no plugins of this category "
            "in " KINOME_UNIT_PLUGINS ")");
}

TEST(Registry, NamesAreNotPaths) {
  PluginRegistry registry({KINOME_UNIT_PLUGINS "/texture"});
  for (const char* name : {"../texture/probe", "/etc/passwd", "", ".", ".."}) {
    EXPECT_NE(find_error(registry, name).find("unknown texture plugin"), std::string::npos);
  }
}

TEST(Registry, NoCodeOfAnotherAbiEverRuns) {
  const TemporaryFolder folder;
  const std::string trace = folder.path("trace");
  setenv("KINOME_TEST_TRACE", trace.c_str(), 1);
  PluginRegistry registry({KINOME_UNIT_PLUGINS});
  const std::string message = find_error(registry, "foreign_abi");
  EXPECT_EQ(message, "f.xml:4:9: '" KINOME_UNIT_PLUGINS
                     "/texture/foreign_abi.so' is not a usable "
                     "plugin: it was built for another ABI: its key is "
                     "'kinome-abi;interface=0;another;', this program's is '" KINOME_ABI_KEY "'");
  EXPECT_FALSE(fs::exists(trace));
  EXPECT_TRUE(registry.loaded().empty());
  // The file would exist if the library had been opened:
  EXPECT_NE(dlopen(KINOME_UNIT_PLUGINS "/texture/foreign_abi.so", RTLD_NOW | RTLD_LOCAL), nullptr);
  EXPECT_TRUE(fs::exists(trace));
  unsetenv("KINOME_TEST_TRACE");
}

TEST(Registry, RefusesPluginsWithOtherArithmetic) {
  const auto message = [&](const std::string& folder) {
    PluginRegistry registry({KINOME_UNIT_PLUGINS "/" + folder});
    const std::string text = find_error(registry, "wide_probe");
    const std::string start = "f.xml:4:9: '" KINOME_UNIT_PLUGINS "/" + folder +
                              "/texture/wide_probe.so' is not a usable plugin: ";
    EXPECT_EQ(text.substr(0, start.size()), start);
    return text.substr(std::min(start.size(), text.size()));
  };
  for (const char* folder : {"fast_math", "finite_math"}) {
    EXPECT_EQ(message(folder),
              "it was built with -ffast-math or one of its options, which are unsupported");
  }
  if (!instruction_set_named("x86-64")) GTEST_SKIP() << "not an x86-64 processor";
  for (const char* folder : {"native", "native_avx2"}) {
    EXPECT_EQ(message(folder),
              "it was built for a specific processor, as with -march=native, which can't be "
              "checked: build it for an x86-64 level, such as -march=x86-64-v4");
  }
}

TEST(Registry, FilesThatAreNoPlugins) {
  const TemporaryFolder folder;
  const std::string whole = contents_of(kProbe);
  ASSERT_GT(whole.size(), 5000u);
  folder.write("texture/text.so",
               "I am a text file, and longer than the header of an ELF file is.");
  folder.write("texture/empty.so", "");
  folder.write("texture/short.so", whole.substr(0, 30));
  folder.write("texture/header.so", whole.substr(0, 64));
  folder.write("texture/half.so", whole.substr(0, whole.size() / 2));
  folder.write("texture/almost.so", whole.substr(0, whole.size() - 1));
  std::string other_class = whole;
  other_class[4] = 1;  // EI_CLASS: 32 bits
  folder.write("texture/small.so", other_class);
  fs::create_directory(folder.path("texture/folder.so"));
  fs::copy_file("/proc/self/exe", folder.path("texture/program.so"));
  PluginRegistry registry({folder.folder()});
  const auto message = [&](const std::string& name) {
    const std::string text = find_error(registry, name);
    const std::string start =
        "f.xml:4:9: '" + folder.path("texture/" + name + ".so") + "' is not a usable plugin: ";
    EXPECT_EQ(text.substr(0, start.size()), start);
    return text.substr(std::min(start.size(), text.size()));
  };
  EXPECT_EQ(message("text"), "it is not an ELF file");
  EXPECT_EQ(message("empty"), "it is not an ELF file");
  EXPECT_EQ(message("short"), "it is not an ELF file");
  EXPECT_EQ(message("header"), "the ELF file is truncated");
  EXPECT_EQ(message("half"), "the ELF file is truncated");
  EXPECT_EQ(message("almost"), "the ELF file is truncated");
  EXPECT_EQ(message("small"), "it was built for a different architecture");
  EXPECT_EQ(message("folder"), "it can't be read");
  EXPECT_EQ(message("program"), "it has no section kinome_abi: KINOME_PLUGIN is missing");
  EXPECT_TRUE(registry.loaded().empty());
}

TEST(Registry, DamagedElfFilesNeverCrash) {
  const TemporaryFolder folder;
  const std::string whole = contents_of(kProbe);
  // Replaces each byte of the header after its magic number by extreme values. The key is damaged,
  // too, so that no library is opened.
  for (size_t i = 16; i < 64; ++i) {
    for (const char byte : {'\x00', '\x7f', '\xff'}) {
      std::string damaged = whole;
      damaged[i] = byte;
      damaged[whole.find("kinome-abi;interface=") + 8] = '?';
      folder.write("texture/damaged.so", damaged);
      PluginRegistry registry({folder.folder()});
      EXPECT_NE(find_error(registry, "damaged").find("is not a usable plugin"), std::string::npos);
    }
  }
}

TEST(Registry, RightKeyButNothingBehindIt) {
  PluginRegistry registry({KINOME_UNIT_PLUGINS});
  EXPECT_NE(find_error(registry, "no_descriptor").find("it exports no kinome_plugin"),
            std::string::npos);
  const std::string unresolved = find_error(registry, "unresolved");
  EXPECT_NE(unresolved.find("it can't be loaded: "), std::string::npos) << unresolved;
  EXPECT_NE(unresolved.find("kinome_test_that_nobody_defines"), std::string::npos) << unresolved;
}

TEST(Registry, APluginInTheWrongFolder) {
  const TemporaryFolder folder;
  folder.write("bsdf/probe.so", contents_of(kProbe));
  PluginRegistry registry({folder.folder()});
  EXPECT_NE(
      find_error(registry, "probe", Category::kBsdf).find("its category is texture, expected bsdf"),
      std::string::npos);
}

TEST(Registry, DefaultFoldersInOrder) {
  setenv("KINOME_PLUGIN_PATH", "/b::/c", 1);
  const auto folders = PluginRegistry::default_folders({"/a"});
  unsetenv("KINOME_PLUGIN_PATH");
  const fs::path beside = fs::canonical("/proc/self/exe").parent_path().parent_path();
  ASSERT_GE(folders.size(), 5u);
  EXPECT_EQ(std::vector(folders.begin(), folders.begin() + 5),
            (std::vector<std::string>{"/a", "/b", "/c", (beside / "plugins").string(),
                                      (beside / "lib/kinome/plugins").string()}));
}

TEST(Create, ChecksNames) {
  Properties props = probe_properties();
  props.set("colour", 1.0, {"f.xml", 2, 3});
  EXPECT_EQ(create_error(props),
            "f.xml:2:3: texture 'probe' has no parameter 'colour' (did you mean 'color'?)");
  Properties far = probe_properties();
  far.set("zzzzzz", 1.0, {"f.xml", 2, 3});
  EXPECT_EQ(create_error(far),
            "f.xml:2:3: texture 'probe' has no parameter 'zzzzzz' (it has boolean, integer, real, "
            "string, file, vector, color, transform, texture, unbounded, lamp, optional, choice, "
            "unread, broken)");
}

TEST(Create, ChecksEveryTypeAgainstTheTable) {
  const auto object = probe("");
  const std::vector<std::pair<std::string, Properties::Value>> values{
      {"a boolean", true},
      {"an integer", int64_t{1}},
      {"a float", 0.5},
      {"a string", std::string("ggx")},
      {"a vector", Vec3(0.5f)},
      {"an rgb color", UniformColor{Rgb(0.5f), false, false}},
      {"a spectrum", UniformColor{Rgb(0.5f), true, false}},
      {"a transform", Transform()},
      {"a texture", std::shared_ptr<Object>(object)},
  };
  // One letter for each value above: x if the parameter accepts it.
  const std::map<std::string, std::string> accepted{
      {"boolean", "x--------"},  {"integer", "-x-------"},   {"real", "-xx------"},
      {"string", "---x-----"},   {"vector", "----x----"},    {"color", "-xx-xxx--"},
      {"texture", "-xx-xxx-x"},  {"unbounded", "-xx-xxx-x"}, {"lamp", "-xx-xxx-x"},
      {"optional", "-xx-xxx-x"}, {"choice", "---x-----"},    {"transform", "-------x-"},
      {"file", "---x-----"},
  };
  for (const auto& [name, letters] : accepted) {
    for (size_t i = 0; i < values.size(); ++i) {
      Properties props = probe_properties();
      props.set(name, values[i].second, {"f.xml", 2, 3});
      const std::string message = create_error(props);
      const bool type_error = message.find("f.xml:2:3: '" + name + "' must be ") == 0 &&
                              message.find(", got " + values[i].first) != std::string::npos;
      EXPECT_EQ(type_error, letters[i] == '-')
          << name << ": " << values[i].first << ": " << message;
    }
  }
}

TEST(Create, RequiresMandatoryParameters) {
  Properties props(Category::kTexture, "strict", {"f.xml", 1, 1});
  EXPECT_EQ(create_error(props), "f.xml:1:1: texture 'strict' needs parameter 'needed', a string");
  props.set("needed", std::string("x"), {"f.xml", 2, 3});
  EXPECT_EQ(create_error(props), "f.xml:1:1: texture 'strict' needs a nested film");
}

TEST(Create, MatchesObjectsByCategory) {
  const auto bsdf = load_object_from_string("<bsdf type='diffuse'/>", "", {}, probe_registry());
  Properties two = probe_properties();
  two.set("whatever", bsdf, {"f.xml", 2, 3});
  two.set("another", bsdf, {"f.xml", 3, 3});
  const auto probe = std::dynamic_pointer_cast<Probe>(probe_registry().create(two));
  EXPECT_EQ(probe->objects, (std::vector<std::shared_ptr<Object>>{bsdf, bsdf}));
  Properties three = two;
  three.set("third", bsdf, {"f.xml", 4, 3});
  EXPECT_EQ(create_error(three), "f.xml:4:3: texture 'probe' takes at most 2 bsdfs");
  Properties misnamed = probe_properties();
  misnamed.set("real", bsdf, {"f.xml", 2, 3});
  EXPECT_EQ(create_error(misnamed), "f.xml:2:3: 'real' must be a float, got a bsdf");
  Properties strange = probe_properties();
  strange.set("x", load_object_from_string("<rfilter type='box'/>", "", {}, probe_registry()),
              {"f.xml", 2, 3});
  EXPECT_EQ(create_error(strange), "f.xml:2:3: texture 'probe' takes no rfilter");
}

std::shared_ptr<Probe> boundary_of(const std::string& children) {
  return std::dynamic_pointer_cast<Probe>(load_object_from_string(
      "<texture type='boundary'>" + children + "</texture>", "f.xml", {}, probe_registry()));
}

TEST(Create, MatchesNamedObjectsByName) {
  const auto probe = boundary_of(
      "<bsdf name='exterior' type='null'/><bsdf type='plastic'/>"
      "<bsdf name='interior' type='diffuse'/>");
  ASSERT_EQ(probe->objects.size(), 4u);
  EXPECT_EQ(probe->objects[0]->plugin(), "bsdf/diffuse");
  EXPECT_EQ(probe->objects[1]->plugin(), "bsdf/null");
  EXPECT_EQ(probe->objects[2], nullptr);
  EXPECT_EQ(probe->objects[3], nullptr);
  EXPECT_EQ(probe->string, "exterior _arg_0 interior ");
}

TEST(Create, NamesMissingAndWrongObjects) {
  const std::string interior = "<bsdf name='interior' type='diffuse'/>";
  const std::pair<std::string, const char*> cases[] = {
      {"", "f.xml:1:1: texture 'boundary' needs parameter 'interior', a bsdf"},
      {"<bsdf type='diffuse'/>",
       "f.xml:1:1: texture 'boundary' needs parameter 'interior', a bsdf"},
      {"<emitter name='interior' type='constant'/>",
       "f.xml:1:26: 'interior' must be a bsdf, got an emitter"},
      {"<float name='interior' value='1'/>", "f.xml:1:26: 'interior' must be a bsdf, got a float"},
      {interior + "<emitter type='constant'/>",
       "an emitter of texture 'boundary' needs a name (one of light)"},
      {interior + "<texture type='checkerboard'/>",
       "a texture of texture 'boundary' needs a name (one of mask)"},
      {interior + "<emitter name='lihgt' type='constant'/>",
       "texture 'boundary' has no parameter 'lihgt' (did you mean 'light'?)"},
      {interior + "<bsdf type='null'/><bsdf type='null'/>",
       "texture 'boundary' takes at most 1 bsdf"},
  };
  for (const auto& [children, message] : cases) {
    const std::string error = error_of([&, &xml = children] { boundary_of(xml); });
    EXPECT_NE(error.find(message), std::string::npos) << error;
  }
}

TEST(Create, ListsUnreadParameters) {
  Properties props = probe_properties();
  props.set("real", 1.0, {"f.xml", 2, 3});
  props.set("unread", 1.0, {"f.xml", 3, 3});
  EXPECT_EQ(create_error(props), "f.xml:3:3: texture 'probe' has unused parameters: 'unread'");
}

TEST(Create, AddsThePositionToErrorsOfConstructors) {
  Properties props = probe_properties();
  props.set("broken", true, {"f.xml", 2, 3});
  EXPECT_EQ(create_error(props), "f.xml:1:1: from deep inside");
}

}  // namespace
}  // namespace kinome::test::registry_test
