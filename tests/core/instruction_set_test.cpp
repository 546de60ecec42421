#include "kinome/instruction_set.h"

#include <dlfcn.h>

#include "kinome/error.h"
#include "kinome/plugin_registry.h"
#include "support/render.h"

namespace kinome::test::instruction_set_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "wide_probe";
constexpr InstructionSet kAll[] = {InstructionSet::kBaseline, InstructionSet::kX86V2,
                                   InstructionSet::kX86V3, InstructionSet::kX86V4};

std::string error_of(const std::function<void()>& fn) {
  try {
    fn();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

/// Returns the doc string of the library that the registry selects for the plugin.
std::string taken_by(PluginRegistry& registry) {
  return registry.find(Category::kTexture, kName).doc;
}

fs::path library_of(InstructionSet set) {
  const fs::path folder = KINOME_UNIT_PLUGINS "/texture";
  const std::string file = std::string(kName) + ".so";
  return set == InstructionSet::kBaseline ? folder / file : folder / to_string(set) / file;
}

/// Returns the instruction sets of the builds of wide_probe that this processor supports.
std::vector<InstructionSet> runnable() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : kAll) {
    if (set <= processor_instruction_set() && fs::exists(library_of(set))) sets.push_back(set);
  }
  return sets;
}

class KinomeIsa {
 public:
  explicit KinomeIsa(const char* value) { setenv("KINOME_ISA", value, 1); }
  ~KinomeIsa() {
    if (old_) {
      setenv("KINOME_ISA", old_->c_str(), 1);
    } else {
      unsetenv("KINOME_ISA");
    }
  }

 private:
  std::optional<std::string> old_ = std::getenv("KINOME_ISA")
                                        ? std::optional<std::string>(std::getenv("KINOME_ISA"))
                                        : std::nullopt;
};

TEST(InstructionSets, HaveNames) {
  for (const InstructionSet set : kAll) {
    if (set > processor_instruction_set()) continue;
    EXPECT_EQ(instruction_set_named(to_string(set)), set);
  }
  for (const char* name : {"", "avx2", "x86-64-v5", "x86-64-", "X86-64", "x86-64-v4 "}) {
    EXPECT_EQ(instruction_set_named(name), std::nullopt) << name;
  }
}

TEST(InstructionSets, AreChosen) {
  const InstructionSet best = processor_instruction_set();
  const InstructionSet least = min_instruction_set();
  const std::string lowest = to_string(least);
  {
    const KinomeIsa empty("");
    EXPECT_EQ(choose_instruction_set(), best);
    EXPECT_EQ(choose_instruction_set(to_string(best)), best);
    EXPECT_EQ(choose_instruction_set(lowest), least);
  }
  {
    const KinomeIsa low(lowest.c_str());
    EXPECT_EQ(choose_instruction_set(), least);
    EXPECT_EQ(choose_instruction_set(to_string(best)), best);
  }
  const KinomeIsa wrong("avx2");
  const std::string rest = "unknown instruction set 'avx2' (available: ";
  EXPECT_EQ(error_of([] { choose_instruction_set(); }).rfind("KINOME_ISA: " + rest, 0), 0u)
      << error_of([] { choose_instruction_set(); });
  EXPECT_EQ(error_of([] { choose_instruction_set("sse"); }).rfind("--isa: unknown ", 0), 0u);
  EXPECT_EQ(choose_instruction_set(lowest), least);
}

TEST(InstructionSets, OfALesserProcessorAreRefused) {
  if (!instruction_set_named("x86-64")) GTEST_SKIP() << "not an x86-64 processor";
  const InstructionSet lesser = std::max(InstructionSet::kX86V3, min_instruction_set());
  EXPECT_EQ(choose_instruction_set(to_string(lesser), lesser), lesser);
  EXPECT_EQ(error_of([&] { choose_instruction_set("x86-64-v4", InstructionSet::kX86V3); }),
            "--isa: this processor lacks x86-64-v4; its best instruction set is x86-64-v3");
  if (min_instruction_set() > InstructionSet::kX86V2) return;  // the set isn't available
  const KinomeIsa beyond("x86-64-v2");
  EXPECT_EQ(choose_instruction_set({}, lesser), InstructionSet::kX86V2);
  EXPECT_EQ(error_of([&] { choose_instruction_set({}, InstructionSet::kBaseline); }),
            "KINOME_ISA: this processor lacks x86-64-v2; its best instruction set is x86-64");
}

/// The program rejects sets below the lowest one for which it and its plugins are built.
TEST(InstructionSets, LessThanAllIsBuiltForIsRefused) {
  const std::string least = to_string(min_instruction_set());
  for (int i = 0; i < static_cast<int>(min_instruction_set()); ++i) {
    const std::string less = to_string(static_cast<InstructionSet>(i));
    EXPECT_EQ(error_of([&] { choose_instruction_set(less); }),
              "--isa: must be at least " + least +
                  ", for which this program and its plugins are built, got " + less);
  }
}

