/* SPDX-License-Identifier: MIT
   What kibori_dds.so gives: poses and wrenches over DDS, named and laid out as ROS 2 does. It is
   built where Fast DDS is installed, and opened only when asked for, so that nothing else needs
   Fast DDS. Internal to kibori/devices. SI units: m, N, N m. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ns: when it was so, as its sender says, since 1970. */
typedef void (*kibori_dds_on_pose)(void* user, int64_t ns, const double pose[7]);

struct kibori_dds {
  /* Joins a domain, and writes to these topics: `poses` of PoseStamped and `wrenches` of
     WrenchStamped, by the names that ROS 2 gives them (/kibori/tool_pose). `reads`: null, or a
     topic of PoseStamped of which on_pose gets each, on a thread of Fast DDS. Null: it can't be,
     and why is in `error`. */
  void* (*open)(uint32_t domain, const char* const* poses, int pose_count,
                const char* const* wrenches, int wrench_count, const char* reads,
                kibori_dds_on_pose on_pose, void* user, char* error, int error_room);
  void (*close)(void* link);
  /* x, y, z and a quaternion x, y, z, w; force and moment. ns: since 1970. 0: it did not go out. */
  int (*write_pose)(void* link, int topic, int64_t ns, const char* frame, const double pose[7]);
  int (*write_wrench)(void* link, int topic, int64_t ns, const char* frame, const double wrench[6]);
};

/* Under this name in the shared library; another layout gets another one. */
#define KIBORI_DDS_ENTRY "kibori_dds_1"

#ifdef __cplusplus
}
#endif
