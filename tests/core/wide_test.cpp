// Runs the checks of wide numbers from the library of each instruction set that this processor
// supports.

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "kinome/instruction_set.h"
#include "wide_checks.h"

namespace kinome::test {
namespace {

std::string path_of(InstructionSet set) {
  return std::string(KINOME_WIDE_CHECKS_FOLDER "/") + to_string(set) + ".so";
}

/// Returns the library for an instruction set, which the processor must support; nullptr if it
/// wasn't built.
const WideLibrary* library_of(InstructionSet set) {
  static std::map<InstructionSet, std::optional<WideLibrary>> known;
  const auto [entry, is_new] = known.try_emplace(set);
  if (is_new) {
    void* const library = dlopen(path_of(set).c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const function = library ? dlsym(library, "kinome_wide_library") : nullptr;
    if (function) entry->second = reinterpret_cast<WideLibrary (*)()>(function)();
  }
  return entry->second ? &*entry->second : nullptr;
}

/// Returns the instruction sets for which the checks are built.
std::vector<InstructionSet> built_sets() {
  std::vector<InstructionSet> sets;
  for (int i = 0; i < kInstructionSetCount; ++i) {
    const auto set = static_cast<InstructionSet>(i);
    if (std::filesystem::exists(path_of(set))) sets.push_back(set);
  }
  return sets;
}

/// Returns the names of the checks, which are equal for all instruction sets.
std::vector<std::string> names_of_checks() {
  std::vector<std::string> names;
  const std::vector<InstructionSet> sets = built_sets();
  const WideLibrary* const library = sets.empty() ? nullptr : library_of(sets.front());
  for (size_t i = 0; library && i < library->count; ++i)
    names.emplace_back(library->checks[i].name);
  return names;
}

class Wide : public ::testing::TestWithParam<std::tuple<InstructionSet, std::string>> {};

TEST_P(Wide, IsAsPromised) {
  const auto& [set, name] = GetParam();
  if (set > processor_instruction_set()) GTEST_SKIP() << "the processor lacks " << to_string(set);
  const WideLibrary* const library = library_of(set);
  ASSERT_NE(library, nullptr) << dlerror();
  EXPECT_STREQ(library->instruction_set, to_string(set));
  for (size_t i = 0; i < library->count; ++i) {
    if (library->checks[i].name != name) continue;
    Failures failures;
    library->checks[i].run(failures);
    for (const std::string& failure : failures.list()) ADD_FAILURE() << failure;
    return;
  }
  FAIL() << "unknown check";
}

INSTANTIATE_TEST_SUITE_P(, Wide,
                         ::testing::Combine(::testing::ValuesIn(built_sets()),
                                            ::testing::ValuesIn(names_of_checks())),
                         [](const auto& test) {
                           std::string name = to_string(std::get<0>(test.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + "_" + std::get<1>(test.param);
                         });

TEST(WideLibraries, AreOfAsManyLanesAsTheirRegistersHold) {
  EXPECT_GT(names_of_checks().size(), 15u);
  for (const auto& [set, lanes] :
       {std::pair(InstructionSet::kX86V2, 4u), std::pair(InstructionSet::kX86V3, 8u),
        std::pair(InstructionSet::kX86V4, 16u)}) {
    if (set > processor_instruction_set() || !std::filesystem::exists(path_of(set))) continue;
    ASSERT_NE(library_of(set), nullptr) << dlerror();
    EXPECT_EQ(library_of(set)->lanes, lanes);
  }
}

}  // namespace
}  // namespace kinome::test
