// The connection to the X server.
#pragma once

namespace acus::window {

/// @throws InputError if there is no display to open a window on, with what to do about it.
void CheckDisplay();

/// Keys that are held send one release at the end, not one before each repetition.
class XConnection {
 public:
  /// @throws InputError as CheckDisplay does.
  XConnection();
  ~XConnection();
  XConnection(const XConnection&) = delete;
  XConnection& operator=(const XConnection&) = delete;

  /// False if no key is down, or another window gets the keys: then the release of a key that was
  /// held in ours is never told.
  bool HasHeldKeys(unsigned long window) const;

  void* display() const { return display_; }  ///< Xlib's Display*.

 private:
  void* display_;
};

}  // namespace acus::window
