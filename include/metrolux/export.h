#pragma once

/// What a program that links the shared library may use; everything else in it is hidden.
#if defined(__GNUC__)
#define METROLUX_API __attribute__((visibility("default")))
#else
#define METROLUX_API
#endif
