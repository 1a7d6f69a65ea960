#include "acus/imaging/graphics/gl_context.h"

#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <array>
#include <string_view>

#include "acus/base/core/error.h"

namespace acus::graphics {
namespace {

constexpr int kMaxDevices = 16;

/// Functions of EGL_EXT_device_enumeration and EGL_EXT_platform_device: null where they are not
/// there.
struct DeviceFunctions {
  PFNEGLQUERYDEVICESEXTPROC query_devices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  PFNEGLQUERYDEVICESTRINGEXTPROC query_string = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(
      eglGetProcAddress("eglQueryDeviceStringEXT"));
  PFNEGLGETPLATFORMDISPLAYEXTPROC display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      eglGetProcAddress("eglGetPlatformDisplayEXT"));

  bool complete() const {
    return query_devices != nullptr && query_string != nullptr && display != nullptr;
  }
};

bool ComputesOnProcessor(const DeviceFunctions& egl, EGLDeviceEXT device) {
  const char* extensions = egl.query_string(device, EGL_EXTENSIONS);
  return extensions == nullptr ||
         std::string_view(extensions).find("EGL_MESA_device_software") != std::string_view::npos;
}

std::string DriverText(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text == nullptr ? "" : text;
}

/// Memory of the card, MB; 0 if the driver has neither GL_NVX_gpu_memory_info nor GL_ATI_meminfo.
int MemoryMb() {
  constexpr GLenum kNvidiaTotalKb = 0x9048;
  constexpr GLenum kAmdFreeTextureKb = 0x87FC;
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint n = 0; n < count; ++n) {
    const std::string_view extension =
        reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(n)));
    std::array<GLint, 4> kb{};
    if (extension == "GL_NVX_gpu_memory_info") {
      glGetIntegerv(kNvidiaTotalKb, kb.data());
    } else if (extension == "GL_ATI_meminfo") {
      glGetIntegerv(kAmdFreeTextureKb, kb.data());
    } else {
      continue;
    }
    return kb[0] / 1024;
  }
  return 0;
}

}  // namespace

GlContext::GlContext(DriverKind kind) {
  const DeviceFunctions egl;
  std::array<EGLDeviceEXT, kMaxDevices> devices{};
  EGLint count = 0;
  if (egl.complete()) egl.query_devices(kMaxDevices, devices.data(), &count);
  for (const bool on_processor : {false, true}) {
    if (on_processor && kind == DriverKind::kHardware) break;
    for (int n = 0; n < count; ++n) {
      EGLDeviceEXT device = devices[static_cast<std::size_t>(n)];
      if (ComputesOnProcessor(egl, device) == on_processor &&
          Open(egl.display(EGL_PLATFORM_DEVICE_EXT, device, nullptr))) {
        return;
      }
    }
  }
  throw InputError(kind == DriverKind::kHardware
                       ? "no graphics card with a driver for OpenGL 4.5 was found"
                       : "no driver for OpenGL 4.5 was found; install that of the graphics card, "
                         "or libegl-mesa0 to compute on the processor");
}

bool GlContext::Open(void* display) {
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE) {
    return false;
  }
  display_ = display;
  // The first also reports a reset of the card, which not all drivers can.
  const std::array tells_resets{EGL_CONTEXT_MAJOR_VERSION,
                                4,
                                EGL_CONTEXT_MINOR_VERSION,
                                5,
                                EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                EGL_LOSE_CONTEXT_ON_RESET,
                                EGL_NONE};
  std::array plain = tells_resets;
  plain[6] = EGL_NONE;
  eglBindAPI(EGL_OPENGL_API);
  for (const auto& attributes : {tells_resets, plain}) {
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (context_ != EGL_NO_CONTEXT) break;
  }
  if (context_ == EGL_NO_CONTEXT ||
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
    Close();
    return false;
  }
  renderer_ = DriverText(GL_RENDERER);
  return true;
}

void GlContext::Close() {
  if (display_ == nullptr) return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  if (context_ != nullptr) eglDestroyContext(display_, context_);
  // The display is shared by all contexts of the process on that device: it stays.
  eglReleaseThread();
  display_ = context_ = nullptr;
}

GlContext::~GlContext() {
  Close();
}

std::string GlContext::Description() const {
  const int memory_mb = MemoryMb();
  return renderer_ + ", OpenGL " + DriverText(GL_VERSION) +
         (memory_mb > 0 ? ", " + std::to_string(memory_mb) + " MB" : "");
}

void GlContext::Check(const char* what) const {
  ACUS_REQUIRE(glGetGraphicsResetStatus() == GL_NO_ERROR, "graphics card: it was reset (", what,
               ")");
  const GLenum error = glGetError();
  ACUS_REQUIRE(error != GL_OUT_OF_MEMORY, "graphics card: not enough memory (", what, ")");
  ACUS_REQUIRE(error == GL_NO_ERROR, "graphics card: OpenGL error ", error, " (", what, ")");
}

}  // namespace acus::graphics
