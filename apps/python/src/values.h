#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "kinome/scene_editor.h"

namespace kinome::python {

namespace nb = nanobind;

/// From what kinome/_values.py makes of a Python value: bool, int, float, str, or a pair of a word
/// and what it is: ("rgb", [r, g, b]), ("vector", [x, y, z]), ("transform", 16 numbers by rows),
/// ("image", float32 array (height, width, channels)), ("floats", float32 array), ("indices",
/// uint32 array), ("object", as to_description() takes it).
EditedValue to_value(nb::handle value, const Location& where);
/// The other way round.
nb::object from_value(const EditedValue& value);

/// From what kinome/_describe.py makes of a dict: (tag, type, name, id, where, [(name, value,
/// where), …], [part, …]).
ObjectDescription to_description(nb::handle said);

/// An array over a picture's own memory, which lives as long as the array does.
nb::object picture_array(Image&& image);

}  // namespace kinome::python
