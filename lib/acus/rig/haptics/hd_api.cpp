#include "acus/rig/haptics/hd_api.h"

#include <array>

namespace acus::haptics::hd {

LibraryRequest Library(const std::string& library, double timeout_s) {
  return {.product = "OpenHaptics",
          .path = library,
          .names = {"libHD.so", "libHD.so.3.4"},
          // libHD looks for symbols of these without asking for them.
          .preload = {"libncurses.so.5", "libPhantomIOLib42.so"},
          .shares_symbols = true,
          .advice =
              "Install the Touch device driver and OpenHaptics of 3D Systems, or name the file "
              "under 'library' in the devices file",
          .timeout_s = timeout_s};
}

Api Load(const std::string& library, double timeout_s) {
  Api api;
  const std::array symbols = {Required("hdInitDevice", api.InitDevice),
                              Required("hdDisableDevice", api.DisableDevice),
                              Required("hdMakeCurrentDevice", api.MakeCurrentDevice),
                              Required("hdGetCurrentDevice", api.GetCurrentDevice),
                              Required("hdBeginFrame", api.BeginFrame),
                              Required("hdEndFrame", api.EndFrame),
                              Required("hdGetError", api.GetError),
                              Optional("hdGetErrorString", api.GetErrorString),
                              Required("hdEnable", api.Enable),
                              Required("hdDisable", api.Disable),
                              Required("hdGetIntegerv", api.GetIntegerv),
                              Required("hdGetDoublev", api.GetDoublev),
                              Optional("hdGetString", api.GetString),
                              Required("hdSetDoublev", api.SetDoublev),
                              Required("hdCheckCalibration", api.CheckCalibration),
                              Optional("hdCheckCalibrationStyle", api.CheckCalibrationStyle),
                              Required("hdUpdateCalibration", api.UpdateCalibration),
                              Required("hdStartScheduler", api.StartScheduler),
                              Required("hdStopScheduler", api.StopScheduler),
                              Optional("hdSetSchedulerRate", api.SetSchedulerRate),
                              Required("hdScheduleAsynchronous", api.ScheduleAsynchronous),
                              Required("hdUnschedule", api.Unschedule)};
  LoadLibrary(Library(library, timeout_s), symbols);
  return api;
}

}  // namespace acus::haptics::hd
