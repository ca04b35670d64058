// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks a symbol that the shared library exports. Everything else is compiled with hidden visibility. On Windows only
/// the library itself says so: the API has no variables, which programs would have to import.
#ifndef _WIN32
#define GNOSPHERE_API __attribute__((visibility("default")))
#elif defined(GNOSPHERE_EXPORTS)
#define GNOSPHERE_API __declspec(dllexport)
#else
#define GNOSPHERE_API
#endif
