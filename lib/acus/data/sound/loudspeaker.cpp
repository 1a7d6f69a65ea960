#include "acus/data/sound/loudspeaker.h"

#include "acus/base/core/error.h"
#include "acus/base/core/shared_library.h"

namespace acus::loudspeaker {
namespace {

// Declarations of al.h and alc.h (OpenAL 1.1), whose binary interface has been the same since 2005.
struct AlcDevice;
struct AlcContext;
constexpr int kMono16 = 0x1101;
constexpr int kBuffer = 0x1009;
constexpr int kNoError = 0;

struct OpenAl {
  AlcDevice* (*open_device)(const char* name) = nullptr;
  char (*close_device)(AlcDevice*) = nullptr;
  AlcContext* (*create_context)(AlcDevice*, const int* attributes) = nullptr;
  char (*make_current)(AlcContext*) = nullptr;
  void (*destroy_context)(AlcContext*) = nullptr;
  int (*error)() = nullptr;
  void (*gen_buffers)(int, unsigned*) = nullptr;
  void (*delete_buffers)(int, const unsigned*) = nullptr;
  void (*buffer_data)(unsigned, int format, const void*, int bytes, int rate_hz) = nullptr;
  void (*gen_sources)(int, unsigned*) = nullptr;
  void (*delete_sources)(int, const unsigned*) = nullptr;
  void (*source_i)(unsigned, int what, int value) = nullptr;
  void (*source_play)(unsigned) = nullptr;
};

OpenAl LoadOpenAl() {
  OpenAl al;
  const Symbol symbols[] = {Required("alcOpenDevice", al.open_device),
                            Required("alcCloseDevice", al.close_device),
                            Required("alcCreateContext", al.create_context),
                            Required("alcMakeContextCurrent", al.make_current),
                            Required("alcDestroyContext", al.destroy_context),
                            Required("alGetError", al.error),
                            Required("alGenBuffers", al.gen_buffers),
                            Required("alDeleteBuffers", al.delete_buffers),
                            Required("alBufferData", al.buffer_data),
                            Required("alGenSources", al.gen_sources),
                            Required("alDeleteSources", al.delete_sources),
                            Required("alSourcei", al.source_i),
                            Required("alSourcePlay", al.source_play)};
  LoadLibrary({.product = "OpenAL Soft",
               .path = "",
               .names = {"libopenal.so.1"},
               .preload = {},
               .advice = "Install the package libopenal1, or leave the sound out"},
              symbols);
  return al;
}

}  // namespace

struct Loudspeaker::Device {
  OpenAl al = LoadOpenAl();
  AlcDevice* device = nullptr;
  AlcContext* context = nullptr;
  unsigned buffer = 0;
  unsigned source = 0;

  ~Device() {
    if (source != 0) al.delete_sources(1, &source);  // One that still plays is stopped.
    if (buffer != 0) al.delete_buffers(1, &buffer);
    if (context != nullptr) {
      al.make_current(nullptr);
      al.destroy_context(context);
    }
    if (device != nullptr) al.close_device(device);
  }
};

Loudspeaker::Loudspeaker(const sound::Sound& sound) : device_(std::make_unique<Device>()) {
  Device& d = *device_;
  constexpr const char* kTry =
      "; connect one, or leave the sound out (ALSOFT_DRIVERS=null discards it)";
  d.device = d.al.open_device(nullptr);
  ACUS_REQUIRE(d.device != nullptr, "loudspeaker: OpenAL Soft finds none", kTry);
  d.context = d.al.create_context(d.device, nullptr);
  ACUS_REQUIRE(d.context != nullptr && d.al.make_current(d.context) != 0,
               "loudspeaker: it cannot be used", kTry);
  d.al.gen_buffers(1, &d.buffer);
  d.al.buffer_data(d.buffer, kMono16, sound.samples.data(),
                   static_cast<int>(2 * sound.samples.size()), sound.rate_hz);
  d.al.gen_sources(1, &d.source);
  d.al.source_i(d.source, kBuffer, static_cast<int>(d.buffer));
  const int error = d.al.error();
  ACUS_REQUIRE(error == kNoError, "loudspeaker: OpenAL Soft does not take the sound (error ", error,
               ")", kTry);
}

Loudspeaker::~Loudspeaker() = default;

void Loudspeaker::Play() noexcept {
  device_->al.source_play(device_->source);
}

}  // namespace acus::loudspeaker
