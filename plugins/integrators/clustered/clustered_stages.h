#pragma once

#include "transport/stages.h"

namespace kinome {

inline constexpr Stage kLightLeftOutStage{"light left out", "estimates how much light is left out",
                                          true};
inline constexpr Stage kLightPointsStage{"light points", "creates light points", true};
inline constexpr Stage kChooseStage{"choose", "selects light points by importance"};
inline constexpr Stage kEvaluateStage{"evaluate", "computes the light of selected points"};

/// Stages of all methods of `clustered`. A render runs some of them.
inline constexpr Stage kClusteredStages[] = {
    kLightLeftOutStage,
    kLightPointsStage,
    {"tree", "builds the tree of light points", true},
    {"cells", "divides the light into cells", true},
    {"points", "draws points in each cell", true},
    {"pilot", "renders the whole image with a few rays"},
    {"plan", "learns visibility, and estimates where rays are needed"},
    {"allocate", "assigns rays to pixels", true},
    {"trial", "compares product sampling with path tracing"},
    {"main", "renders with the learned visibility"},
    part_of("main", kPrimaryStage),
    {"importance", "computes the importance of clusters for each point"},
    kChooseStage,
    kEvaluateStage,
    kBounceStage,
    kShadeStage,
    {"strata", "computes strata of shadow rays", false, "main"},
    {"candidates", "evaluates light without shadows", false, "main"},
    {"comb", "selects shadow rays", false, "main"},
    {"eye rays", "traces eye rays", false, "main"},
    part_of("main", kShadowStage),
    part_of("main", kFilmStage),
    {"caustics", "traces light paths that form caustics", false, "film"},
};

}  // namespace kinome
