#pragma once

/// Descriptions of the faults of plugins, for users. The audit counts an object's faults by
/// description.
namespace kinome {

inline bool is_density(float pdf) {
  return pdf >= 0;
}

namespace audit_words {

inline constexpr const char* kValue = "a value that is not finite";
inline constexpr const char* kDensity = "a density that is negative or NaN";
inline constexpr const char* kDirection = "a direction that is not finite";
inline constexpr const char* kThrew = "an exception";

inline constexpr const char* kLength = "a direction that is not of unit length";
inline constexpr const char* kLightWithoutDensity = "a density of 0 where the value is not 0";
inline constexpr const char* kBsdfPdf = "a density from sample() that differs from eval_pdf()";
inline constexpr const char* kBsdfWeight =
    "a weight from sample() that differs from f / pdf of eval_pdf()";
inline constexpr const char* kEnvironmentPdf =
    "a density from sample_direct() that differs from pdf_environment()";
inline constexpr const char* kEnvironmentRadiance =
    "a radiance from sample_direct() that differs from eval_environment()";
inline constexpr const char* kSurfacePdf =
    "a density from sample_direct() that differs from pdf_surface()";
inline constexpr const char* kSurfaceRadiance =
    "a radiance from sample_direct() that differs from eval_surface()";
inline constexpr const char* kOffSurface = "a direction from sample_direct() that misses its shape";
inline constexpr const char* kDeltaPdf = "a density of a delta light that is not 1";
inline constexpr const char* kSampleBlock =
    "a sample from sample_direct_block() that differs from sample_direct()";
inline constexpr const char* kEvalBatch =
    "a value from eval_environment_batch() that differs from eval_environment() or "
    "pdf_environment()";
inline constexpr const char* kGrid = "a cell_grid() whose radiance differs from eval_environment()";
inline constexpr const char* kBilinear =
    "a cell_grid() with bilinear_quads whose quads are not bilinear";
inline constexpr const char* kSmooth = "a cell_grid() with smooth_quads whose quads are not smooth";
inline constexpr const char* kUnfollowed = "a density that its samples don't follow";

}  // namespace audit_words
}  // namespace kinome
