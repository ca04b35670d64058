// SPDX-License-Identifier: Apache-2.0
// Links the examples of docs/api.md with the library as users have it: a shared one exports only what the public
// headers mark, while the archive that the tests link has everything.
#include "api_example.hpp"

int main() {
  return fieldInfo(Field::normal).components == 3 && Scan().has(Field::range) ? 0 : 1;
}