TEST(RegistryOfInstructionSets, TakesTheBestThatItMay) {
  const std::vector<InstructionSet> sets = runnable();
  ASSERT_FALSE(sets.empty());
  PluginRegistry best({KINOME_UNIT_PLUGINS}, processor_instruction_set());
  EXPECT_EQ(taken_by(best), to_string(sets.back()));
  EXPECT_EQ(best.instruction_set(), processor_instruction_set());
  for (const InstructionSet set : sets) {
    PluginRegistry registry({KINOME_UNIT_PLUGINS}, set);
    EXPECT_EQ(taken_by(registry), to_string(set));
    EXPECT_EQ(registry.loaded(), std::vector<std::string>{std::string("texture/") + kName});
    // This plugin is built for the baseline only.
    EXPECT_STREQ(registry.find(Category::kTexture, "uv_probe").name, "uv_probe");
  }
}

TEST(RegistryOfInstructionSets, ListsTheInstalledSets) {
  PluginRegistry registry({KINOME_UNIT_PLUGINS}, InstructionSet::kBaseline);
  std::vector<InstructionSet> expected;
  for (const InstructionSet set : kAll) {
    if (fs::exists(library_of(set))) expected.push_back(set);
  }
  EXPECT_EQ(registry.instruction_sets(Category::kTexture, kName), expected);
  EXPECT_EQ(registry.instruction_sets(Category::kTexture, "uv_probe"),
            std::vector{InstructionSet::kBaseline});
  EXPECT_TRUE(registry.instruction_sets(Category::kTexture, "none").empty());
  for (const std::string& name : registry.names(Category::kTexture)) {
    EXPECT_EQ(name.find("x86"), std::string::npos) << name;
  }
}

TEST(RegistryOfInstructionSets, TakesTheNextWhereOneIsMissing) {
  const std::vector<InstructionSet> sets = runnable();
  const TemporaryFolder folder;
  fs::create_directories(folder.path("texture"));
  for (const InstructionSet set : sets) {
    const fs::path to = set == InstructionSet::kBaseline
                            ? fs::path(folder.path("texture"))
                            : fs::path(folder.path("texture")) / to_string(set);
    fs::create_directories(to);
    fs::copy_file(library_of(set), to / (std::string(kName) + ".so"));
    PluginRegistry registry({folder.folder(), KINOME_UNIT_PLUGINS}, processor_instruction_set());
    EXPECT_EQ(taken_by(registry), to_string(set));  // from the first folder, whatever the second
                                                    // has
  }
}

TEST(RegistryOfInstructionSets, RefusesMoreThanItMayUse) {
  const std::vector<InstructionSet> sets = runnable();
  if (sets.size() < 2) GTEST_SKIP() << "the processor supports only the baseline";
  const InstructionSet best = sets.back();
  const TemporaryFolder folder;
  fs::create_directories(folder.path("texture"));
  const std::string file = folder.path(std::string("texture/") + kName + ".so");
  fs::copy_file(library_of(best), file);  // in the folder of the baseline
  PluginRegistry registry({folder.folder()}, sets[sets.size() - 2]);
  const std::string message = error_of([&] { taken_by(registry); });
  EXPECT_NE(message.find("'" + file +
                         "' is not a usable plugin: it is built for the instruction "
                         "set " +
                         to_string(best) + ", but the best one allowed is " +
                         to_string(sets[sets.size() - 2])),
            std::string::npos)
      << message;
  PluginRegistry willing({folder.folder()}, best);
  EXPECT_EQ(taken_by(willing), to_string(best));
}

TEST(RegistryOfInstructionSets, RefusesSetsThatTheProcessorLacks) {
  // No processor supports this set, so that none of its code may run.
  std::ifstream stream(library_of(InstructionSet::kBaseline), std::ios::binary);
  std::string library{std::istreambuf_iterator<char>(stream), {}};
  const std::string set = to_string(InstructionSet::kBaseline), key = ";isa=" + set + ";";
  size_t changed = 0;
  for (size_t at = library.find(key); at != std::string::npos; at = library.find(key, at)) {
    library[at + key.size() - 2] = '?';
    ++changed;
  }
  ASSERT_GT(changed, 0u);
  const TemporaryFolder folder;
  const std::string file = folder.write(std::string("texture/") + kName + ".so", library);
  PluginRegistry registry({folder.folder()}, processor_instruction_set());
  std::string unknown = set;
  unknown.back() = '?';
  const std::string message = error_of([&] { taken_by(registry); });
  EXPECT_NE(message.find("'" + file +
                         "' is not a usable plugin: it is built for the instruction "
                         "set " +
                         unknown + ", which this processor lacks"),
            std::string::npos)
      << message;
  EXPECT_EQ(dlopen(file.c_str(), RTLD_NOW | RTLD_NOLOAD), nullptr);
}

}  // namespace
}  // namespace kinome::test::instruction_set_test
