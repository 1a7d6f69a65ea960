#include "support/window_events.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace acus::testing_support {
namespace {

Window Find(Display* display, Window from, const std::string& title) {
  char* name = nullptr;
  if (XFetchName(display, from, &name) != 0 && name != nullptr) {
    const bool found = title == name;
    XFree(name);
    if (found) return from;
  }
  Window root = 0;
  Window parent = 0;
  Window* children = nullptr;
  unsigned count = 0;
  if (XQueryTree(display, from, &root, &parent, &children, &count) == 0) return 0;
  Window found = 0;
  for (unsigned i = 0; i < count && found == 0; ++i) found = Find(display, children[i], title);
  if (children != nullptr) XFree(children);
  return found;
}

template <typename Action>
bool WithWindow(const std::string& title, const Action& action) {
  Display* display = XOpenDisplay(nullptr);
  if (display == nullptr) return false;
  const Window window = Find(display, DefaultRootWindow(display), title);
  if (window != 0) action(display, window);
  XSync(display, False);
  XCloseDisplay(display);
  return window != 0;
}

}  // namespace

bool AskToClose(const std::string& title) {
  return WithWindow(title, [](Display* display, Window window) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = window;
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
    XSendEvent(display, window, False, NoEventMask, &event);
  });
}

bool ResizeWindow(const std::string& title, int width_px, int height_px) {
  return WithWindow(title, [&](Display* display, Window window) {
    XResizeWindow(display, window, static_cast<unsigned>(width_px),
                  static_cast<unsigned>(height_px));
  });
}

}  // namespace acus::testing_support
