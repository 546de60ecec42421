/// The sun and a cloudless sky: Hošek and Wilkie's models, as in Mitsuba 3 (sunsky_model.h). The
/// sun stands in `sun_direction`, or where it is at a time and place; radiance is in W/m²/sr/nm, as
/// luminance has it. +z is up unless to_world says otherwise, and azimuths count from -x (north)
/// over -y (east).
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
     "Toward the sun, in the world; in place of time and place."},
    {"year", ParameterType::kInteger, "2010", "The date, in the Gregorian calendar."},
    {"month", ParameterType::kInteger, "7", "1 to 12."},
    {"day", ParameterType::kInteger, "10", "From 1 on."},
    {"hour", ParameterType::kFloat, "15", "Of the place's clocks."},
    {"minute", ParameterType::kFloat, "0", "Added to the hour."},
    {"second", ParameterType::kFloat, "0", "Added to the hour, too."},
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
      if (props.has(name)) throw props.error(name, "can't be given together with sun_direction");
    }
    const Vec3 v = props.vector("sun_direction");
    const float largest = max_component(glm::abs(v));
    if (!(largest > 0) || !is_finite(v)) {
      throw props.error("sun_direction", "must be finite and not zero");
    }
    return frame.to_local(glm::normalize(v / largest));
  }
};

}  // namespace
}  // namespace kinome::sunsky

KINOME_PLUGIN(kinome::sunsky::SunSkyEmitter, kinome::Category::kEmitter, "sunsky",
              "The sun and a cloudless sky, for a place and time.", kinome::sunsky::kTable);
