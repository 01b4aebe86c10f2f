// SPDX-License-Identifier: MIT
// Start here: this header includes the stable headers. They keep source compatibility within a
// minor version (0.2.x); CHANGELOG.md lists their changes. Other installed headers may change in
// any release. Link kibori::kibori, and also kibori::kibori_tools for scenes, files and pictures
// (find_package(kibori COMPONENTS tools)). docs/architecture.md is a map of the library.
//
//   Carve a model tick by tick:    make_lattice, TriDexel, DirectTool::advance, Snapshot, Surface
//   Smooth, inflate, flatten:      Reshaper::dab
//   Shape by splines:              apply_spline, spline_forces
//   Carve by hand, with forces:    SpringTool, Device, LiveCarving, ServoContext, DocumentWriter
//   Store, undo, replay:           Document
//   Scenes, files, pictures:       read_scene, carve, replay_document, into_dexels, write_model,
//                                  draw_picture
//
// Lengths are mm, angles rad, forces N, moments N mm. Functions that can fail return a Result or
// Status with one sentence for the user. Unless a header says otherwise, an object belongs to one
// thread at a time. Any thread may read a Snapshot.
#pragma once

#include <kibori/base/result.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/document/document.h>
#include <kibori/document/rescue.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/scan_convert.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/surface_file.h>
#include <kibori/geometry/lattice.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/mesh.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/device.h>
#include <kibori/haptics/materials.h>
#include <kibori/live/document_writer.h>
#include <kibori/live/live_carving.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/motion/stroke_player.h>
#include <kibori/motion/stroke_record.h>
#include <kibori/reshape/reshaper.h>
#include <kibori/reshape/warp.h>
#include <kibori/solid/tool.h>
#include <kibori/spline/apply_spline.h>
#include <kibori/spline/spline_force.h>
#include <kibori/surface/layers.h>
#include <kibori/surface/simplify.h>
#include <kibori/surface/surface.h>

// kibori::kibori_tools, if it is installed.
#if __has_include(<kibori/scene/scene.h>)
#include <kibori/measure/distance.h>
#include <kibori/picture/picture.h>
#include <kibori/report/convert.h>
#include <kibori/report/export.h>
#include <kibori/report/force_report.h>
#include <kibori/report/history.h>
#include <kibori/report/mesh_report.h>
#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/run/salvage.h>
#include <kibori/run/servo_run.h>
#include <kibori/scene/scene.h>
#include <kibori/scene/stock.h>
#endif
