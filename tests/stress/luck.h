#pragma once

#include <string>

#include "kinome/scene.h"

/// What makes light of a scene so rare for a method that a few thousand samples find it by luck
/// alone, so that a difference there is no finding. By the scene as it is loaded, or its text.
namespace kinome::test {

/// Seen along the surface, a lobe of a tenth already has most of its light in one of thousands of
/// directions: what is blunt (samples of emitters, light tracing) finds it by luck.
inline constexpr double kLeastAlpha = 0.03, kLeastBluntAlpha = 0.2;
/// Whether anything is so smooth that its lobe is a matter of luck.
bool has_sharp_lobes(const std::string& text, double least_alpha);
bool has_mirrors(const Scene& scene);

/// Whether a lobe reflects so little that a path, which chooses one of them, hardly ever chooses
/// that one.
bool has_faint_lobes(const std::string& text);

/// Whether there are beams so narrow that what they light is a speck.
bool has_needles(const std::string& text);

/// Whether anything that emits is so small or thin that rays from the sensor hardly ever meet it,
/// though light tracing shows it whenever it is in sight: as a constant black against that.
bool has_specks(const Scene& scene);

/// Whether all there is is so small in the sensor's eyes that so many camera rays may well miss it,
/// where light tracing can't.
bool is_hardly_seen(const Scene& scene, double rays);

/// Whether the sensor sees so little of the scene that of so many photons only `few` may arrive
/// there: by the size of what it sees at the distance that most of it has.
bool has_small_sight(const Scene& scene, double photons, double few);

/// About the most that a path brings from anything that reflects what comes straight from a light,
/// where it chooses one light of all.
double brightest_reflection(const Scene& scene);

/// About the most that anything in sight would reflect of one light that is hidden from it, if
/// nothing hid it; 0 where no light is.
double brightest_hidden(const Scene& scene);

/// Whether the flux of a light, which is radiance times areas, comes near the end of single
/// precision, so that what follows it from the light can't (tests/STABILITY.md, "what is not
/// held"); `of_sky`: that of a sky, too, which takes the area of the whole scene.
bool has_vast_flux(const Scene& scene, bool of_sky);

}  // namespace kinome::test
