#pragma once

#include "kinome/film.h"
#include "support/render.h"

namespace kinome::test {

inline std::shared_ptr<Film> make_film(const std::string& body) {
  return make<Film>("<film type=\"hdrfilm\">" + body + "</film>");
}
inline std::string film_size(int width, int height) {
  return "<integer name=\"width\" value=\"" + std::to_string(width) +
         "\"/><integer name=\"height\" value=\"" + std::to_string(height) + "\"/>";
}

inline std::string text(const char* name, const char* value) {
  return std::string("<string name=\"") + name + "\" value=\"" + value + "\"/>";
}

}  // namespace kinome::test
