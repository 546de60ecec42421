#include "kinome/checkpoint.h"

#include <stdexcept>

#include "base/fnv1a.h"
#include "fuzz.h"
#include "kinome/film.h"
#include "kinome/render_context.h"

/// A checkpoint without its checksum, which is added: the data behind it can't be trusted, either.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace kinome;
  static const fuzz::InputFile file(".checkpoint");
  static const auto film = std::dynamic_pointer_cast<Film>(load_object_from_string(
      "<film type='hdrfilm'><integer name='width' value='3'/><integer name='height' value='2'/>"
      "<rfilter type='box'/></film>",
      "fuzz.xml", {}, fuzz::registry()));
  Fnv1a hash;
  hash.add(data, size);
  const uint64_t value = hash.value();
  std::string bytes(reinterpret_cast<const char*>(data), size);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  const std::string& path = file.write(bytes.data(), bytes.size());
  try {
    film->prepare({{}});
    Checkpoint checkpoint({.path = path, .every = 1e9, .resume = true});
    checkpoint.set_identity({{"seed", "7"}});
    checkpoint.begin(*film);
    // Resume a render from the checkpoint.
    RenderContext context({.threads = 1});
    context.job.set_work_source(&checkpoint);
    for (int pass = 0; pass < 2; ++pass) {
      context.scheduler.for_each_tile(*film, [](Tile& tile) {
        tile.film.add_pixel(0, 0, std::array{1.f, 1.f, 1.f});
      });
      context.job.decide([] { return 1.; });
    }
    film->develop();
  } catch (const Error& error) {
    fuzz::refusal = error.what();
  }
  return 0;
}
