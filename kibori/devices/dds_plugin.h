/* SPDX-License-Identifier: MIT
   The interface of kibori_dds.so, which sends and receives poses and wrenches over DDS. The names
   and the layout of messages are those of ROS 2. The library is built only where Fast DDS is
   installed. It is loaded only on request. So no other part of Kibori needs Fast DDS. SI units: m,
   N, N m. Internal to kibori/devices. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ns: the sender's time since 1970. pose: as in write_pose. */
typedef void (*kibori_dds_on_pose)(void* user, int64_t ns, const double pose[7]);

struct kibori_dds {
  /* Joins a domain and creates writers. `poses`: topic names for PoseStamped messages. `wrenches`:
     topic names for WrenchStamped messages. `reads`: a topic name for PoseStamped messages to
     receive, or null. Names are those of ROS 2 (/kibori/tool_pose). on_pose is called for new
     poses, on a thread of Fast DDS. If several poses are waiting, it is called only for the newest.
     Returns the link for the other functions. On failure, returns null and writes the reason to
     `error`, which has room for `error_room` characters. */
  void* (*open)(uint32_t domain, const char* const* poses, int pose_count,
                const char* const* wrenches, int wrench_count, const char* reads,
                kibori_dds_on_pose on_pose, void* user, char* error, int error_room);
  void (*close)(void* link);
  /* Send a message. topic: an index of `poses` or `wrenches`. ns: the time since 1970. frame: the
     name of the coordinate frame. pose: x, y, z, then a quaternion x, y, z, w. wrench: force, then
     moment. Return 0 if nothing was sent. */
  int (*write_pose)(void* link, int topic, int64_t ns, const char* frame, const double pose[7]);
  int (*write_wrench)(void* link, int topic, int64_t ns, const char* frame, const double wrench[6]);
};

/* Name of the kibori_dds that the library exports. It changes with the layout of kibori_dds. */
#define KIBORI_DDS_ENTRY "kibori_dds_1"

#ifdef __cplusplus
}
#endif
