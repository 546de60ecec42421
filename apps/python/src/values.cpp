#include "values.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "kinome/image.h"

namespace kinome::python {
namespace {

using FloatArray = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;
using IndexArray = nb::ndarray<const uint32_t, nb::c_contig, nb::device::cpu>;

std::shared_ptr<const Image> to_image(nb::handle value, const Location& where) {
  const auto pixels = nb::cast<FloatArray>(value);
  const size_t channels = pixels.ndim() == 3 ? pixels.shape(2) : 0;
  if ((channels != 1 && channels < 3) || pixels.size() == 0) {
    throw Error(where,
                "an array of pixels must have the shape (height, width, channels), with one "
                "channel or three");
  }
  auto image = std::make_shared<Image>();
  image->height = static_cast<int>(pixels.shape(0));
  image->width = static_cast<int>(pixels.shape(1));
  const size_t used = channels == 1 ? 1 : 3;
  image->channels =
      used == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  image->data.resize(pixels.shape(0) * pixels.shape(1) * used);
  for (size_t i = 0; i < image->data.size(); ++i) {
    image->data[i] = pixels.data()[i / used * channels + i % used];
  }
  return image;
}

/// Converts a grid of the shape (slices x height, width, channels), as for `data` of gridvolume.
std::shared_ptr<const Image> to_grid(nb::handle value) {
  const auto values = nb::cast<FloatArray>(value);
  auto image = std::make_shared<Image>();
  image->height = static_cast<int>(values.shape(0));
  image->width = static_cast<int>(values.shape(1));
  for (size_t c = 0; c < values.shape(2); ++c) image->channels.push_back(std::to_string(c));
  image->data.assign(values.data(), values.data() + values.size());
  return image;
}

Location location(nb::handle where) {
  return Location{nb::cast<std::string>(where), 0, 0};
}

Vec3 to_vector(nb::handle value) {
  const auto numbers = nb::cast<std::vector<double>>(value);
  return {static_cast<float>(numbers.at(0)), static_cast<float>(numbers.at(1)),
          static_cast<float>(numbers.at(2))};
}

struct Maker {
  template <class T>
  nb::object operator()(const T& value) const {
    return nb::cast(value);
  }
  // SceneEditor::get() never returns these, because they are not values.
  nb::object operator()(const ObjectDescription&) const { return nb::none(); }
  nb::object operator()(const Unset&) const { return nb::none(); }
  nb::object operator()(const AsWritten&) const { return nb::none(); }
  nb::object operator()(const Placed&) const { return nb::none(); }
  nb::object operator()(const Vec3& v) const {
    return nb::make_tuple("vector", std::vector<float>{v.x, v.y, v.z});
  }
  nb::object operator()(const UniformColor& c) const {
    if (c.is_float) return nb::cast(c.value.x);
    return nb::make_tuple("rgb", std::vector<float>{c.value.x, c.value.y, c.value.z});
  }
  nb::object operator()(const Transform& transform) const {
    std::vector<float> rows;
    for (int i = 0; i < 16; ++i) rows.push_back(transform.matrix()[i % 4][i / 4]);
    return nb::make_tuple("transform", rows);
  }
  nb::object operator()(const std::shared_ptr<const Image>& image) const {
    return nb::make_tuple("image", picture_array(Image(*image)));
  }
  nb::object operator()(const std::vector<float>& values) const {
    return nb::make_tuple("floats", array_of(values));
  }
  nb::object operator()(const std::vector<uint32_t>& values) const {
    return nb::make_tuple("indices", array_of(values));
  }
};

Properties::Value to_property(nb::handle value, const Location& where) {
  return std::visit(
      [&](auto&& edited) -> Properties::Value {
        if constexpr (std::is_constructible_v<Properties::Value, decltype(edited)>) {
          return edited;
        } else {
          throw Error(where, "a parameter's value can't be an array");
        }
      },
      to_value(value, where));
}

}  // namespace

EditedValue to_value(nb::handle value, const Location& where) {
  if (nb::isinstance<nb::bool_>(value)) return nb::cast<bool>(value);
  if (nb::isinstance<nb::int_>(value)) return nb::cast<int64_t>(value);
  if (nb::isinstance<nb::float_>(value)) return nb::cast<double>(value);
  if (nb::isinstance<nb::str>(value)) return nb::cast<std::string>(value);
  const auto pair = nb::cast<nb::tuple>(value);
  const auto kind = nb::cast<std::string>(pair[0]);
  const nb::handle what = pair[1];
  if (kind == "rgb") return UniformColor{to_vector(what), false, false};
  if (kind == "vector") return to_vector(what);
  if (kind == "image") return to_image(what, where);
  if (kind == "grid") return to_grid(what);
  if (kind == "transform") {
    const auto rows = nb::cast<std::vector<double>>(what);
    Mat4 m;
    for (int i = 0; i < 16; ++i)
      m[i % 4][i / 4] = static_cast<float>(rows.at(static_cast<size_t>(i)));
    const Transform transform(m);
    if (!transform.is_invertible()) throw Error(where, "this transform can't be inverted");
    return transform;
  }
  if (kind == "floats") {
    const auto array = nb::cast<FloatArray>(what);
    return std::vector<float>(array.data(), array.data() + array.size());
  }
  if (kind == "object") return to_description(what);
  if (kind == "unset") return Unset();
  const auto array = nb::cast<IndexArray>(what);
  return std::vector<uint32_t>(array.data(), array.data() + array.size());
}

nb::object from_value(const std::optional<EditedValue>& value) {
  return value ? std::visit(Maker{}, *value) : nb::object(nb::none());
}

ObjectDescription to_description(nb::handle description) {
  const auto parts = nb::cast<nb::tuple>(description);
  ObjectDescription object;
  object.tag = nb::cast<std::string>(parts[0]);
  object.type = nb::cast<std::string>(parts[1]);
  object.name = nb::cast<std::string>(parts[2]);
  object.id = nb::cast<std::string>(parts[3]);
  object.where = location(parts[4]);
  for (const nb::handle value : nb::cast<nb::list>(parts[5])) {
    const auto entry = nb::cast<nb::tuple>(value);
    const Location where = location(entry[2]);
    object.values.push_back({nb::cast<std::string>(entry[0]), to_property(entry[1], where), where});
  }
  for (const nb::handle part : nb::cast<nb::list>(parts[6])) {
    object.parts.push_back(to_description(part));
  }
  return object;
}

nb::object picture_array(Image&& image) {
  auto* const kept = new Image(std::move(image));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<Image*>(p); });
  const size_t shape[] = {static_cast<size_t>(kept->height), static_cast<size_t>(kept->width),
                          kept->channels.size()};
  return nb::cast(nb::ndarray<nb::numpy, float>(kept->data.data(), 3, shape, owner));
}

}  // namespace kinome::python
