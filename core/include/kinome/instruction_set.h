#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "kinome/export.h"

/// The lowest level that includes all instructions that the compiler of this file may use by itself.
/// No level includes what came after the first parts of AVX-512, which the compiler may use by
/// -march=native if its own processor has it.
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

/// What a processor can do, in the levels of the x86-64 ABI, each of which has all of those before
/// it: SSE2, SSE4.2, AVX2 with FMA, AVX-512 (F, BW, CD, DQ, VL). Other processors have the
/// baseline.
enum class InstructionSet { kBaseline, kX86V2, kX86V3, kX86V4 };
inline constexpr int kInstructionSetCount = 4;

/// "x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"; of other processors, "baseline".
KINOME_EXPORT const char* to_string(InstructionSet set);
KINOME_EXPORT std::optional<InstructionSet> instruction_set_named(std::string_view name);

/// The least: what this program is built for, and so are plugins that are built but once.
KINOME_EXPORT InstructionSet least_instruction_set();

/// The best that this processor has, and the system saves the registers of.
KINOME_EXPORT InstructionSet processor_instruction_set();

/// The best that plugins are to use: `wanted` (--isa) or, if that is empty, what KINOME_ISA says
/// or, without one, the processor's. Error: no such set, less than least_instruction_set(), or the
/// processor lacks it.
KINOME_EXPORT InstructionSet choose_instruction_set(
    const std::string& wanted = {}, InstructionSet processors = processor_instruction_set());

}  // namespace kinome
