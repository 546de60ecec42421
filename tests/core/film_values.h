#pragma once

#include "kinome/film.h"
#include "kinome/film_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "kinome/color.h"
#include "kinome/sampler.h"
#include "support/film_xml.h"

/// Random samples for tests of films.
namespace kinome::test::film_values {

/// Adds `per_pixel` random samples to each pixel of the tile.
template <class Values>
void fill(FilmTile& tile, int per_pixel, const Values& values) {
  const Rect& r = tile.pixels();
  for (int y = r.y0; y < r.y1; ++y) {
    for (int x = r.x0; x < r.x1; ++x) {
      for (int s = 0; s < per_pixel; ++s) {
        const uint64_t h = hash_words(static_cast<uint64_t>(x), static_cast<uint64_t>(y), s);
        const Vec2 u(to_unit_float(static_cast<uint32_t>(h)),
                     to_unit_float(static_cast<uint32_t>(h >> 32)));
        tile.add(film_position(x, y, u), values(x, y));
      }
    }
  }
}

}  // namespace kinome::test::film_values
