// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks a symbol that the shared library exports. Everything else is compiled with hidden visibility.
#define GNOSPHERE_API __attribute__((visibility("default")))
