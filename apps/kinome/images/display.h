#pragma once

#include <memory>
#include <string>
#include <thread>

#include "kinome/film.h"
#include "kinome/image.h"

namespace kinome::app {

/// Shows an image during the render in the viewer tev, or another one with its network protocol.
///
/// A separate thread sends copies of the pixels, so that the render never waits for the network. If
/// pixels change faster than they can be sent, only their last values are sent. If the viewer is
/// missing or disconnects, the thread logs one warning and ends.
///
/// Thread-safe, except finish().
class Display {
 public:
  /// Starts to connect to `address`, HOST:PORT; throws Error if it is invalid. `name` is the
  /// image's name in the viewer.
  Display(const std::string& address, const std::string& name);
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// Shows some pixels of the film, as a CommitCallback. Integrators with splats commit the whole
  /// film each time; such commits are shown at most every half second.
  void show(const Film& film, const Rect& pixels);
  /// Shows the whole image, with all its channels.
  void show(const Image& image);
  /// Waits until all pixels are sent, but no longer than two seconds without progress. Nothing can
  /// be shown afterwards.
  void finish();

 private:
  class Sender;
  std::shared_ptr<Sender> sender_;
  std::thread thread_;
};

/// Splits "HOST:PORT", where HOST may be an IPv6 address in brackets. Throws an Error that begins
/// with "--display" if the address is invalid.
std::pair<std::string, std::string> split_address(const std::string& address);

}  // namespace kinome::app
