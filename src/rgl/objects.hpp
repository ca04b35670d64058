// SPDX-License-Identifier: Apache-2.0
// Table of live objects by handle. A handle's value is never used twice.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <unordered_map>

#include "rgl/call.hpp"

namespace gnosphere::rgl {

uintptr_t nextHandle();

/// The live objects of one kind; `noun` is what messages call them.
template <class Handle, class T>
class Objects {
 public:
  explicit Objects(const char* noun) : noun_(noun) {}

  Handle add(std::shared_ptr<T> object) {
    const auto handle = reinterpret_cast<Handle>(nextHandle());
    objects_[handle] = std::move(object);
    return handle;
  }
  bool has(Handle handle) const { return objects_.contains(handle); }
  const std::shared_ptr<T>& at(Handle handle) const {
    const auto found = objects_.find(handle);
    if (found != objects_.end()) return found->second;
    char address[32];
    std::snprintf(address, sizeof address, "%p", static_cast<const void*>(handle));
    throw Failure(RGL_INVALID_API_OBJECT, std::string("Object does not exist: ") + noun_ + " " + address);
  }
  std::shared_ptr<T> remove(Handle handle) {
    const std::shared_ptr<T> object = at(handle);
    objects_.erase(handle);
    return object;
  }
  template <class Visit>
  void each(Visit visit) const {
    for (const auto& [handle, object] : objects_) visit(handle, *object);
  }
  template <class Predicate>
  void removeIf(Predicate predicate) {
    std::erase_if(objects_, [&](const auto& entry) { return predicate(entry.second.get()); });
  }
  void clear() { objects_.clear(); }

 private:
  const char* noun_;
  std::unordered_map<Handle, std::shared_ptr<T>> objects_;
};

}  // namespace gnosphere::rgl
