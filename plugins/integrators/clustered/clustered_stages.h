#pragma once

#include "transport/stages.h"

namespace kinome {

inline constexpr Stage kLightLeftOutStage{"light left out", "finds out how much light is left out",
                                          true};
inline constexpr Stage kLightPointsStage{"light points", "places points on all that shines", true};
inline constexpr Stage kChooseStage{"choose", "picks points of light by that"};
inline constexpr Stage kEvaluateStage{"evaluate", "computes the light of each point"};

/// Of all that `clustered` may do, of which a render does a part.
inline constexpr Stage kClusteredStages[] = {
    kLightLeftOutStage,
    kLightPointsStage,
    {"tree", "builds the tree of lights", true},
    {"cells", "divides the light into cells", true},
    {"points", "draws points in each cell", true},
    {"pilot", "looks at the whole picture with a few rays"},
    {"plan", "learns what is visible from where, and where rays are needed"},
    {"allocate", "deals out rays to pixels", true},
    {"trial", "asks whether paths from the camera do as well"},
    {"main", "renders with what was learned"},
    part_of("main", kPrimaryStage),
    {"importance", "weighs clusters for each point"},
    kChooseStage,
    kEvaluateStage,
    kBounceStage,
    kShadeStage,
    {"strata", "sorts the light by where it comes from", false, "main"},
    {"candidates", "tries light without shadows", false, "main"},
    {"comb", "picks among the candidates", false, "main"},
    {"eye rays", "follows mirrors", false, "main"},
    part_of("main", kShadowStage),
    part_of("main", kFilmStage),
    {"caustics", "follows light from lamps to mirrors", false, "film"},
};

}  // namespace kinome
