#include "render/build_id.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <gnu/libc-version.h>
#include <string>

namespace metrolux::core {

#if defined(__clang__)
const char* const kCompiler = __VERSION__;  // names itself
#else
const char* const kCompiler = "GCC " __VERSION__;
#endif
const char* const kBuildFlags = METROLUX_FLAGS;

namespace {

/// Those that change how sums are rounded or in which order they are made.
std::string instructions() {
    std::string names = sizeof(void*) == 8 ? "64 bit" : "32 bit";
#ifdef __aarch64__
    names += " arm";
#endif
#ifdef __SSE4_1__
    names += " sse4.1";
#endif
#ifdef __AVX__
    names += " avx";
#endif
#ifdef __AVX2__
    names += " avx2";
#endif
#ifdef __FMA__
    names += " fma";
#endif
#ifdef __AVX512F__
    names += " avx512";
#endif
    return names;
}

}  // namespace

nlohmann::json buildIdentity(const Intersector& intersector) {
    return {{"compiler", kCompiler},
            {"flags", kBuildFlags},
            {"instructions", instructions()},
            {"libraries",
             fmt::format("Embree {}, glibc {}", Intersector::libraryVersion(), ::gnu_get_libc_version())},
            {"rays_in_a_packet", intersector.packetWidth()}};
}

}  // namespace metrolux::core
