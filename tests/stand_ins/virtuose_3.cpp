// Stand-in for version 3 of VirtuoseAPI, whose functions go through one.
#include "simulated_arm.h"

ACUS_EXPORT int virtCallDLL(int, ...) {
  return -1;
}
