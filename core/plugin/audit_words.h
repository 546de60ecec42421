#pragma once

/// What plugins may be at fault with, as people are told. An object's faults are counted by these.
namespace kinome {

inline bool is_density(float pdf) {
  return pdf >= 0;
}

namespace audit_words {

inline constexpr const char* kValue = "a value that is not finite";
inline constexpr const char* kDensity = "a density that is negative or no number";
inline constexpr const char* kDirection = "a direction that is not finite";
inline constexpr const char* kThrew = "an exception";

inline constexpr const char* kLength = "a direction that is not of unit length";
inline constexpr const char* kLightWithoutDensity = "a density of 0 where there is light";
inline constexpr const char* kBsdfPdf = "a density from sample() that is not eval_pdf()'s";
inline constexpr const char* kBsdfWeight =
    "a weight from sample() that is not eval_pdf()'s f / pdf";
inline constexpr const char* kEnvironmentPdf =
    "a density from sample_direct() that is not pdf_environment()'s";
inline constexpr const char* kEnvironmentRadiance =
    "a radiance from sample_direct() that is not eval_environment()'s";
inline constexpr const char* kSurfacePdf =
    "a density from sample_direct() that is not pdf_surface()'s";
inline constexpr const char* kSurfaceRadiance =
    "a radiance from sample_direct() that is not eval_surface()'s";
inline constexpr const char* kOffSurface = "a direction from sample_direct() that misses its shape";
inline constexpr const char* kDeltaPdf = "a density of a delta light that is not 1";
inline constexpr const char* kSampleBlock = "a sample_direct_block() that is not sample_direct()";
inline constexpr const char* kEvalBatch =
    "an eval_environment_batch() that is not eval_environment() and pdf_environment()";
inline constexpr const char* kGrid = "a cell_grid() whose radiance is not eval_environment()'s";
inline constexpr const char* kBilinear = "a cell_grid() whose quads are not bilinear as it says";
inline constexpr const char* kSmooth = "a cell_grid() whose quads are not smooth as it says";
inline constexpr const char* kUnfollowed = "a density that its samples don't follow";

}  // namespace audit_words
}  // namespace kinome
