#pragma once

namespace kinome::drawing {

/// A font for legends: small letters, digits and what goes between them; all else is blank. Letters
/// stand on the seventh row.
inline constexpr int kGlyphWidth = 6, kGlyphHeight = 9;
/// Whether a character has ink at a column and row of its glyph.
bool has_ink(char c, int x, int y);

}  // namespace kinome::drawing
