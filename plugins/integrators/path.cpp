/// Path tracing from the camera, as Mitsuba's `path`; see transport::Paths. Emitter samples also
/// pass surfaces that don't bend light (`thindielectric`, `mask`, `null`); each counts as an edge.
/// The expectation is that of Mitsuba, with less noise behind panes and leaves. Light of lamps
/// (`point`, `spot`, `directional`, …) still stops at such surfaces.
///
///     <integrator type="path"><integer name="max_depth" value="8"/></integrator>

#include "kinome/plugin.h"
#include "transport/paths/path_integrator.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    KINOME_PATH_PARAMETERS,
    {"hide_emitters", ParameterType::kBoolean, "false",
     "The camera doesn't see emitters: it looks through surfaces that emit, and the sky is black, "
     "also behind masks and panes."},
};

class PathPlugin final : public transport::PathIntegrator {
 public:
  explicit PathPlugin(const Properties& props)
      : PathIntegrator({PathLength(props), props.boolean("hide_emitters")}) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::PathPlugin, kinome::Category::kIntegrator, "path",
              "Path tracing from the camera with multiple importance sampling: light after any "
              "number of bounces.",
              kinome::kTable);
