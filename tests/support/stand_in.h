// A vendor's library that is none: tests/stand_ins. Each has a file of its own, so that each test
// begins with a library that was never loaded.
#pragma once

#include <dlfcn.h>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

#include "acus/rig/haptics/devices_file.h"

namespace acus::testing_support {

class StandIn {
 public:
  /// @param variant  folder of build/tests/stand_ins.  @param faults  see simulated_arm.h.
  StandIn(const std::string& variant, const std::string& faults) {
    namespace fs = std::filesystem;
    static int number = 0;
    folder_ = fs::temp_directory_path() /
              ("acus_stand_in_" + std::to_string(getpid()) + "_" + std::to_string(number++));
    fs::create_directories(folder_);
    // Whatever the umask: what others may write is not loaded.
    fs::permissions(folder_, fs::perms::owner_all);
    for (const auto& entry : fs::directory_iterator(fs::path(ACUS_STAND_INS) / variant)) {
      path_ = folder_ / entry.path().filename();
      fs::copy_file(entry.path(), path_);
      fs::permissions(path_, fs::perms::owner_all);
    }
    setenv("ACUS_STAND_IN_FAULTS", faults.c_str(), 1);
  }
  ~StandIn() { std::filesystem::remove_all(folder_); }
  StandIn(const StandIn&) = delete;
  StandIn& operator=(const StandIn&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// Of the library as the driver has loaded it; 0 if it has not.
  double Value(const std::string& name) const {
    const auto value = Find<double (*)(const char*)>("acus_stand_in_value");
    return value != nullptr ? value(name.c_str()) : 0.0;
  }
  void Set(const std::string& fault, double value) const {
    const auto set = Find<void (*)(const char*, double)>("acus_stand_in_set");
    if (set != nullptr) set(fault.c_str(), value);
  }
  std::string Log() const {
    const auto log = Find<void (*)(char*, unsigned long)>("acus_stand_in_log");
    std::vector<char> text(200'000, '\0');
    if (log != nullptr) log(text.data(), text.size());
    return text.data();
  }

  haptics::DeviceConfig Config(haptics::DriverKind driver) const {
    haptics::DeviceConfig config;
    config.name = "right";
    config.driver = driver;
    config.vendor.library = path_.string();
    return config;
  }

 private:
  template <typename Function>
  Function Find(const char* name) const {
    void* handle = dlopen(path_.c_str(), RTLD_NOW | RTLD_NOLOAD);
    return handle != nullptr ? reinterpret_cast<Function>(dlsym(handle, name)) : nullptr;
  }

  std::filesystem::path folder_;
  std::filesystem::path path_;
};

}  // namespace acus::testing_support
