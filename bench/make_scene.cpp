// Writes scenes of any size: bench_scene triangles 1000000 FOLDER, bench_scene lights 10000 FOLDER.
#include "base/rng.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFrame = R"(<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="6"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="45"/>
    <transform name="to_world"><lookat origin="0, 3, 7" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="256"/><integer name="height" value="256"/></film>
  </sensor>
{}</scene>
)";

void write(const fs::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    out << text;
    if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

template <class T>
void append(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

constexpr uint32_t kHillCells = 24;

/// Height of a vertex of n x n squares over kHillCells x kHillCells cells of two flat triangles each.
double hillHeight(uint32_t x, uint32_t z, uint32_t n) {
    const auto corner = [](uint32_t i, uint32_t k) {
        const double u = 8.0 * i / kHillCells - 4, v = 8.0 * k / kHillCells - 4;
        return 0.4 * std::sin(3 * u) * std::cos(2 * v) + 0.1 * std::sin(11 * u * v);
    };
    const uint32_t parts = n / kHillCells;
    const uint32_t i = std::min(x / parts, kHillCells - 1), k = std::min(z / parts, kHillCells - 1);
    const double fx = double(x) / parts - i, fz = double(z) / parts - k;
    const double x1 = corner(i + 1, k), z1 = corner(i, k + 1);
    if (fx + fz <= 1) {
        const double origin = corner(i, k);
        return origin + fx * (x1 - origin) + fz * (z1 - origin);
    }
    const double end = corner(i + 1, k + 1);
    return end + (1 - fx) * (z1 - end) + (1 - fz) * (x1 - end);
}

/// A hilly square of at least `triangles` triangles, in binary PLY. The surface is the same for any number:
/// light takes the same paths, and what changes is the number alone.
void writeHills(const fs::path& file, uint64_t triangles) {
    const uint32_t n =
        kHillCells * static_cast<uint32_t>(std::ceil(std::sqrt(double(triangles) / 2) / kHillCells));
    std::string bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
        "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        uint64_t(n + 1) * (n + 1), uint64_t{2} * n * n);
    bytes.reserve(bytes.size() + 38 * uint64_t(n) * n + 24 * n + 64);
    for (uint32_t z = 0; z <= n; ++z)
        for (uint32_t x = 0; x <= n; ++x) {
            const double u = 8.0 * x / n - 4, v = 8.0 * z / n - 4;
            append(bytes, static_cast<float>(u));
            append(bytes, static_cast<float>(hillHeight(x, z, n)));
            append(bytes, static_cast<float>(v));
        }
    for (uint32_t z = 0; z < n; ++z)
        for (uint32_t x = 0; x < n; ++x) {
            const uint32_t a = z * (n + 1) + x, b = a + n + 1;
            for (const auto& t :
                 {std::array<uint32_t, 3>{a, b, a + 1}, std::array<uint32_t, 3>{a + 1, b, b + 1}}) {
                append(bytes, uint8_t{3});
                for (const uint32_t index : t) append(bytes, index);
            }
        }
    write(file, bytes);
}

void triangleScene(uint64_t triangles, const fs::path& folder) {
    writeHills(folder / "hills.ply", triangles);
    write(folder / "scene.xml", fmt::format(kFrame, R"(  <shape type="ply">
    <string name="filename" value="hills.ply"/><boolean name="face_normals" value="true"/>
    <bsdf type="diffuse"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world">
      <rotate x="1" angle="90"/><translate x="0" y="5" z="0"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="10"/></emitter>
  </shape>
)"));
}

/// A wide floor with posts under many small lamps, of powers that spread over a factor of a hundred: a pixel
/// is lit by few of them.
void lightScene(uint64_t lights, const fs::path& folder) {
    constexpr double kExtent = 60, kHeight = 0.6;
    std::string parts = fmt::format(R"(  <shape type="rectangle">
    <transform name="to_world"><scale value="{}"/><rotate x="1" angle="-90"/></transform><bsdf type="diffuse"/>
  </shape>
)",
                                    kExtent);
    CounterRng rng(hashKey(1));
    for (uint64_t i = 0; i < lights; ++i) {
        // The same flux over the floor whatever their number, in an even pattern about the camera's view.
        const double x = lights == 1 ? 0 : kExtent * (2 * rng.nextDouble() - 1);
        const double z = lights == 1 ? 0 : kExtent * (2 * rng.nextDouble() - 1);
        const double radiance = 2e5 / double(lights) * std::pow(100, rng.nextDouble() - 0.5);
        parts += fmt::format(R"(  <shape type="rectangle">
    <transform name="to_world"><scale value="0.02"/><rotate x="1" angle="90"/><translate x="{}" y="{}" z="{}"/></transform>
    <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="{}"/></emitter>
  </shape>
)",
                             x, kHeight, z, radiance);
    }
    write(folder / "scene.xml", fmt::format(kFrame, parts));
}

int run(int argc, char** argv) {
    uint64_t count = 0;
    const std::string kind = argc == 4 ? argv[1] : "";
    if (kind == "triangles" || kind == "lights") {
        const auto [end, code] = std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), count);
        if (code != std::errc() || *end != 0) count = 0;
    }
    if (count == 0 || count > (uint64_t{1} << 30)) {
        fmt::print(stderr, "usage: bench_scene triangles|lights COUNT FOLDER   (COUNT from 1 to 2^30)\n");
        return 2;
    }
    const fs::path folder = argv[3];
    fs::create_directories(folder);
    kind == "lights" ? lightScene(count, folder) : triangleScene(count, folder);
    return 0;
}

}  // namespace
}  // namespace metrolux::core

int main(int argc, char** argv) {
    try {
        return metrolux::core::run(argc, argv);
    } catch (const std::exception& error) {
        fmt::print(stderr, "bench_scene: {}\n", error.what());
        return 1;
    }
}
