#pragma once

#include <string>

namespace kinome::loader {

/// Returns the text of an XML file in UTF-8. UTF-16 and UTF-32 are recognised by their byte order
/// marks or by the zeros in their first character, Latin-1 by the XML declaration. Anything else is
/// returned unchanged.
std::string as_utf8(std::string bytes);

}  // namespace kinome::loader
