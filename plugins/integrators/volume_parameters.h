#pragma once

#include "transport/path_parameters.h"

/// Rows of a parameter table: those of `volpath` and `volpathmis`.
#define KINOME_VOLUME_PARAMETERS                                                                \
  {"max_depth", ParameterType::kInteger, "-1",                                                  \
   "Maximum edges of a path: 1 is emission alone, 2 direct light, 3 one bounce; -1: no limit. " \
   "Surfaces that light passes straight don't begin an edge."},                                 \
      {"rr_depth", ParameterType::kInteger, "5",                                                \
       "Russian roulette ends paths that were scattered more often than this."},                \
  {                                                                                             \
    "hide_emitters", ParameterType::kBoolean, "false",                                          \
        "The camera doesn't see emitters: it looks through surfaces that emit, and the sky is " \
        "black, also behind masks, panes and boundaries of media."                              \
  }
