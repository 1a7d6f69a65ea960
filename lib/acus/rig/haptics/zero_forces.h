// Zero force however the process ends, as far as a process can see to it.
//
// Every HapticDevice that runs is registered here by itself. What is done, and when:
//   exit(), end of main, uncaught exception (std::terminate)   every motor is set to zero
//   SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGTERM, SIGHUP, SIGQUIT, SIGINT
//                                                              after ZeroForcesOnSignals()
//   SIGKILL, power cut                                         nothing: the device's own watchdog
//
// Vendors' functions may take locks and allocate, so that none can be called in a signal handler.
// The handler does only what is async-signal-safe: it sets a flag, at which every guard gives zero
// from its next tick on; wakes a thread that was started beforehand, by write(); and waits for its
// answer, by poll(), 0.2 s at most. That thread calls the vendors' functions. If the thread that
// crashed holds a lock of the vendor's library, it cannot; then the device's own watchdog stops the
// motors when the process is gone.
#pragma once

namespace acus::haptics {

class Driver;

/// Handles the signals above: zero forces, then whatever was to happen before (a handler of the
/// program for SIGINT and SIGTERM stays, and is called after). Once per process; again does
/// nothing.
void ZeroForcesOnSignals();

/// All forces are zero from now on, for good. Async-signal-safe.
void CutForces() noexcept;
bool ForcesAreCut() noexcept;

/// Registers a driver whose motors are on. At most 16 at a time. @throws InputError if there are
/// more.
void RegisterForZero(Driver* driver);
/// When it returns, the driver is not touched any more.
void UnregisterForZero(Driver* driver) noexcept;

}  // namespace acus::haptics
