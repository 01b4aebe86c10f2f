// SPDX-License-Identifier: MIT
// A fake of Force Dimension's library with its documented interface.
#include "tests/fake_dhd.h"

namespace {
FakeDhd fake;
}

extern "C" {
FakeDhd* fake_dhd() { return &fake; }

int dhdGetDeviceCount() { return fake.devices; }
int dhdOpenID(char) { return fake.open_result; }
int dhdClose(char) { return fake.closed++, 0; }
const char* dhdGetSystemName(char) { return "omega.6 (stand-in)"; }
int dhdGetPosition(double* x, double* y, double* z, char) {
  *x = fake.position[0], *y = fake.position[1], *z = fake.position[2];
  return fake.read_result;
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char) {
  *x = fake.velocity[0], *y = fake.velocity[1], *z = fake.velocity[2];
  return fake.velocity_result;
}
int dhdGetOrientationFrame(double m[3][3], char) {
  for (int i = 0; i < 9; i++) m[i / 3][i % 3] = fake.frame[i / 3][i % 3];
  return fake.frame_result;
}
unsigned dhdGetButtonMask(char) { return fake.buttons; }
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty,
                                        double tz, double, char) {
  fake.force[0] = fx, fake.force[1] = fy, fake.force[2] = fz;
  fake.torque[0] = tx, fake.torque[1] = ty, fake.torque[2] = tz;
  fake.writes++;
  return fake.write_result;
}
int dhdEnableForce(unsigned char on, char) { return fake.forces_on = on, fake.enable_result; }
int dhdSetWatchdog(unsigned char steps, char) { return fake.watchdog = steps, 0; }
double dhdGetMaxForce(char) { return fake.max_force; }
bool dhdHasWrist(char) { return fake.wrist; }
bool dhdHasActiveWrist(char) { return fake.active_wrist; }
const char* dhdErrorGetLastStr() { return "what the vendor says"; }
int dhdErrorGetLast() { return fake.error; }
}
