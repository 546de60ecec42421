#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "kinome/export.h"

/// Lowest level that includes all instructions that the compiler may generate for this file.
/// Extensions after the first parts of AVX-512 are in no level; -march=native enables them if the
/// build machine has them.
#if !defined(__x86_64__)
#define KINOME_ABI_ISA "baseline"
#elif defined(__AVX512VNNI__) || defined(__AVX512VBMI__) || defined(__AVX512VBMI2__) ||     \
    defined(__AVX512IFMA__) || defined(__AVX512BITALG__) || defined(__AVX512VPOPCNTDQ__) || \
    defined(__AVX512BF16__) || defined(__AVX512FP16__) || defined(__AVX512ER__) ||          \
    defined(__AVX10_1__) || defined(__AVXVNNI__) || defined(__AVXIFMA__) ||                 \
    defined(__GFNI__) || defined(__APX_F__)
#define KINOME_ABI_ISA "of-no-level"
#elif defined(__AVX512F__)
#define KINOME_ABI_ISA "x86-64-v4"
#elif defined(__AVX__) || defined(__FMA__) || defined(__BMI__) || defined(__BMI2__)
#define KINOME_ABI_ISA "x86-64-v3"
#elif defined(__SSE3__) || defined(__SSSE3__) || defined(__SSE4_1__) || defined(__POPCNT__)
#define KINOME_ABI_ISA "x86-64-v2"
#else
#define KINOME_ABI_ISA "x86-64"
#endif

namespace kinome {

/// Instruction set levels of the x86-64 ABI, each including the previous ones: SSE2, SSE4.2, AVX2
/// with FMA, AVX-512 (F, BW, CD, DQ, VL). Other processors have kBaseline.
enum class InstructionSet { kBaseline, kX86V2, kX86V3, kX86V4 };
inline constexpr int kInstructionSetCount = 4;

/// "x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"; "baseline" on other processors.
KINOME_EXPORT const char* to_string(InstructionSet set);
KINOME_EXPORT std::optional<InstructionSet> instruction_set_named(std::string_view name);

/// Returns the lowest set: that of this program, and of plugins built only once.
KINOME_EXPORT InstructionSet min_instruction_set();

/// Returns the highest set that this processor and its operating system support.
KINOME_EXPORT InstructionSet processor_instruction_set();

/// Returns the highest set that plugins may use: `wanted` (--isa), or the environment variable
/// KINOME_ISA if `wanted` is empty, or the processor's. Throws Error if the name is unknown, the
/// set is below min_instruction_set(), or the processor lacks it.
KINOME_EXPORT InstructionSet choose_instruction_set(
    const std::string& wanted = {}, InstructionSet processors = processor_instruction_set());

}  // namespace kinome
