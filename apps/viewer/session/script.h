#pragma once

#include <istream>
#include <string>

#include "session/render_session.h"

namespace kinome::viewer {

/// Runs a script, which controls a session like a user at the window, and prints the results. Each
/// line has one command:
///
///     set PATH VALUE        sets a parameter, written as in XML; a transform by 16 numbers
///     texture PATH FILE     sets a parameter to a bitmap, or to "checkerboard"
///     normalmap PATH FILE   wraps a BSDF in a normal map with this bitmap
///     bumpmap PATH FILE     wraps a BSDF in a bump map with this bitmap
///     unset PATH            removes a parameter, so that its default applies, or the map around a
///                           BSDF
///     revert PATH           restores the value of the scene file
///     undo                  undoes the last change
///     integrator [NAME]     selects an integrator; by default the scene's own
///     orbit RIGHT UP        moves the camera around its target, by angles in degrees
///     look RIGHT UP         turns the camera in place, by angles in degrees
///     move RIGHT UP FORWARD moves the camera
///     dolly FACTOR          multiplies the distance to the target
///     home                  resets the camera
///     lookat                prints the camera's position as <lookat>
///     pick X Y              prints the surface at this pixel of the film
///     region X Y WIDTH HEIGHT  renders only this region on: RenderSession::set_region()
///     region                renders the whole image on
///     render SAMPLES        calls RenderSession::render()
///     wait                  waits until all earlier commands are done
///     picture FILE          writes the image, by write_picture()
///     save FILE             saves the scene as XML
///     parameters            prints the parameters' paths, types and plugins
///     samples [COUNT]       prints the image's number of samples per pixel; before, waits until it
///                           is at least COUNT
///     sleep SECONDS         waits for this time
///     memory                prints the resident memory [bytes]
///
/// Errors go to stderr, with the line that is running when they are reported; "wait" reports the
/// errors of the commands before it. The script continues after an error. Returns the number of
/// errors.
int run_script(std::istream& script, const std::string& name, RenderSession& session);

/// Parses the value of a parameter. Throws Error.
EditedValue parse_value(const SceneParameter& parameter, const std::string& text);

}  // namespace kinome::viewer
