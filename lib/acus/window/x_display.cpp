#include "acus/window/x_display.h"

#include <X11/XKBlib.h>
#include <X11/Xlib.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "acus/base/core/error.h"

namespace acus::window {
namespace {

/// A server restarts after its last client has left, and accepts no connection meanwhile.
Display* Connect() {
  constexpr int kTries = 4;
  for (int i = 0; i < kTries; ++i) {
    if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(150));
    if (Display* display = XOpenDisplay(nullptr)) return display;
  }
  return nullptr;
}

}  // namespace

// VTK ends the program if there is no X server: so this is checked before.
XConnection::XConnection() {
  constexpr const char* kRemedy =
      " Start the program from the desktop, or with a display of its own by xvfb-run, or without "
      "windows by --headless.";
  const char* name = std::getenv("DISPLAY");
  ACUS_REQUIRE(name != nullptr && *name != '\0',
               "display: there is no screen to open a window on: DISPLAY is not set.", kRemedy);
  Display* display = Connect();
  ACUS_REQUIRE(display != nullptr, "display: there is no screen to open a window on: the X server ",
               name, " (DISPLAY) does not answer or does not let us in.", kRemedy);
  XkbSetDetectableAutoRepeat(display, True, nullptr);
  display_ = display;
}

XConnection::~XConnection() {
  XCloseDisplay(static_cast<Display*>(display_));
}

bool XConnection::HasHeldKeys(unsigned long window) const {
  auto* display = static_cast<Display*>(display_);
  Window focus = 0;
  int revert_to = 0;
  XGetInputFocus(display, &focus, &revert_to);
  if (focus != window && focus != PointerRoot) return false;
  std::array<char, 32> keys{};
  XQueryKeymap(display, keys.data());
  return std::ranges::any_of(keys, [](char bits) { return bits != 0; });
}

void CheckDisplay() {
  const XConnection connection;
}

}  // namespace acus::window
