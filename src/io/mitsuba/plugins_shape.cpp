/// Shapes: Mitsuba 3's plugins, parameters and defaults.

#include "geometry/affine.h"
#include "io/mesh_io.h"
#include "io/mitsuba/context.h"
#include "scattering/diffuse.h"
#include "scattering/textures/constant.h"

#include <algorithm>

namespace metrolux::core::mitsuba {

namespace {

using MakeShape = ShapePtr (*)(const Element&, LoadContext&);

MeshOptions meshOptions(const Element& element, LoadContext& context, bool flipTexCoords) {
    // Mitsuba 0.x could split vertices at sharp edges; with another angle the picture would differ.
    if (element.has("max_smooth_angle"))
        throw element.error(
            *element.find("max_smooth_angle"),
            "max_smooth_angle is not supported; use face_normals, or store normals in the mesh");
    MeshOptions options;
    options.memory = &context.memory;
    options.toWorld = element.transform("to_world");
    options.flipNormals = element.boolean("flip_normals", false);
    options.faceNormals = element.boolean("face_normals", false);
    options.flipTexCoords = element.boolean("flip_tex_coords", flipTexCoords);
    return options;
}

std::filesystem::path meshFile(const Element& element, LoadContext& context) {
    return context.resolve(element, element.requiredString("filename"));
}

struct Placement {
    Transform toWorld;
    bool flipNormals;
    explicit Placement(const Element& element)
        : toWorld(element.transform("to_world")), flipNormals(element.boolean("flip_normals", false)) {}
};

ShapePtr makeObjShape(const Element& element, LoadContext& context) {
    return readObj(meshFile(element, context), meshOptions(element, context, true));
}

ShapePtr makePlyShape(const Element& element, LoadContext& context) {
    return readPly(meshFile(element, context), meshOptions(element, context, false));
}

ShapePtr makeSerializedShape(const Element& element, LoadContext& context) {
    const int64_t index = element.integer("shape_index", 0);
    if (index < 0 || index > std::numeric_limits<int>::max())
        throw element.error(fmt::format("shape_index is {}, expected 0 or more", index));
    return readSerialized(meshFile(element, context), static_cast<int>(index),
                          meshOptions(element, context, false));
}

ShapePtr makeSphereShape(const Element& element, LoadContext&) {
    const Placement placement(element);
    return makeSphere(placement.toWorld, element.vector("center", Vec3f(0.0f)),
                      element.number("radius", 1.0f), placement.flipNormals);
}

ShapePtr makeCylinderShape(const Element& element, LoadContext&) {
    const Placement placement(element);
    return makeCylinder(placement.toWorld, element.vector("p0", Vec3f(0, 0, 0)),
                        element.vector("p1", Vec3f(0, 0, 1)), element.number("radius", 1.0f),
                        placement.flipNormals);
}

/// Shapes that a placement describes completely.
template <ShapePtr (*Make)(const Transform&, bool)>
ShapePtr makePlaced(const Element& element, LoadContext&) {
    const Placement placement(element);
    return Make(placement.toWorld, placement.flipNormals);
}

struct Plugin {
    const char* type;
    MakeShape make;
};
constexpr Plugin kPlugins[] = {
    {"obj", makeObjShape},          {"ply", makePlyShape},           {"serialized", makeSerializedShape},
    {"sphere", makeSphereShape},    {"cylinder", makeCylinderShape}, {"rectangle", makePlaced<makeRectangle>},
    {"disk", makePlaced<makeDisk>}, {"cube", makePlaced<makeCube>},
};
constexpr const char* kGroup = "shapegroup";
constexpr const char* kInstance = "instance";
/// Allowances for an object, its light, and its part of the ray tracing structure.
constexpr uint64_t kShapeBytes = 2048, kInstanceBytes = 1024;

/// The only child with a tag, or null.
ElementPtr onlyChild(const Element& element, const char* tag) {
    const auto children = element.childrenOf(tag);
    if (children.size() > 1)
        throw element.error(
            fmt::format("found {} children <{}>, expected one at most", children.size(), tag));
    return children.empty() ? nullptr : children.front();
}

/// Lets errors of geometry/ and of the mesh readers name the element.
template <class Make>
auto withLocation(const Element& element, Make&& make) {
    try {
        return make();
    } catch (const Error& error) {
        const std::string message = error.what();
        if (message.starts_with(element.location.str())) throw;
        throw element.error(message);
    }
}

void attachBsdf(const Element& element, LoadContext& context, Shape& shape, bool emits) {
    if (const ElementPtr bsdf = onlyChild(element, "bsdf")) {
        shape.bsdf = makeBsdf(*bsdf, context);
        return;
    }
    // As in Mitsuba, a light without a BSDF does not reflect.
    shape.bsdf = makeDiffuse({makeConstantTexture(Rgb(emits ? 0.0f : 0.5f))});
}

/// The shape of a plain plugin with its material and its light; null if the type is unknown and that is let
/// pass.
ShapePtr makeShape(const Element& element, LoadContext& context, std::vector<LightPtr>& lights) {
    const auto* plugin = std::find_if(std::begin(kPlugins), std::end(kPlugins),
                                      [&](const Plugin& p) { return element.type == p.type; });
    if (plugin == std::end(kPlugins)) {
        std::vector<std::string> names = {kGroup, kInstance};
        for (const Plugin& p : kPlugins) names.emplace_back(p.type);
        const std::string nearest = nearestName(element.type, names);
        const std::string message = fmt::format(
            "unknown shape type{}", nearest.empty() ? "" : fmt::format(", did you mean \"{}\"?", nearest));
        if (!context.lenient) throw element.error(message);
        context.warn(element, fmt::format("{} (\"{}\"); the shape is left out", message, element.type));
        return nullptr;
    }
    if (!element.childrenOf("medium").empty())
        throw element.error("participating media (interior, exterior) are not supported");

    ShapePtr shape = withLocation(element, [&] {
        context.memory.take(kShapeBytes, "the shape");
        return plugin->make(element, context);
    });
    shape->id =
        element.id.empty() ? fmt::format("{} at {}", element.type, element.location.str()) : element.id;
    const ElementPtr emitter = onlyChild(element, "emitter");
    attachBsdf(element, context, *shape, emitter != nullptr);
    if (emitter) {
        if (!(shape->area() > 0) || !std::isfinite(shape->area()))
            throw element.error(fmt::format("an emitter needs a finite area > 0, found {}", shape->area()));
        LightPtr light = makeAreaLight(*emitter, *shape, context);
        shape->emitter = light;
        lights.push_back(std::move(light));
    }
    element.checkAllUsed(context.lenient, context.warnings);
    return shape;
}

std::shared_ptr<const ShapeGroup> makeGroup(const Element& element, LoadContext& context) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const ShapeGroup>(found->second);
    auto group = std::make_shared<ShapeGroup>();
    for (const ElementPtr& child : element.childrenOf("shape")) {
        if (child->type == kGroup || child->type == kInstance)
            throw child->error(fmt::format("a shapegroup cannot contain a {}", child->type));
        if (!child->childrenOf("emitter").empty())
            throw child->error(
                "shapes of a shapegroup cannot be emitters: each instance would be a light of its own");
        std::vector<LightPtr> none;
        if (ShapePtr shape = makeShape(*child, context, none)) group->shapes.push_back(std::move(shape));
    }
    if (group->shapes.empty()) throw element.error("a shapegroup without shapes");
    element.checkAllUsed(context.lenient, context.warnings);
    context.built[&element] = group;
    return group;
}

void addInstance(const Element& element, LoadContext& context, SceneParts& parts) {
    const ElementPtr child = onlyChild(element, "shape");
    if (!child || child->type != kGroup)
        throw element.error("an instance needs one reference to a shapegroup");
    if (!element.childrenOf("emitter").empty()) throw element.error("an instance cannot be an emitter");
    if (!element.childrenOf("bsdf").empty())
        throw element.error("an instance has the materials of its shapegroup, and none of its own");
    const Transform toWorld = element.transform("to_world");
    withLocation(element, [&] {
        context.memory.take(kInstanceBytes, "the instance");
        const Affine checked(toWorld);
    });
    parts.instances.push_back({makeGroup(*child, context), toWorld});
    element.checkAllUsed(context.lenient, context.warnings);
}

}  // namespace

void addShape(const Element& element, LoadContext& context, SceneParts& parts) {
    if (element.type == kGroup)
        makeGroup(element, context);
    else if (element.type == kInstance)
        addInstance(element, context, parts);
    else if (ShapePtr shape = makeShape(element, context, parts.lights))
        parts.shapes.push_back(std::move(shape));
}

}  // namespace metrolux::core::mitsuba
