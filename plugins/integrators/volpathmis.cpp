/// Path tracing through participating media, for scenes of Mitsuba's `volpathmis`. It is the same
/// method as `volpath`, which samples distances for all channels of coloured media at once.
///
///     <integrator type="volpathmis"><integer name="max_depth" value="8"/></integrator>

#include "kinome/plugin.h"
#include "transport/media/paths/volume_integrator.h"
#include "volume_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    KINOME_VOLUME_PARAMETERS,
    ignored_row("use_spectral_mis", ParameterType::kBoolean,
                "distances are always sampled for all channels at once"),
};

class SpectralPathPlugin final : public transport::VolumeIntegrator {
 public:
  explicit SpectralPathPlugin(const Properties& props)
      : VolumeIntegrator({PathLength(props), props.boolean("hide_emitters")}) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::SpectralPathPlugin, kinome::Category::kIntegrator, "volpathmis",
              "Path tracing through participating media, the same as `volpath`.", kinome::kTable);
