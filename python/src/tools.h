// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include <kibori/geometry/mesh.h>
#include <kibori/solid/tool.h>

#include "python/src/conversions.h"

namespace kibori::python {

using Indices = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;

// Errors: other shapes, non-finite numbers, triangles with missing vertices.
TriangleMesh mesh_of(const Doubles& vertices, const py::object& triangles);

void bind_tools(py::module_& module);

}  // namespace kibori::python
