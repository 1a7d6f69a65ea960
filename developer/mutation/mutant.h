// All mutants of a build: each is off unless MUTANT holds its number. Included by the copies of the
// sources that developer/mutants writes.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdlib>
#include <fcntl.h>
#include <initializer_list>
#include <sys/mman.h>
#include <type_traits>
#include <unistd.h>
#include <utility>

namespace mutant {

constexpr int kMost = 65536;

// NOLINTBEGIN: shared by all sources of a program.
inline int active = 0;
inline unsigned char nowhere[kMost];
inline unsigned char* reached = nowhere;
// NOLINTEND

/// Before all other initialisers: which mutant is on, and the file with a byte for each that is
/// reached, by any process that has it in MUTANT_REACHED.
[[gnu::constructor(101)]] inline void Start() {
  if (reached != nowhere || active != 0) return;
  if (const char* number = std::getenv("MUTANT")) active = std::atoi(number);
  const char* path = std::getenv("MUTANT_REACHED");
  const int file = path != nullptr ? open(path, O_RDWR | O_CLOEXEC) : -1;
  if (file < 0) return;
  void* map = mmap(nullptr, kMost, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (map != MAP_FAILED) reached = static_cast<unsigned char*>(map);
  close(file);
}

template <int N>
constexpr bool On() {
  if (std::is_constant_evaluated()) return false;
  if (reached[N] == 0) reached[N] = 1;
  return active == N;
}

/// The change would not compile at this place.
template <int N>
constexpr void Impossible() {
  if (!std::is_constant_evaluated()) reached[N] = 2;
}

template <class T>
using Plain = std::remove_cvref_t<T>;
template <class T>
concept Number = std::is_arithmetic_v<T>;
template <class T>
concept Expression = requires {
  typename T::PlainObject;
};

/// What a result is held as: numbers and objects by value, expressions of Eigen evaluated.
template <class T>
struct Held {
  using Type = T;
};
template <Expression T>
struct Held<T> {
  using Type = typename T::PlainObject;
};

// a + b becomes a + PlusMinus<N>{} + b: the order of operations stays.
#define MUTANT_OPERATOR(NAME, BEFORE, AFTER)                                                \
  template <int N>                                                                          \
  struct NAME {};                                                                           \
  template <class A, int N>                                                                 \
  struct NAME##Left {                                                                       \
    A&& a;                                                                                  \
  };                                                                                        \
  template <class A, int N>                                                                 \
  constexpr NAME##Left<A, N> operator BEFORE(A&& a, NAME<N>) {                              \
    return {std::forward<A>(a)};                                                            \
  }                                                                                         \
  template <class A, int N, class B>                                                        \
  constexpr auto operator BEFORE(NAME##Left<A, N> left, B&& b) {                            \
    using Before = Plain<decltype(std::forward<A>(left.a) BEFORE std::forward<B>(b))>;      \
    using Result = typename Held<Before>::Type;                                             \
    if constexpr (requires { Result(std::forward<A>(left.a) AFTER std::forward<B>(b)); }) { \
      if (On<N>()) return Result(std::forward<A>(left.a) AFTER std::forward<B>(b));         \
    } else {                                                                                \
      Impossible<N>();                                                                      \
    }                                                                                       \
    return Result(std::forward<A>(left.a) BEFORE std::forward<B>(b));                       \
  }

MUTANT_OPERATOR(PlusMinus, +, -)
MUTANT_OPERATOR(MinusPlus, -, +)
MUTANT_OPERATOR(TimesOver, *, /)
MUTANT_OPERATOR(OverTimes, /, *)
MUTANT_OPERATOR(LessOrEqual, <, <=)
MUTANT_OPERATOR(LessGreater, <, >)
MUTANT_OPERATOR(AtMostLess, <=, <)
MUTANT_OPERATOR(GreaterOrEqual, >, >=)
MUTANT_OPERATOR(GreaterLess, >, <)
MUTANT_OPERATOR(AtLeastGreater, >=, >)
MUTANT_OPERATOR(EqualNot, ==, !=)
MUTANT_OPERATOR(NotEqual, !=, ==)
#undef MUTANT_OPERATOR

/// x += y becomes x += Sign<N>{} | y.
template <int N>
struct Sign {};
template <int N, class B>
constexpr decltype(auto) operator|(Sign<N>, B&& b) {
  if constexpr (Number<Plain<B>> || Expression<Plain<B>>) {
    using Result = typename Held<Plain<B>>::Type;
    if (On<N>()) return Result(-b);
    return Result(b);
  } else {
    Impossible<N>();
    return std::forward<B>(b);
  }
}

/// The operands of && and || as functions: the second is only asked for if it decides.
template <int N, class A, class B>
constexpr bool AndOr(const A& a, const B& b) {
  return On<N>() ? a() || b() : a() && b();
}
template <int N, class A, class B>
constexpr bool OrAnd(const A& a, const B& b) {
  return On<N>() ? a() && b() : a() || b();
}

template <int N, class T>
constexpr T Min(const T& a, const T& b) {
  return On<N>() ? std::max(a, b) : std::min(a, b);
}
template <int N, class T>
constexpr T Min(std::initializer_list<T> values) {
  return On<N>() ? std::max(values) : std::min(values);
}
template <int N, class T>
constexpr T Max(const T& a, const T& b) {
  return On<N>() ? std::min(a, b) : std::max(a, b);
}
template <int N, class T>
constexpr T Max(std::initializer_list<T> values) {
  return On<N>() ? std::min(values) : std::max(values);
}

template <int N, class T>
auto Sin(T angle_rad) {
  return On<N>() ? std::cos(angle_rad) : std::sin(angle_rad);
}
template <int N, class T>
auto Cos(T angle_rad) {
  return On<N>() ? std::sin(angle_rad) : std::cos(angle_rad);
}

/// A literal. Not constexpr: where a constant is needed the mutant does not compile.
template <int N, class T>
inline T Value(T before, T after) {
  return On<N>() ? after : before;
}

}  // namespace mutant
