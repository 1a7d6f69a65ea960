// The arm behind the stand-in libraries: moves, is pushed, remembers what it was told, and breaks
// as it is asked to. Each library has one of its own.
//
// Faults are "name=value,name=value", from $ACUS_STAND_IN_FAULTS when the library is loaded, or by
// acus_stand_in_reset(). What happened is logged to $ACUS_STAND_IN_LOG as well. Those of every
// library, K being a number of readings since it was opened:
//   nan_pose=K inf_pose=K    one reading is not finite
//   jump=K                   from K on the handle is 50 mm further right
//   skew=S                   the rotation is not orthonormal, by S
//   no_rotation=K            one reading has a rotation of zeros
//   stuck_button=1           button 0 is held from the start; button_from=K: from K on
//   error_at=K error=N       a call fails with the vendor's number N; error_times=T: so many times
//   unplugged=K              from K on every call fails, opening it again, too
//   jitter=1                 the vendor's loop comes 0.2 to 20 ms after the last time
//   loop_dies=K              the vendor's loop stops
//   hang_constructor=1 abort_constructor=1 hang_open=1
#pragma once

#include <array>
#include <map>
#include <mutex>
#include <string>

#define ACUS_EXPORT extern "C" __attribute__((visibility("default")))

namespace stand_in {

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;  ///< Rows.

/// In the frame of our haptic_device.h: x right, y up, z to the user. m, rad.
struct Pose {
  Vector place_m;
  Matrix rotation;
  Vector velocity_m_s;
};

class Arm {
 public:
  static Arm& Get();

  void LogTo(const std::string& path);  ///< Line by line, for a process that will not be there.
  void Reset(const std::string& faults);
  void Set(const std::string& fault, double value);
  /// The value of a fault, or `otherwise`.
  double Fault(const std::string& name, double otherwise = 0.0);
  /// A fault with a tick: it has come. One that is not set never comes.
  bool HasCome(const std::string& name);
  /// The same, for the one tick.
  bool IsNow(const std::string& name);
  /// error_at has come, up to error_times times, or the arm is unplugged.
  bool Fails();

  void Log(const std::string& call);
  std::string log();
  /// What was recorded: see the source.
  double Value(const std::string& name);

  bool Open();  ///< False if it is unplugged. Counts readings anew.
  void Close();
  void SwitchMotors(bool on);
  Pose Read();  ///< Moves on by 1 ms.
  unsigned Buttons();
  /// What the motors got, SI, our frame.
  void Push(const Vector& force_n, const Vector& torque_nm);
  double SleepSeconds();  ///< Of the vendor's loop, until the next call.

 private:
  double Find(const std::string& name, double otherwise) const;
  bool Reached(const std::string& name) const;
  void Write(const std::string& line);

  std::mutex mutex_;
  std::map<std::string, double> faults_;
  std::map<std::string, double> values_;
  std::string log_;
  int log_file_ = -1;
  long tick_ = 0;
  unsigned random_ = 1;
  Vector give_m_{};  ///< How far it gave way to the force.
  Vector speed_m_s_{};
  Vector force_n_{};
  double last_n_ = 0.0;
  bool is_open_ = false;
  bool motors_are_on_ = false;
};

/// Which of our axes the vendor's x, y, z are.
struct VendorAxes {
  std::array<int, 3> ours;
  Vector ToVendor(const Vector& v) const;
  Vector ToOurs(const Vector& v) const;
  Matrix ToVendor(const Matrix& m) const;
};

}  // namespace stand_in
