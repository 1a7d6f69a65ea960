// The connection to the X server.
#pragma once

namespace acus::window {

/// @throws InputError if there is no display to open a window on, with the remedy.
void CheckDisplay();

/// Held keys send one release at the end, not one before each repetition.
class XConnection {
 public:
  /// @throws InputError as CheckDisplay does.
  XConnection();
  ~XConnection();
  XConnection(const XConnection&) = delete;
  XConnection& operator=(const XConnection&) = delete;

  /// False if no key is down, or another window has the focus: then the release of a key that was
  /// held in ours is not reported.
  bool HasHeldKeys(unsigned long window) const;

  void* display() const { return display_; }  ///< Xlib's Display*.

 private:
  void* display_;
};

}  // namespace acus::window
