#include "support/stereo_visuals.h"

#include <GL/glx.h>
#include <dlfcn.h>
#include <vector>

namespace {

bool is_offered = false;

}  // namespace

/// Comes before that of libGLX, which it calls.
extern "C" __attribute__((visibility("default"))) GLXFBConfig* glXChooseFBConfig(Display* display,
                                                                                 int screen,
                                                                                 const int* wanted,
                                                                                 int* count) {
  using Function = GLXFBConfig* (*)(Display*, int, const int*, int*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "glXChooseFBConfig"));
  if (!is_offered || wanted == nullptr) return real(display, screen, wanted, count);
  std::vector<int> kept;
  for (; *wanted != None; wanted += 2) {
    if (*wanted != GLX_STEREO) kept.insert(kept.end(), wanted, wanted + 2);
  }
  kept.push_back(None);
  return real(display, screen, kept.data(), count);
}

namespace acus::testing_support {

OfferShutterStereo::OfferShutterStereo() {
  is_offered = true;
}
OfferShutterStereo::~OfferShutterStereo() {
  is_offered = false;
}

}  // namespace acus::testing_support
