#include "geometry/affine.h"
#include "geometry/shape.h"

#include <array>

namespace metrolux::core {

namespace {

/// A mesh of quads, each given by four corners in order around its outside; `uvs` are those of one quad.
ShapePtr makeQuads(const Transform& toWorld, bool flipNormals, const std::vector<Vec3f>& corners,
                   const std::array<Vec2f, 4>& uvs) {
    const Affine map(toWorld);
    auto mesh = std::make_shared<TriangleMesh>();
    // A map that mirrors would turn the winding inside out; normals follow the inverse transpose instead.
    const bool mirrored = toWorld.determinant3() < 0;
    for (size_t i = 0; i < corners.size(); ++i) {
        mesh->positions.push_back(toFloat(map.point(toDouble(corners[i]))));
        mesh->uvs.push_back(uvs[i % 4]);
    }
    for (uint32_t base = 0; base < corners.size(); base += 4)
        for (const std::array<uint32_t, 3>& t : {std::array<uint32_t, 3>{0, 1, 2}, {2, 3, 0}}) {
            mesh->indices.push_back(base + t[0]);
            mesh->indices.push_back(base + (mirrored ? t[2] : t[1]));
            mesh->indices.push_back(base + (mirrored ? t[1] : t[2]));
        }
    mesh->flipNormals = flipNormals;
    mesh->finalize();
    return mesh;
}

}  // namespace

ShapePtr makeRectangle(const Transform& toWorld, bool flipNormals) {
    return makeQuads(toWorld, flipNormals, {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                     {Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, 1), Vec2f(0, 1)});
}

ShapePtr makeCube(const Transform& toWorld, bool flipNormals) {
    // Corner order and uv are Mitsuba's, so that textures lie the same way.
    const std::vector<Vec3f> corners = {
        {1, -1, -1}, {1, -1, 1},  {-1, -1, 1},  {-1, -1, -1},  // -y
        {1, 1, -1},  {-1, 1, -1}, {-1, 1, 1},   {1, 1, 1},     // +y
        {1, -1, -1}, {1, 1, -1},  {1, 1, 1},    {1, -1, 1},    // +x
        {1, -1, 1},  {1, 1, 1},   {-1, 1, 1},   {-1, -1, 1},   // +z
        {-1, -1, 1}, {-1, 1, 1},  {-1, 1, -1},  {-1, -1, -1},  // -x
        {1, 1, -1},  {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1},   // -z
    };
    return makeQuads(toWorld, flipNormals, corners, {Vec2f(0, 1), Vec2f(1, 1), Vec2f(1, 0), Vec2f(0, 0)});
}

}  // namespace metrolux::core
