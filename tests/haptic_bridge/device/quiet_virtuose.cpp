// A library in which every call succeeds and nothing allocates: what is counted then is the driver's own.
#include "haptic_bridge/device/virtuose/api.h"

using palp::VirtContext;

#define PALP_EXPORT extern "C" __attribute__((visibility("default")))
#define PALP_QUIET(name, symbol, ...) \
  PALP_EXPORT int symbol(VirtContext __VA_OPT__(, ) __VA_ARGS__) { return 0; }

// these have something to say
#define virtGetAvatarPosition quiet_avatar
#define virtGetDeadMan quiet_dead_man
#define virtGetPowerOn quiet_power
PALP_VIRTUOSE_CALLS(PALP_QUIET)
#undef virtGetAvatarPosition
#undef virtGetDeadMan
#undef virtGetPowerOn

PALP_EXPORT int virtGetAvatarPosition(VirtContext, float* pose) {
  pose[6] = 1;  // not turned
  return 0;
}
PALP_EXPORT int virtGetDeadMan(VirtContext, int* on) {
  *on = 1;
  return 0;
}
PALP_EXPORT int virtGetPowerOn(VirtContext, int* on) {
  *on = 1;
  return 0;
}
PALP_EXPORT int virtAPIVersion(int* major, int* minor) {
  *major = palp::kVirtuoseMajorVersion;
  *minor = 0;
  return 0;
}
PALP_EXPORT VirtContext virtOpen(const char*) {
  static int arm = 0;
  return &arm;
}
PALP_EXPORT int virtGetErrorCode(VirtContext) { return 0; }
PALP_EXPORT char* virtGetErrorMessage(int) {
  static char text[] = "none";
  return text;
}
