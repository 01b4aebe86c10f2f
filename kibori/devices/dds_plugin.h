/* SPDX-License-Identifier: MIT
   The interface of kibori_dds.so: poses and wrenches over DDS, with the names and layout of ROS 2.
   The library is built where Fast DDS is installed. It is loaded only on request, so nothing else
   needs Fast DDS. Internal to kibori/devices. SI units: m, N, N m. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ns: the sender's time, since 1970. */
typedef void (*kibori_dds_on_pose)(void* user, int64_t ns, const double pose[7]);

struct kibori_dds {
  /* Joins a domain, and writes to these topics: `poses` of PoseStamped and `wrenches` of
     WrenchStamped, with ROS 2 names (/kibori/tool_pose). `reads` is null, or a topic of
     PoseStamped. on_pose gets each of its poses, on a thread of Fast DDS. Returns null on failure,
     with the reason in `error`. */
  void* (*open)(uint32_t domain, const char* const* poses, int pose_count,
                const char* const* wrenches, int wrench_count, const char* reads,
                kibori_dds_on_pose on_pose, void* user, char* error, int error_room);
  void (*close)(void* link);
  /* pose: x, y, z and a quaternion x, y, z, w. wrench: force and moment. ns: since 1970.
     Return 0 if nothing was sent. */
  int (*write_pose)(void* link, int topic, int64_t ns, const char* frame, const double pose[7]);
  int (*write_wrench)(void* link, int topic, int64_t ns, const char* frame, const double wrench[6]);
};

/* Name of the symbol that the library exports. A new layout of kibori_dds gets a new name. */
#define KIBORI_DDS_ENTRY "kibori_dds_1"

#ifdef __cplusplus
}
#endif
