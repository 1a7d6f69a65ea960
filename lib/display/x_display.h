// The connection to the X server.
#pragma once

namespace acus::display {

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

  void* display() const { return display_; }  ///< Xlib's Display*.

 private:
  void* display_;
};

}  // namespace acus::display
