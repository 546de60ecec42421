/// Path tracing through participating media, as Mitsuba's `volpath`; see transport::VolumePaths.
/// Surfaces that light passes straight (`null`, `mask`, `thindielectric`) don't count as edges, and
/// emitter samples see through them. Transmittances of homogeneous media are exact. In coloured
/// media, distances are sampled for all channels at once, as in `volpathmis`.
///
///     <integrator type="volpath"><integer name="max_depth" value="8"/></integrator>

#include "kinome/plugin.h"
#include "transport/media/paths/volume_integrator.h"
#include "volume_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {KINOME_VOLUME_PARAMETERS};

class VolumePathPlugin final : public transport::VolumeIntegrator {
 public:
  explicit VolumePathPlugin(const Properties& props)
      : VolumeIntegrator({PathLength(props), props.boolean("hide_emitters")}) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::VolumePathPlugin, kinome::Category::kIntegrator, "volpath",
              "Path tracing through participating media.", kinome::kTable);
