#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/image.h"

/// Mattes of objects and materials: for each pixel, the ids of the largest parts and the fractions
/// of the pixel that they cover. Format: Friedman and Jones, "Cryptomatte specification" version
/// 1.2.0, https://github.com/Psyop/Cryptomatte.
namespace kinome {

class Scene;

/// Subject of the ids.
enum class CryptomatteKind { kObject, kMaterial };
inline constexpr std::array kCryptomatteKinds{CryptomatteKind::kObject, CryptomatteKind::kMaterial};
/// Returns the name of the image layer, "CryptoObject" or "CryptoMaterial", with which all of its
/// channels begin.
KINOME_EXPORT std::string cryptomatte_layer(CryptomatteKind kind);
/// Returns the names of the channels for this number of ids per pixel: CryptoObject00.R is the
/// first id, .G its coverage, .B the second id, .A its coverage, and so on. An odd `levels` is
/// rounded up.
KINOME_EXPORT std::vector<std::string> cryptomatte_channels(CryptomatteKind kind, int levels);

/// Returns the hash of a name: MurmurHash3_x86_32 of its UTF-8 bytes with seed 0.
KINOME_EXPORT uint32_t cryptomatte_hash(std::string_view name);
/// Returns the float with the bits of a hash. One bit is flipped if it would be 0, denormal,
/// infinite or NaN.
KINOME_EXPORT float cryptomatte_id(uint32_t hash);

/// Returns the name of each shape of the scene, or of its material, by the index of the shape: the
/// `id` in the scene file. Objects without one are "shape N", counted from 1; materials without one
/// have the name of their object.
KINOME_EXPORT std::vector<std::string> cryptomatte_names(const Scene& scene, CryptomatteKind kind);

/// Returns the attributes of an image's header that describe the layers among its `channels`,
/// with manifests of the scene's names. Returns none if there are no such layers.
KINOME_EXPORT ImageMetadata cryptomatte_metadata(const Scene& scene,
                                                 const std::vector<std::string>& channels);

}  // namespace kinome
