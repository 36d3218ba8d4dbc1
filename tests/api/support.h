#pragma once
#include <metrolux/metrolux.h>

#include <cstring>
#include <fstream>
#include <string>

namespace metrolux::core::test {

/// A lamp over a glass ball on a floor, in words of a scene file and in objects of code.
inline const char* const kBallXml = R"(<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, 2, 6" target="0, 0.5, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/>
            <rfilter type="tent"/></film>
    </sensor>
    <bsdf type="diffuse" id="gray"><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf>
    <shape type="ply"><string name="filename" value="floor.ply"/>
        <transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
        <ref id="gray"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0.7" z="0"/><float name="radius" value="0.7"/>
        <bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf></shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate y="4"/></transform>
        <emitter type="area"><rgb name="radiance" value="10, 9, 8"/></emitter></shape>
    <emitter type="constant"><rgb name="radiance" value="0.1, 0.1, 0.2"/></emitter>
</scene>)";

inline const char* const kFloorPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n3 0 1 2\n3 0 2 3\n";

inline Object ball() {
    Mesh floor;
    floor.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    floor.triangles = {0, 1, 2, 0, 2, 3};
    const Object film("hdrfilm", {{"width", 24}, {"height", 16}, {"filter", Object("tent")}});
    return Object(
        "scene",
        {{"integrator", Object("path", {{"max_depth", 6}})},
         {"camera",
          Object("perspective", {{"fov", 40.0},
                                 {"to_world", metrolux::Transform::lookAt({0, 2, 6}, {0, 0.5, 0}, {0, 1, 0})},
                                 {"film", film}})},
         {"gray", Object("diffuse", {{"reflectance", Color{0.5, 0.4, 0.3}}})},
         {"floor", Object("mesh", {{"arrays", floor},
                                   {"to_world", metrolux::Transform::rotate({1, 0, 0}, -90) *
                                                    metrolux::Transform::scale({3, 3, 3})},
                                   {"bsdf", Reference{"gray"}}})},
         {"ball", Object("sphere", {{"center", Vector{0, 0.7, 0}},
                                    {"radius", 0.7},
                                    {"glass", Object("dielectric", {{"int_ior", 1.5}})}})},
         {"lamp", Object("rectangle", {{"to_world", metrolux::Transform::translate({0, 4, 0}) *
                                                        metrolux::Transform::rotate({1, 0, 0}, 90) *
                                                        metrolux::Transform::scale({0.5, 0.5, 0.5})},
                                       {"light", Object("area", {{"radiance", Color{10, 9, 8}}})}})},
         {"sky", Object("constant", {{"radiance", Color{0.1, 0.1, 0.2}}})}});
}

inline std::string errorOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const metrolux::Error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

inline std::vector<float> pixels(const ImageView& view) { return {view.data, view.data + view.size()}; }

inline std::vector<float> rendered(const metrolux::Scene& scene, const metrolux::SessionOptions& options,
                                   int passes) {
    metrolux::Session session(scene, options);
    for (int i = 0; i < passes; ++i) session.step();
    return pixels(session.image());
}

}  // namespace metrolux::core::test
