#pragma once

namespace kinome::drawing {

/// Font for legends, with lower-case letters, digits and punctuation; all other characters are
/// blank. The baseline is below the seventh row.
inline constexpr int kGlyphWidth = 6, kGlyphHeight = 9;
/// Returns true if a character's glyph has ink at column `x` and row `y`.
bool has_ink(char c, int x, int y);

}  // namespace kinome::drawing
