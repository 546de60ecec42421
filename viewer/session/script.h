#pragma once

#include <istream>
#include <string>

#include "session/render_session.h"

namespace kinome::viewer {

/// Does what a script says with a session, as someone at the window would, and prints what comes of
/// it. One command a line:
///
///     set PATH VALUE        a parameter, as XML would write its value; a transform by 16 numbers
///     texture PATH FILE     a bitmap of this file in place of a value; or "checkerboard"
///     normalmap PATH FILE   puts one around a BSDF, with a bitmap of this file
///     bumpmap PATH FILE
///     unset PATH            says nothing of a parameter; takes off what was put around a BSDF
///     revert PATH           a parameter is again what the scene's file says
///     undo
///     integrator [NAME]     none: the scene's own
///     orbit RIGHT UP        the camera, in degrees; as CameraControls has it, so are
///     look RIGHT UP
///     move RIGHT UP FORWARD
///     dolly FACTOR
///     home                  the camera goes back to where it was
///     lookat                prints where it is
///     pick X Y              prints what is seen there, in pixels of the film
///     render SAMPLES        as RenderSession::render()
///     wait                  until all of that is done
///     picture FILE          writes the picture, as write_picture()
///     save FILE             the scene as XML
///     parameters            prints their paths, types and plugins
///     samples               prints how many samples a pixel the picture has
///     sleep SECONDS         waits for so long
///     memory                prints how much memory is resident [bytes]
///
/// Errors go to stderr, with the line of the script that runs when they become known: "wait"
/// reports those of the commands before it. The script goes on with its next line. Returns the
/// number of errors.
int run_script(std::istream& script, const std::string& name, RenderSession& session);

/// The value of a parameter as a text says it. Throws Error.
EditedValue parse_value(const SceneParameter& parameter, const std::string& text);

}  // namespace kinome::viewer
