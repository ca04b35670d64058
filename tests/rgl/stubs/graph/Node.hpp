// SPDX-License-Identifier: Apache-2.0
// Stands in for RGL's nodes, as far as the helpers of its tests name them.
#pragma once

#include <rgl/api/core.h>

#include <RGLFields.hpp>
#include <chrono>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

struct IAnyArray {
  using ConstPtr = std::shared_ptr<const IAnyArray>;
};

/// An array that is never filled.
template <typename T>
struct DeviceAsyncArray : IAnyArray {
  template <typename... Arguments>
  static std::shared_ptr<IAnyArray> create(Arguments&&...) {
    return std::make_shared<DeviceAsyncArray>();
  }
};

struct INoInputNode {
  virtual ~INoInputNode() = default;
};

struct IPointsNode {
  virtual ~IPointsNode() = default;
  virtual bool isDense() const { return false; }
  virtual bool hasField(rgl_field_t) const { return false; }
  virtual size_t getWidth() const { return 0; }
  virtual size_t getHeight() const { return 0; }
  virtual rgl_return_mode_t getReturnMode() const { return RGL_RETURN_UNKNOWN; }
  virtual size_t getReturnCount() const { return 0; }
  virtual IAnyArray::ConstPtr getFieldData(rgl_field_t) { return nullptr; }

 protected:
  virtual void enqueueExecImpl() {}
  virtual void validateImpl() {}
  void synchronize() {}
  int arrayMgr = 0;
};

struct IPointsNodeSingleInput : IPointsNode {};
