// SPDX-License-Identifier: Apache-2.0
// Numbers with a point, whatever the locale of the program.
#pragma once

#include "base/os.hpp"

namespace gnosphere {

/// While it lives, the functions of C's library write and read numbers with a decimal point in this thread.
class DecimalPoint {
 public:
  DecimalPoint() : before_(os::useClassicLocale()) {}
  ~DecimalPoint() { os::useLocale(before_); }
  DecimalPoint(const DecimalPoint&) = delete;
  DecimalPoint& operator=(const DecimalPoint&) = delete;

 private:
  os::Locale before_;
};

}  // namespace gnosphere
