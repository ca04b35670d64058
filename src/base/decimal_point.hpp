// SPDX-License-Identifier: Apache-2.0
// Numbers with a point, whatever the locale of the program.
#pragma once

#include <locale.h>

namespace gnosphere {

/// While it lives, the functions of C's library write and read numbers with a decimal point in this thread.
class DecimalPoint {
 public:
  DecimalPoint() : before_(uselocale(classic())) {}
  ~DecimalPoint() { uselocale(before_); }
  DecimalPoint(const DecimalPoint&) = delete;
  DecimalPoint& operator=(const DecimalPoint&) = delete;

 private:
  static locale_t classic() {
    static const locale_t kClassic = newlocale(LC_ALL_MASK, "C", nullptr);
    return kClassic;
  }

  locale_t before_;
};

}  // namespace gnosphere
