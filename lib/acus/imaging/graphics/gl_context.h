// A context of OpenGL 4.5 without a window, by EGL: on a graphics card, or on the processor.
#pragma once

#include <string>

namespace acus::graphics {

enum class DriverKind {
  kHardware,  ///< A graphics card only.
  kAny,       ///< A graphics card, or else a driver that computes on the processor.
};

/// Current in the thread that made it, until it ends there. Needs no display.
class GlContext {
 public:
  /// @throws InputError if there is no driver of that kind with OpenGL 4.5.
  explicit GlContext(DriverKind kind);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// As the driver calls itself.
  const std::string& renderer() const { return renderer_; }
  /// One line: the card, OpenGL and the driver, and the card's memory where the driver says it.
  std::string Description() const;

  /// @throws InputError naming `what` if OpenGL reported an error since the last call, or the
  ///     context is lost: the card was reset, or its driver has ended.
  void Check(const char* what) const;

 private:
  bool Open(void* display);
  void Close();

  void* display_ = nullptr;
  void* context_ = nullptr;
  std::string renderer_;
};

}  // namespace acus::graphics
