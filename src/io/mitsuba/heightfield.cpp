#include "io/mitsuba/heightfield.h"

#include "image/image_io.h"
#include "io/mesh_io.h"

namespace metrolux::core::mitsuba {
namespace {

constexpr int64_t kMostSamples = 16384;  // along one side

struct Heights {
    int width = 0, height = 0;
    std::vector<float> values;  ///< row by row
};

void requireGrid(const Element& element, int64_t width, int64_t height) {
    if (width < 2 || height < 2 || width > kMostSamples || height > kMostSamples)
        throw element.error(fmt::format("found {} x {} heights, expected 2 to {} in each direction", width,
                                        height, kMostSamples));
}

Heights fromImage(const Element& element, LoadContext& context) {
    const ImageData image =
        readImage(context.resolve(element, element.requiredString("filename")), false, &context.memory);
    requireGrid(element, image.width, image.height);
    Heights result{image.width, image.height, {}};
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const float* v = image.at(x, y);
            result.values.push_back(image.channels >= 3 ? luminance({v[0], v[1], v[2]}) : v[0]);
        }
    return result;
}

Heights fromTexture(const Element& element, const Element& nested, LoadContext& context) {
    const TexturePtr texture = makeTexture(nested, context);
    const Vec2i own = texture->resolution();
    const int64_t width = element.integer("width", std::max(own.x, 2)),
                  height = element.integer("height", std::max(own.y, 2));
    requireGrid(element, width, height);
    Heights result{static_cast<int>(width), static_cast<int>(height), {}};
    SurfaceInteraction si;
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x) {
            si.uv = {(static_cast<float>(x) + 0.5f) / static_cast<float>(result.width),
                     (static_cast<float>(y) + 0.5f) / static_cast<float>(result.height)};
            result.values.push_back(texture->scalar(si));
        }
    return result;
}

}  // namespace

ShapePtr makeHeightfield(const Element& element, LoadContext& context) {
    const auto nested = element.childrenOf("texture");
    if (nested.size() > 1 || nested.empty() != element.has("filename"))
        throw element.error("expected either a \"filename\" or one nested <texture>");
    const Heights heights =
        nested.empty() ? fromImage(element, context) : fromTexture(element, *nested[0], context);
    const float scale = element.number("scale", 1);

    MeshOptions options;
    options.memory = &context.memory;
    options.toWorld = context.toWorld(element, true);
    options.flipNormals = element.boolean("flip_normals", false);
    options.faceNormals = !element.boolean("shading_normals", true);
    requireMemory(element.location.file, options, heights.values.size(), 128, "the heightfield");

    const auto mesh = std::make_shared<TriangleMesh>();
    const auto w = static_cast<uint32_t>(heights.width), h = static_cast<uint32_t>(heights.height);
    for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x) {
            const Vec2f uv(static_cast<float>(x) / static_cast<float>(w - 1),
                           static_cast<float>(y) / static_cast<float>(h - 1));
            mesh->uvs.push_back(uv);
            mesh->positions.emplace_back(2 * uv.x - 1, 2 * uv.y - 1,
                                         scale * heights.values[size_t(y) * w + x]);
            if (x + 1 == w || y + 1 == h) continue;
            const uint32_t v = y * w + x;
            mesh->indices.insert(mesh->indices.end(), {v, v + 1, v + w + 1, v, v + w + 1, v + w});
        }
    finishMesh(*mesh, element.type, options);
    return mesh;
}

}  // namespace metrolux::core::mitsuba
