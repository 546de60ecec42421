#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <optional>
#include <vector>

#include "kinome/scene_editor.h"

namespace kinome::python {

namespace nb = nanobind;

/// Converts a value in the form that kinome/_values.py produces: bool, int, float, str, or a pair
/// of a type and a value: ("rgb", [r, g, b]), ("vector", [x, y, z]), ("transform", 16 numbers by
/// rows), ("image", float32 array (height, width, channels)), ("grid", float32 array (slices x
/// height, width, channels)), ("floats", float32 array), ("indices", uint32 array), ("object",
/// argument of to_description()), ("unset", None).
EditedValue to_value(nb::handle value, const Location& where);
/// Converts a value to the form that to_value() takes; nullopt to None.
nb::object from_value(const std::optional<EditedValue>& value);

/// Converts a description in the form that kinome/_describe.py produces: (tag, type, name, id,
/// where, [(name, value, where), …], [part, …]).
ObjectDescription to_description(nb::handle description);

/// Returns a flat array that owns the values.
template <class T>
nb::object array_of(std::vector<T> values) {
  auto* const kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), {kept->size()}, owner));
}

/// Returns an array that owns the image and shares its memory.
nb::object picture_array(Image&& image);

}  // namespace kinome::python
