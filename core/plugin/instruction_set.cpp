#include "kinome/instruction_set.h"

#include <cstdlib>

#include "kinome/error.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace kinome {
namespace {

#if defined(__x86_64__)
constexpr const char* kInstructionSets[] = {"x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"};

/// Checks the instructions of x86-64-v3 for which not every compiler has a name.
bool has_companions_of_avx2() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_F16C) || !(c & bit_MOVBE)) return false;
  return __get_cpuid(0x80000001, &a, &b, &c, &d) && (c & bit_LZCNT);
}

InstructionSet detect() {
  __builtin_cpu_init();
  const bool v2 = __builtin_cpu_supports("ssse3") && __builtin_cpu_supports("sse4.1") &&
                  __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  if (!v2) return InstructionSet::kBaseline;
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
                  has_companions_of_avx2();
  if (!v3) return InstructionSet::kX86V2;
  const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return v4 ? InstructionSet::kX86V4 : InstructionSet::kX86V3;
}
#else
constexpr const char* kInstructionSets[] = {"baseline"};

InstructionSet detect() {
  return InstructionSet::kBaseline;
}
#endif

std::string list_of_names() {
  std::string list;
  for (const char* name : kInstructionSets) list += (list.empty() ? "" : ", ") + std::string(name);
  return list;
}

}  // namespace

const char* to_string(InstructionSet set) {
  const auto index = static_cast<size_t>(set);
  return index < std::size(kInstructionSets) ? kInstructionSets[index] : "?";
}

std::optional<InstructionSet> instruction_set_named(std::string_view name) {
  for (size_t i = 0; i < std::size(kInstructionSets); ++i) {
    if (name == kInstructionSets[i]) return static_cast<InstructionSet>(i);
  }
  return std::nullopt;
}

InstructionSet min_instruction_set() {
  return instruction_set_named(KINOME_ABI_ISA).value_or(InstructionSet::kBaseline);
}

InstructionSet processor_instruction_set() {
  static const InstructionSet best = detect();
  return best;
}

InstructionSet choose_instruction_set(const std::string& wanted, InstructionSet processors) {
  const char* const variable = std::getenv("KINOME_ISA");
  const std::string name = wanted.empty() && variable ? variable : wanted;
  if (name.empty()) return processors;
  const std::string from = wanted.empty() ? "KINOME_ISA: " : "--isa: ";
  const auto set = instruction_set_named(name);
  if (!set) {
    throw Error(from + "unknown instruction set '" + name + "' (available: " + list_of_names() +
                ")");
  }
  if (*set < min_instruction_set()) {
    throw Error(from + "must be at least " + to_string(min_instruction_set()) +
                ", for which this program and its plugins are built, got " + name);
  }
  if (*set > processors) {
    throw Error(from + "this processor lacks " + name + "; its best instruction set is " +
                to_string(processors));
  }
  return *set;
}

}  // namespace kinome
