/* SPDX-License-Identifier: MIT
   Another vendor's DDS (Eclipse Cyclone) beside kibori, with ROS 2's types by its own compiler of IDL: a hand that goes
   around, 1000 poses a second on /kibori/device/pose, and ears on all that kibori writes. Every message is printed as a
   line of CSV: topic, stamp [s], frame, numbers.

   peer DOMAIN SECONDS [RADIUS_MM [HEIGHT_MM]]    hand: an upright circle, its middle so high above the device's own
                                                   centre; it begins at the top
   peer DOMAIN SECONDS quiet                       no hand, and only how many came of each topic */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <dds/dds.h>

#include "geometry_msgs.h"

#define TAKEN 256

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static dds_entity_t made(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "peer: no %s: %s\n", what, dds_strretcode(-entity));
  exit(1);
}

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const int quiet = argc > 3 && strcmp(argv[3], "quiet") == 0;
  const double seconds = atof(argv[2]), radius = argc > 3 && !quiet ? atof(argv[3]) / 1000 : 0.02,
               height = argc > 4 ? atof(argv[4]) / 1000 : 0;
  const dds_entity_t part = made(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  const char* const pose_names[] = {"rt/kibori/tool_pose", "rt/kibori/hand_pose"};
  const char* const wrench_names[] = {"rt/kibori/wrench", "rt/kibori/given_wrench", "rt/kibori/device/wrench"};
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1000);
  dds_entity_t poses[2], wrenches[3];
  for (int i = 0; i < 2; i++)
    poses[i] = made(dds_create_reader(part, made(dds_create_topic(part, &geometry_msgs_msg_dds__PoseStamped__desc,
                                                                  pose_names[i], NULL, NULL), "topic"), qos, NULL), "reader");
  for (int i = 0; i < 3; i++)
    wrenches[i] = made(dds_create_reader(part, made(dds_create_topic(part, &geometry_msgs_msg_dds__WrenchStamped__desc,
                                                                     wrench_names[i], NULL, NULL), "topic"), qos, NULL), "reader");
  dds_entity_t hand = 0;
  if (!quiet)
    hand = made(dds_create_writer(part, made(dds_create_topic(part, &geometry_msgs_msg_dds__PoseStamped__desc,
                                                              "rt/kibori/device/pose", NULL, NULL), "topic"), qos, NULL), "writer");
  long came[5] = {0};
  const double begun = now();
  struct timespec realtime;
  clock_gettime(CLOCK_REALTIME, &realtime);
  const double wall = (double)realtime.tv_sec + 1e-9 * (double)realtime.tv_nsec - begun;
  double due = begun;
  while (now() - begun < seconds) {
    if (!quiet) {
      const double angle = 2 * M_PI * (due - begun) / 4; /* once around in 4 s */
      const double at = wall + due;
      geometry_msgs_msg_dds__PoseStamped_ pose = {0};
      pose.header.stamp.sec = (int32_t)at;
      pose.header.stamp.nanosec = (uint32_t)(1e9 * (at - floor(at)));
      pose.header.frame_id = (char*)"hand";
      pose.pose.position.x = radius * sin(angle);
      pose.pose.position.y = 0.001;
      pose.pose.position.z = height + radius * cos(angle);
      pose.pose.orientation.z = sin(angle / 20);
      pose.pose.orientation.w = cos(angle / 20);
      dds_write(hand, &pose);
      printf("sent,0,hand,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", pose.pose.position.x, pose.pose.position.y,
             pose.pose.position.z, 0.0, 0.0, pose.pose.orientation.z, pose.pose.orientation.w);
    }
    for (int i = 0; i < 2; i++) {
      void* samples[TAKEN] = {NULL};
      dds_sample_info_t infos[TAKEN];
      const int count = dds_take(poses[i], samples, infos, TAKEN, TAKEN);
      for (int k = 0; k < count; k++) {
        if (!infos[k].valid_data) continue;
        came[i]++;
        const geometry_msgs_msg_dds__PoseStamped_* const p = samples[k];
        if (!quiet)
          printf("%s,%.9f,%s,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", pose_names[i],
                 p->header.stamp.sec + 1e-9 * p->header.stamp.nanosec, p->header.frame_id, p->pose.position.x,
                 p->pose.position.y, p->pose.position.z, p->pose.orientation.x, p->pose.orientation.y,
                 p->pose.orientation.z, p->pose.orientation.w);
      }
      if (count > 0) dds_return_loan(poses[i], samples, count);
    }
    for (int i = 0; i < 3; i++) {
      void* samples[TAKEN] = {NULL};
      dds_sample_info_t infos[TAKEN];
      const int count = dds_take(wrenches[i], samples, infos, TAKEN, TAKEN);
      for (int k = 0; k < count; k++) {
        if (!infos[k].valid_data) continue;
        came[2 + i]++;
        const geometry_msgs_msg_dds__WrenchStamped_* const w = samples[k];
        if (!quiet)
          printf("%s,%.9f,%s,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", wrench_names[i],
                 w->header.stamp.sec + 1e-9 * w->header.stamp.nanosec, w->header.frame_id, w->wrench.force.x,
                 w->wrench.force.y, w->wrench.force.z, w->wrench.torque.x, w->wrench.torque.y, w->wrench.torque.z);
      }
      if (count > 0) dds_return_loan(wrenches[i], samples, count);
    }
    due += 0.001;
    const double wait = due - now();
    if (wait > 0) {
      const struct timespec t = {0, (long)(1e9 * wait)};
      nanosleep(&t, NULL);
    }
  }
  if (quiet)
    printf("%ld %ld %ld %ld %ld\n", came[0], came[1], came[2], came[3], came[4]);
  dds_delete(part);
  return 0;
}
