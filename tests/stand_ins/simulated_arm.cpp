#include "simulated_arm.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <limits>
#include <sstream>
#include <unistd.h>

namespace stand_in {
namespace {

constexpr double kTickS = 1e-3;
constexpr double kMassKg = 0.1;
constexpr double kHandNPerM = 400.0;
constexpr double kHandNSPerM = 12.0;
constexpr double kFreeN = 1e-9;

__attribute__((constructor)) void OnLoad() {
  const char* faults = std::getenv("ACUS_STAND_IN_FAULTS");
  if (const char* log = std::getenv("ACUS_STAND_IN_LOG"); log != nullptr) Arm::Get().LogTo(log);
  Arm::Get().Reset(faults != nullptr ? faults : "");
  if (Arm::Get().Fault("abort_constructor") != 0.0) std::abort();
  while (Arm::Get().Fault("hang_constructor") != 0.0) sleep(1);
}

double Norm(const Vector& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

}  // namespace

Arm& Arm::Get() {
  static Arm* arm = new Arm;
  return *arm;
}

void Arm::Reset(const std::string& faults) {
  const std::lock_guard lock(mutex_);
  faults_.clear();
  values_.clear();
  log_.clear();
  tick_ = 0;
  give_m_ = speed_m_s_ = force_n_ = {};
  last_n_ = 0.0;
  is_open_ = motors_are_on_ = false;
  std::istringstream list(faults);
  for (std::string item; std::getline(list, item, ',');) {
    const auto equal = item.find('=');
    faults_[item.substr(0, equal)] = std::strtod(item.c_str() + equal + 1, nullptr);
  }
}

void Arm::LogTo(const std::string& path) {
  const std::lock_guard lock(mutex_);
  log_file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

void Arm::Set(const std::string& fault, double value) {
  const std::lock_guard lock(mutex_);
  faults_[fault] = value;
}

double Arm::Find(const std::string& name, double otherwise) const {
  const auto found = faults_.find(name);
  return found == faults_.end() ? otherwise : found->second;
}

bool Arm::Reached(const std::string& name) const {
  return static_cast<double>(tick_) >= Find(name, std::numeric_limits<double>::infinity());
}

double Arm::Fault(const std::string& name, double otherwise) {
  const std::lock_guard lock(mutex_);
  return Find(name, otherwise);
}

bool Arm::HasCome(const std::string& name) {
  const std::lock_guard lock(mutex_);
  return Reached(name);
}

bool Arm::IsNow(const std::string& name) {
  const std::lock_guard lock(mutex_);
  return static_cast<double>(tick_) == Find(name, -1.0);
}

bool Arm::Fails() {
  const std::lock_guard lock(mutex_);
  if (Reached("unplugged")) return true;
  if (!Reached("error_at") || values_["errors"] >= Find("error_times", 1.0)) return false;
  ++values_["errors"];
  return true;
}

void Arm::Write(const std::string& line) {
  if (log_.size() < 100'000) log_ += line + "\n";
  if (log_file_ < 0) return;
  const std::string text = line + "\n";
  if (write(log_file_, text.data(), text.size()) < 0) log_file_ = -1;
}

void Arm::Log(const std::string& call) {
  const std::lock_guard lock(mutex_);
  Write(call);
}

std::string Arm::log() {
  const std::lock_guard lock(mutex_);
  return log_;
}

double Arm::Value(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (name == "ticks") return static_cast<double>(tick_);
  if (name == "last_n") return last_n_;
  if (name == "is_open") return is_open_ ? 1.0 : 0.0;
  if (name == "motors_on") return motors_are_on_ ? 1.0 : 0.0;
  const auto found = values_.find(name);
  return found == values_.end() ? 0.0 : found->second;
}

bool Arm::Open() {
  const std::lock_guard lock(mutex_);
  if (Reached("unplugged")) return false;
  tick_ = 0;
  is_open_ = true;
  Write("opened");
  if (++values_["opened"] > 1.0) faults_.erase("loop_dies");
  return true;
}

void Arm::Close() {
  const std::lock_guard lock(mutex_);
  is_open_ = false;
  motors_are_on_ = false;
  ++values_["closed"];
}

void Arm::SwitchMotors(bool on) {
  const std::lock_guard lock(mutex_);
  motors_are_on_ = on;
  if (on) return;
  if (last_n_ > kFreeN) Write("force zero");
  force_n_ = {};
  last_n_ = 0.0;
}

Pose Arm::Read() {
  const std::lock_guard lock(mutex_);
  ++tick_;
  ++values_["readings"];
  for (int i = 0; i < 3; ++i) {
    const double pull_n = force_n_[i] - kHandNPerM * give_m_[i] - kHandNSPerM * speed_m_s_[i];
    speed_m_s_[i] += kTickS * pull_n / kMassKg;
    give_m_[i] += kTickS * speed_m_s_[i];
  }
  const double t = kTickS * static_cast<double>(tick_);
  const double turn = 0.3 * std::sin(t);  // About our y.
  Pose pose{
      .place_m = {0.010 + 0.005 * std::sin(2.0 * t) + give_m_[0], 0.020 + give_m_[1],
                  0.030 + give_m_[2]},
      .rotation = {{{std::cos(turn), 0, std::sin(turn)},
                    {0, 1, 0},
                    {-std::sin(turn), 0, std::cos(turn)}}},
      .velocity_m_s = {0.010 * std::cos(2.0 * t) + speed_m_s_[0], speed_m_s_[1], speed_m_s_[2]}};
  if (Reached("jump")) pose.place_m[0] += 0.050;
  if (static_cast<double>(tick_) == Find("nan_pose", -1.0)) pose.place_m[1] = std::nan("");
  if (static_cast<double>(tick_) == Find("inf_pose", -1.0)) pose.place_m[2] = HUGE_VAL;
  if (static_cast<double>(tick_) == Find("no_rotation", -1.0)) pose.rotation = {};
  pose.rotation[0][1] += Find("skew", 0.0);
  values_["place_x_mm"] = 1e3 * pose.place_m[0];
  return pose;
}

unsigned Arm::Buttons() {
  const std::lock_guard lock(mutex_);
  return Find("stuck_button", 0.0) != 0.0 || Reached("button_from") ? 1U : 0U;
}

void Arm::Push(const Vector& force_n, const Vector& torque_nm) {
  const std::lock_guard lock(mutex_);
  const double norm_n = Norm(force_n);
  const double norm_nm = Norm(torque_nm);
  if (!std::isfinite(norm_n) || !std::isfinite(norm_nm)) {
    ++values_["not_finite"];
    return;
  }
  ++values_["pushes"];
  if (norm_n > kFreeN && !motors_are_on_) ++values_["pushes_without_motors"];
  if (!is_open_) ++values_["pushes_when_closed"];
  values_["max_n"] = std::max(values_["max_n"], norm_n);
  values_["max_nm"] = std::max(values_["max_nm"], norm_nm);
  values_["max_rise_n"] = std::max(values_["max_rise_n"], norm_n - last_n_);
  if (norm_n > kFreeN) {
    values_["fx_n"] = force_n[0];
    values_["fy_n"] = force_n[1];
    values_["fz_n"] = force_n[2];
    values_["tx_nm"] = torque_nm[0];
    values_["ty_nm"] = torque_nm[1];
    values_["tz_nm"] = torque_nm[2];
  }
  if ((norm_n > kFreeN) != (last_n_ > kFreeN) || values_["pushes"] == 1.0) {
    Write(norm_n > kFreeN ? "force on" : "force zero");
  }
  last_n_ = norm_n;
  force_n_ = motors_are_on_ ? force_n : Vector{};
}

double Arm::SleepSeconds() {
  const std::lock_guard lock(mutex_);
  if (Find("jitter", 0.0) == 0.0) return kTickS;
  random_ = random_ * 1664525U + 1013904223U;
  const double share = static_cast<double>(random_ >> 8U) / static_cast<double>(1U << 24U);
  return share < 0.97 ? 0.0002 + 0.0015 * share : 0.020;
}

Vector VendorAxes::ToVendor(const Vector& v) const {
  return {v[ours[0]], v[ours[1]], v[ours[2]]};
}

Vector VendorAxes::ToOurs(const Vector& v) const {
  Vector result{};
  for (int i = 0; i < 3; ++i) result[ours[i]] = v[i];
  return result;
}

Matrix VendorAxes::ToVendor(const Matrix& m) const {
  Matrix result{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result[i][j] = m[ours[i]][ours[j]];
  }
  return result;
}

}  // namespace stand_in

ACUS_EXPORT void acus_stand_in_reset(const char* faults) {
  stand_in::Arm::Get().Reset(faults);
}

ACUS_EXPORT void acus_stand_in_set(const char* fault, double value) {
  stand_in::Arm::Get().Set(fault, value);
}

ACUS_EXPORT double acus_stand_in_value(const char* name) {
  return stand_in::Arm::Get().Value(name);
}

/// @param buffer  of `size` characters.
ACUS_EXPORT void acus_stand_in_log(char* buffer, unsigned long size) {
  const std::string log = stand_in::Arm::Get().log();
  const unsigned long length = log.copy(buffer, size - 1);
  buffer[length] = '\0';
}
