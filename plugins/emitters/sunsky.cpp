/// The sun and a cloudless sky by Hošek and Wilkie's models, as in Mitsuba 3 (sunsky_model.h). The
/// direction of the sun is `sun_direction`, or follows from a time and place. Radiance is in
/// W/m²/sr/nm, weighted like luminance. Before to_world, +z is up, -x is north and -y is east.
///
///     <emitter type="sunsky">
///       <float name="hour" value="17.5"/>
///       <float name="turbidity" value="4"/>
///       <transform name="to_world"><rotate x="1" angle="-90"/></transform>
///     </emitter>

#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "sunsky_environment.h"

namespace kinome::sunsky {
namespace {

constexpr Parameter kTable[] = {
    KINOME_SUNSKY_PARAMETERS,
    {"sun_direction", ParameterType::kVector, nullptr,
     "Direction toward the sun, in the world; alternative to time and place."},
    {"year", ParameterType::kInteger, "2010", "Year in the Gregorian calendar."},
    {"month", ParameterType::kInteger, "7", "Month, from 1 to 12."},
    {"day", ParameterType::kInteger, "10", "Day of the month, from 1."},
    {"hour", ParameterType::kFloat, "15", "Hour of the local time."},
    {"minute", ParameterType::kFloat, "0", "Minutes, added to the hour."},
    {"second", ParameterType::kFloat, "0", "Seconds, added to the hour."},
};

class SunSkyEmitter final : public SunSky {
 public:
  explicit SunSkyEmitter(const Properties& props) : SunSkyEmitter(props, SkySettings(props)) {}

 private:
  SunSkyEmitter(const Properties& props, const SkySettings& settings)
      : SunSky(settings, read_sun(props, settings.frame)) {}

  static Vec3 read_sun(const Properties& props, const LightFrame& frame) {
    if (!props.has("sun_direction")) {
      return read_sun_at(props, {props.real("latitude"), props.real("longitude"),
                            props.real("timezone"), read_calendar(props, "year"),
                            read_calendar(props, "month"), read_calendar(props, "day"),
                            props.real("hour"), props.real("minute"), props.real("second")});
    }
    for (const char* name : {"latitude", "longitude", "timezone", "year", "month", "day", "hour",
                             "minute", "second"}) {
      props.exclude(name, "sun_direction");
    }
    const Vec3 v = props.vector("sun_direction");
    const float max_abs = max_component(glm::abs(v));
    if (!(max_abs > 0) || !is_finite(v)) {
      throw props.error("sun_direction", "must be finite and not zero");
    }
    return frame.to_local(glm::normalize(v / max_abs));
  }
};

}  // namespace
}  // namespace kinome::sunsky

KINOME_PLUGIN(kinome::sunsky::SunSkyEmitter, kinome::Category::kEmitter, "sunsky",
              "The sun and a cloudless sky for a given place and time.", kinome::sunsky::kTable);
