// Which library a device has, with and without loading it. The library leaves a mark when it is
// loaded.
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/rig/haptics/open_device.h"
#include "support/temporary_folder.h"

namespace acus::haptics {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

class VendorsLibrary : public testing::TestWithParam<DriverKind> {
 protected:
  VendorsLibrary() : before_(fs::current_path()) {
    fs::permissions(folder_.path(), fs::perms::owner_all);
    for (const char* name : {"libdhd.so.3", "libHD.so", "libVirtuoseAPI.so", "mine.so"}) {
      fs::copy_file(fs::path(ACUS_STAND_INS) / "marker/libacus_marker.so", folder_ / name);
      fs::permissions(folder_ / name, fs::perms::owner_all);
    }
    setenv("ACUS_MARK", (folder_ / "mark").c_str(), 1);
    fs::current_path(folder_.path());
    config_.name = "right";
    config_.driver = GetParam();
    config_.vendor.timeout_s = 20.0;
  }
  ~VendorsLibrary() override {
    fs::current_path(before_);
    unsetenv("ACUS_MARK");
  }
  bool has_run() const { return fs::exists(folder_ / "mark"); }

  TemporaryFolder folder_;
  fs::path before_;
  DeviceConfig config_;
};

TEST_P(VendorsLibrary, IsNamedButNotLoadedByACheck) {
  config_.vendor.library = folder_ / "mine.so";
  const auto device = CheckDevice(config_);
  EXPECT_THAT(device->info().name,
              AllOf(HasSubstr(fs::canonical(folder_ / "mine.so")), HasSubstr("not loaded")));
  EXPECT_THROW(
      device->Start({.tick = [](void*, const DeviceReading&) noexcept { return DeviceForce(); },
                     .context = nullptr}),
      InputError);
  EXPECT_FALSE(has_run());

  // Opened, it is loaded, and turns out to lack all functions.
  EXPECT_THAT([&] { OpenDevice(config_); },
              ThrowsMessage<InputError>(HasSubstr("its library lacks functions")));
  EXPECT_TRUE(has_run());
}

TEST_P(VendorsLibrary, OfTheWorkingDirectoryIsNotLoaded) {
  // The usual names lie there, and so does the name that is asked for.
  for (const char* library : {"", "mine.so"}) {
    config_.vendor.library = library;
    EXPECT_THROW(CheckDevice(config_), InputError) << library;
    EXPECT_THROW(OpenDevice(config_), InputError) << library;
  }
  config_.vendor.library = "./mine.so";
  for (const auto& open : {CheckDevice, +[](const DeviceConfig& c) { return OpenDevice(c); }}) {
    EXPECT_THAT([&] { open(config_); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("device 'right'"),
                                                HasSubstr("depends on the working directory"))));
  }
  EXPECT_FALSE(has_run());
}

TEST_P(VendorsLibrary, ThatOthersMayWriteIsNotLoaded) {
  config_.vendor.library = folder_ / "mine.so";
  fs::permissions(folder_ / "mine.so", fs::perms(0777));
  for (const auto& open : {CheckDevice, +[](const DeviceConfig& c) { return OpenDevice(c); }}) {
    EXPECT_THAT([&] { open(config_); },
                ThrowsMessage<InputError>(HasSubstr("may be written by everybody")));
  }
  EXPECT_FALSE(has_run());
}

INSTANTIATE_TEST_SUITE_P(Drivers, VendorsLibrary,
                         testing::Values(DriverKind::kOpenHaptics, DriverKind::kForceDimension,
                                         DriverKind::kVirtuose));

TEST(CheckDevice, OpensAVirtualHandAsItIs) {
  EXPECT_EQ(CheckDevice({})->info().name, "virtual hand");
}

}  // namespace
}  // namespace acus::haptics
