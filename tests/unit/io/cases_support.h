#pragma once
/// Scenes whose image is one reflectance: a quad, or what stands in for it, under a white sky, seen from z =
/// 2 with at most two edges of a path.

#include "support.h"
#include "support/scene_rendering.h"

#include <array>

namespace metrolux::core::test {

inline const std::string kQuadFile =
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1\n";

/// `body`: what is seen; `film`: more properties of the film. Names of 3.x, which 0.x reads too.
inline std::string underSky(const std::string& body, const std::string& version = "3.0.0", float distance = 2,
                            const std::string& film = R"(<rfilter type="box"/>)",
                            const std::string& filmType = "hdrfilm") {
    return scene(fmt::format(R"(<integrator type="path"><integer name="{}" value="2"/></integrator>
<sensor type="perspective"><float name="fov" value="20"/>
<transform name="{}"><lookat origin="0,0,{}" target="0,0,0" up="0,1,0"/></transform>
<film type="{}"><integer name="width" value="16"/><integer name="height" value="12"/>{}</film></sensor>
<emitter type="constant"><rgb name="radiance" value="1"/></emitter>
{})",
                             version[0] == '0' ? "maxDepth" : "max_depth",
                             version[0] == '0' ? "toWorld" : "to_world", distance, filmType, film, body),
                 version);
}

inline std::string quad(const std::string& bsdf, const std::string& transform = "") {
    return "<shape type=\"rectangle\">" + transform + bsdf + "</shape>";
}
inline std::string diffuse(const std::string& reflectance, const std::string& attributes = "") {
    return "<bsdf type=\"diffuse\" " + attributes + ">" + reflectance + "</bsdf>";
}
inline const std::string kHalf = diffuse(R"(<rgb name="reflectance" value="0.5"/>)");

/// Means over the columns [from, to) of the 16.
inline Rgb meanOf(const std::vector<float>& image, int from = 0, int to = 16) {
    std::array<double, 3> sum{};
    for (size_t i = 0; i < image.size(); ++i) {
        const int column = static_cast<int>(i / 3 % 16);
        if (column >= from && column < to) sum[i % 3] += image[i];
    }
    const double count = 12.0 * (to - from);
    return {static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count),
            static_cast<float>(sum[2] / count)};
}

inline std::vector<float> render(const std::filesystem::path& file, const LoadOptions& options = {}) {
    return RenderableScene(file, options).render("path", 200, 1);
}

/// Two in a hundred are more than five standard errors of these images.
inline void expectColor(const Rgb& color, const Rgb& expected) {
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(color[k], expected[k], 0.02f * expected[k] + 1e-5f) << "channel " << k;
}
inline void expectGray(const Rgb& color, float expected) { expectColor(color, Rgb(expected)); }

}  // namespace metrolux::core::test
