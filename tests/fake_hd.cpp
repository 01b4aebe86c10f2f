// SPDX-License-Identifier: MIT
// A fake of OpenHaptics' libHD with its documented interface: a scheduler thread at about 1 kHz.
#include "tests/fake_hd.h"

#include <chrono>
#include <thread>

namespace {
FakeHd fake;
unsigned (*callback)(void*) = nullptr;
void* context = nullptr;
std::thread scheduler;
std::atomic<bool> stopping{false};
struct Error {
  unsigned code;
  int internal;
  unsigned device;
};
thread_local unsigned raised = 0;  // as in the real library: one stack of errors per thread
}  // namespace

extern "C" {
FakeHd* fake_hd() { return &fake; }

unsigned hdInitDevice(const char*) {
  raised = fake.init_error;
  return raised ? 0xffffffffu : 1;
}
void hdDisableDevice(unsigned) { fake.disabled++; }
void hdEnable(unsigned what) { fake.output = what == 0x4000; }
unsigned long hdScheduleAsynchronous(unsigned (*call)(void*), void* data, unsigned short) {
  callback = call;
  context = data;
  return 1;
}
void hdUnschedule(unsigned long) { fake.unscheduled++; }
void hdStartScheduler() {
  stopping = false;
  scheduler = std::thread([] {
    while (!stopping) {
      if (fake.error) raised = fake.error;
      callback(context);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  });
}
void hdStopScheduler() {
  stopping = true;
  if (scheduler.joinable()) scheduler.join();
}
void hdBeginFrame(unsigned) {}
void hdEndFrame(unsigned) { fake.frames++; }
void hdGetDoublev(unsigned what, double* v) {
  if (what == 0x2603) *v = fake.max_force;
  if (what == 0x2050) v[0] = fake.x, v[1] = 20, v[2] = -30;  // 20 up, 30 away
  if (what == 0x2051) v[0] = 100, v[1] = v[2] = 0;
  if (what == 0x2052)
    for (int i = 0; i < 16; i++) v[i] = i % 5 == 0;
  // A matrix by columns: a quarter turn about y, which points up. x becomes -z, and z becomes x.
  if (what == 0x2052) v[0] = 0, v[2] = -1, v[8] = 1, v[10] = 0;
}
void hdGetIntegerv(unsigned what, int* v) {
  if (what == 0x2000) *v = fake.buttons;
}
void hdSetDoublev(unsigned what, const double* v) {
  if (what != 0x2700) return;
  fake.force_y = v[1];
  fake.force_z = v[2];
}
Error hdGetError() {
  const Error error{raised, 0, 1};
  raised = 0;
  return error;
}
const char* hdGetErrorString(unsigned) { return "what the vendor says"; }
}
