#pragma once

#include <memory>
#include <string>
#include <thread>

#include "kinome/film.h"
#include "kinome/image.h"

namespace kinome::app {

/// Shows a picture in the making in tev, or whatever else speaks its protocol, over the network.
///
/// What is shown is copied, and sent by a thread of its own, so that no one waits for the network:
/// of pixels that change faster than they can be sent, the last ones are. A display that isn't
/// there, or that goes away, is a single warning, and nothing is sent any more.
///
/// Thread-safe, but for finish().
class Display {
 public:
  /// Begins to connect. `address`: HOST:PORT; throws Error where it is none. `name`: the picture's,
  /// there.
  Display(const std::string& address, const std::string& name);
  /// As finish().
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// For CommitCallback: what the film holds of these pixels. Whole pictures come with each splat:
  /// only some of them, by time, are shown.
  void show(const Film& film, const Rect& pixels);
  /// All of the picture, with all of its channels.
  void show(const Image& picture);
  /// Waits until all is sent; where the display takes nothing for two seconds, not any longer.
  /// Nothing is shown after that.
  void finish();

 private:
  class Sender;
  std::shared_ptr<Sender> sender_;
  std::thread thread_;
};

/// HOST and PORT of "HOST:PORT", where HOST may be an address of IPv6 in brackets. Error, which
/// begins with "--display", where it is none.
std::pair<std::string, std::string> split_address(const std::string& address);

}  // namespace kinome::app
