#include "kinome/cryptomatte.h"

#include <algorithm>
#include <bit>
#include <map>

#include <fmt/format.h>

#include "kinome/scene.h"

namespace kinome {
namespace {

constexpr const char* kLayers[] = {"CryptoObject", "CryptoMaterial"};  // by CryptomatteKind

/// Returns `text` as a JSON string.
std::string json_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

/// Returns the names with their ids as a JSON object, each name once, in alphabetical order.
std::string manifest_of(const std::vector<std::string>& names) {
  std::map<std::string, uint32_t> ids;
  for (const std::string& name : names) {
    ids[name] = std::bit_cast<uint32_t>(cryptomatte_id(cryptomatte_hash(name)));
  }
  std::string text;
  for (const auto& [name, id] : ids) {
    text += fmt::format("{}{}:\"{:08x}\"", text.empty() ? "" : ",", json_string(name), id);
  }
  return "{" + text + "}";
}

}  // namespace

std::string cryptomatte_layer(CryptomatteKind kind) {
  return kLayers[static_cast<int>(kind)];
}

std::vector<std::string> cryptomatte_channels(CryptomatteKind kind, int levels) {
  std::vector<std::string> names;
  for (int pair = 0; 2 * pair < levels; ++pair) {
    for (const char suffix : {'R', 'G', 'B', 'A'}) {
      names.push_back(fmt::format("{}{:02}.{}", cryptomatte_layer(kind), pair, suffix));
    }
  }
  return names;
}

uint32_t cryptomatte_hash(std::string_view name) {
  constexpr uint32_t kFirst = 0xcc9e2d51, kSecond = 0x1b873593;
  uint32_t hash = 0;
  const auto mixed = [](uint32_t word) { return std::rotl(word * kFirst, 15) * kSecond; };
  const auto word_at = [name](size_t at, size_t bytes) {  // little-endian
    uint32_t word = 0;
    for (size_t i = 0; i < bytes; ++i) {
      word |= static_cast<uint32_t>(static_cast<unsigned char>(name[at + i])) << (8 * i);
    }
    return word;
  };
  size_t at = 0;
  for (; at + 4 <= name.size(); at += 4) {
    hash = std::rotl(hash ^ mixed(word_at(at, 4)), 13) * 5 + 0xe6546b64;
  }
  if (at < name.size()) hash ^= mixed(word_at(at, name.size() - at));
  hash ^= static_cast<uint32_t>(name.size());
  hash = (hash ^ (hash >> 16)) * 0x85ebca6b;
  hash = (hash ^ (hash >> 13)) * 0xc2b2ae35;
  return hash ^ (hash >> 16);
}

float cryptomatte_id(uint32_t hash) {
  const uint32_t exponent = hash >> 23 & 255;
  return std::bit_cast<float>(exponent == 0 || exponent == 255 ? hash ^ (1u << 23) : hash);
}

std::vector<std::string> cryptomatte_names(const Scene& scene, CryptomatteKind kind) {
  std::vector<std::string> names;
  for (const auto& shape : scene.shapes()) {
    std::string name = shape->id();
    if (name.empty()) name = fmt::format("shape {}", names.size() + 1);
    const bool is_named = kind == CryptomatteKind::kMaterial && !shape->bsdf().id().empty();
    names.push_back(is_named ? shape->bsdf().id() : name);
  }
  return names;
}

ImageMetadata cryptomatte_metadata(const Scene& scene, const std::vector<std::string>& channels) {
  ImageMetadata metadata;
  for (const CryptomatteKind kind : kCryptomatteKinds) {
    const std::string layer = cryptomatte_layer(kind);
    if (std::find(channels.begin(), channels.end(), layer + "00.R") == channels.end()) continue;
    const std::string key =
        "cryptomatte/" + fmt::format("{:08x}", cryptomatte_hash(layer)).substr(0, 7) + "/";
    metadata[key + "name"] = layer;
    metadata[key + "hash"] = "MurmurHash3_32";
    metadata[key + "conversion"] = "uint32_to_float32";
    metadata[key + "manifest"] = manifest_of(cryptomatte_names(scene, kind));
  }
  return metadata;
}

}  // namespace kinome
