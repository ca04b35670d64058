// SPDX-License-Identifier: Apache-2.0
// Arguments of the C interface: pointers, arrays, numbers, and structs that begin with their size.
#pragma once

#include <gnosphere.h>

#include <cstring>
#include <gnosphere/error.hpp>
#include <gnosphere/gnosphere.hpp>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace gnosphere::c {

[[noreturn]] void refuse(const std::string& why);

/// Returns what a pointer leads to; a null pointer is an error that names it.
template <class T>
T& the(T* pointer, const char* name) {
  if (!pointer) refuse(std::string(name) + " is null");
  return *pointer;
}

/// Refuses the size of a struct that no version of it can have, or that is of a newer version than this library. Every
/// version has a multiple of the struct's alignment. No such size ends within a pointer or another number, because none
/// of them is larger than the alignment.
void checkSize(size_t given, size_t known, size_t alignment, const char* type);

/// The two arguments by which sized() and Out know a struct that begins with its size: the default values of this
/// version's gno_..._init(), and the name.
#define GNO_TYPE(type) type##_init(), #type

/// A struct of the caller that begins with its size. A caller that was compiled with an older version has a smaller
/// one: the members that it lacks keep their default values.
template <class T>
T sized(const T* pointer, T value, const char* type) {
  const size_t given = the(pointer, type).struct_size;
  checkSize(given, sizeof(T), alignof(T), type);
  std::memcpy(&value, pointer, given);
  value.struct_size = sizeof(T);
  return value;
}

/// Checks an array of the caller, which may be null if it is empty.
template <class T>
std::span<T> array(T* values, size_t count, const char* name) {
  if (!values && count > 0) refuse(std::string(name) + " is null, but its count is " + std::to_string(count));
  return {values, count};
}

/// Checks an array of the caller that has `each` values for each of `count` things. A size that overflows is refused.
template <class T>
std::span<T> array(T* values, size_t count, size_t each, const char* name) {
  if (each > 0 && count > SIZE_MAX / sizeof(T) / each)
    refuse("the count of " + std::string(name) + " is " + std::to_string(count) + ", more than memory can hold");
  return array(values, count * each, name);
}

/// Calls use(entry) for the entries of an array of the caller, in order. An error says which entry it is about.
template <class T, class Use>
void forEntries(std::span<T> entries, const char* name, const Use& use) {
  size_t index = 0;
  try {
    for (; index < entries.size(); ++index) use(entries[index]);
  } catch (const Error& error) {
    throw Error(error.code(), std::string(name) + "[" + std::to_string(index) + "]: " + error.what());
  }
}

/// Calls use(entry) as forEntries() does for an array of structs that begin with their sizes, which are as far apart as
/// the first one says. An entry of another size is refused.
template <class T, class Use>
void forSized(const T* values, size_t count, const T& defaults, const char* type, const char* name, const Use& use) {
  array(values, count, name);
  std::vector<const T*> entries;
  for (size_t i = 0; i < count; ++i)
    entries.push_back(reinterpret_cast<const T*>(reinterpret_cast<const char*>(values) + i * values->struct_size));
  forEntries(std::span(entries), name, [&](const T* entry) {
    if (entry->struct_size != values->struct_size)
      refuse("its struct_size is " + std::to_string(entry->struct_size) + ", and that of " + name + "[0] is " +
             std::to_string(values->struct_size) + "; make all entries with " + type + "_init()");
    use(sized(entry, defaults, type));
  });
}

/// A struct of the caller that a function fills, as far as the caller knows its members.
template <class T>
class Out {
 public:
  Out(T* pointer, const T& defaults, const char* type) : to_(pointer), value_(sized(pointer, defaults, type)) {}
  Out(const Out&) = delete;
  Out& operator=(const Out&) = delete;
  ~Out() {
    const size_t given = to_->struct_size;
    std::memcpy(to_, &value_, given);
    to_->struct_size = given;
  }
  T& operator*() const { return value_; }
  T* operator->() const { return &value_; }

 private:
  T* to_;
  mutable T value_;
};

/// The enumerator of a number; `last` is the greatest there is.
template <class Enum>
Enum enumOf(int32_t number, Enum last, const char* name) {
  if (number < 0 || number > static_cast<int32_t>(last))
    refuse(std::string(name) + " is " + std::to_string(number) + ", which is none of 0.." +
           std::to_string(static_cast<int32_t>(last)));
  return static_cast<Enum>(number);
}

/// Whether the enumerators of an enum of C and of one of C++, in pairs, are 0, 1, 2 and so on.
template <class Enum>
constexpr bool inOrder(std::initializer_list<std::pair<int32_t, Enum>> pairs) {
  int32_t next = 0;
  for (const auto& [ofC, ofCpp] : pairs)
    if (ofC != next || static_cast<int32_t>(ofCpp) != next++) return false;
  return true;
}

/// Asserts that an enum of the C headers has the values of one of C++, because casts take the one for the other. Every
/// enumerator is to be named, in pairs such as {GNO_UP_Y, y}.
#define GNO_SAME_ENUM(Enum, ...)                             \
  static_assert(                                             \
      [] {                                                   \
        using enum Enum;                                     \
        return ::gnosphere::c::inOrder<Enum>({__VA_ARGS__}); \
      }(),                                                   \
      "an enum of C has the values of " #Enum)

inline std::string orEmpty(const char* text) {
  return text ? text : "";
}

inline Vec3 vec3(const double* v) {
  return {v[0], v[1], v[2]};
}
inline void set(double* to, const Vec3& v) {
  to[0] = v.x, to[1] = v.y, to[2] = v.z;
}
template <class T>
const T* orNull(const std::vector<T>& values) {
  return values.empty() ? nullptr : values.data();
}
/// Returns the value at a caller's index; an index that does not exist is an error that names the noun.
template <class T>
const T& at(const std::vector<T>& values, size_t index, const char* noun) {
  if (index >= values.size())
    refuse(std::string(noun) + " " + std::to_string(index) + " does not exist, there are " +
           std::to_string(values.size()));
  return values[index];
}

}  // namespace gnosphere::c
