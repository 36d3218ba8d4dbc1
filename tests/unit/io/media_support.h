#pragma once
/// Media of scenes of a few lines, before anything is rendered.

#include "cases_support.h"
#include "media/medium.h"

#include <array>
#include <cstring>

namespace metrolux::core::test {

/// A scene with a camera, a light and `body`, which begins in line 4.
inline std::string withMedia(const std::string& body, const std::string& version = "3.0.0") {
    return "<scene version=\"" + version + R"("><sensor type="perspective"><film type="hdrfilm"/></sensor>
<emitter type="constant"/>

)" + body + "\n</scene>\n";
}

inline SceneParts partsOf(const std::string& text, const LoadOptions& options = {},
                          const std::string& name = "scene.xml") {
    const TemporaryFolder folder;
    return loadScene(folder.write(name, text), options);
}

/// A file of Mitsuba's grids: channels of floats, or of what `encoding` says.
inline std::string volFile(std::array<int, 3> resolution, const std::vector<float>& values, int channels = 1,
                           std::array<float, 6> box = {0, 0, 0, 1, 1, 1}, int encoding = 1) {
    std::string bytes("VOL\3", 4);
    const auto add = [&](const auto& value) {
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    add(encoding);
    for (const int n : resolution) add(n);
    add(channels);
    for (const float bound : box) add(bound);
    for (const float value : values) add(value);
    return bytes;
}

inline void expectNear(const Rgb& value, const Rgb& expected, float relative = 1e-5f) {
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(value[c], expected[c], relative * (1 + std::abs(expected[c]))) << "channel " << c;
}
inline void expectMedium(const Medium& medium, const Rgb& extinction, const Rgb& albedo,
                         const Vec3f& p = Vec3f(0.0f)) {
    expectNear(medium.extinction(p), extinction);
    expectNear(medium.scattering(p), extinction * albedo);
}

}  // namespace metrolux::core::test
