#pragma once

#include <string>

#include "kinome/scene.h"

/// Conditions under which light is so rare for a method that a few thousand samples find it only by
/// chance, so that a difference is no finding. They are tested on the loaded scene or on its text.
namespace kinome::test {

/// Smallest alpha of lobes that methods find reliably. At grazing angles, a lobe with an alpha of
/// 0.1 already has most of its light in one of thousands of directions. Methods that ignore the
/// lobe (samples of emitters, light tracing) need the larger value.
inline constexpr double kMinAlpha = 0.03, kMinBluntAlpha = 0.2;
/// Returns true if a surface is so smooth that its lobe is found only by chance.
bool has_sharp_lobes(const std::string& text, double min_alpha);
bool has_mirrors(const Scene& scene);

/// Returns true if a lobe reflects so little that a path, which chooses among lobes, hardly ever
/// chooses it.
bool has_faint_lobes(const std::string& text);

/// Returns true if a beam is so narrow that it lights only a speck.
bool has_needles(const std::string& text);

/// Returns true if an emitting surface is so small or thin that rays from the sensor hardly ever
/// hit it. Light tracing shows it whenever it is visible; compared with that, the others are a
/// constant black.
bool has_specks(const Scene& scene);

/// Returns true if the scene is so small in the image that this many camera rays may miss it, while
/// light tracing can't.
bool is_hardly_seen(const Scene& scene, double rays);

/// Returns true if the sensor sees so little of the scene that at most `few` of the photons are
/// expected there. The estimate uses the size of the visible region at the median distance.
bool sees_few_photons(const Scene& scene, double photons, double few);

/// Returns approximately the maximum contribution of a path that reflects light directly from an
/// emitter, if it chooses one of all emitters.
double brightest_reflection(const Scene& scene);

/// Returns approximately the maximum radiance that a visible point would reflect of an emitter
/// sample that is occluded, if it were not; 0 if none is occluded.
double brightest_hidden(const Scene& scene);

/// Returns true if the flux of an emitter, radiance times area, comes near the limit of single
/// precision, so that methods that follow light from the emitter exceed it (tests/STABILITY.md,
/// "Limits"). `of_sky`: also tests environments, whose flux includes the area of the
/// whole scene.
bool has_vast_flux(const Scene& scene, bool of_sky);

}  // namespace kinome::test
