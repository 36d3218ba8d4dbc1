/// Shapes: Mitsuba 3's plugins, parameters and defaults.

#include "geometry/affine.h"
#include "io/mesh_arrays.h"
#include "io/mitsuba/context.h"
#include "io/mitsuba/curves.h"
#include "io/mitsuba/distance_shape.h"
#include "io/mitsuba/heightfield.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/mesh_attributes.h"
#include "io/mitsuba/round_shapes.h"
#include "io/mitsuba/subsurface.h"
#include "io/mitsuba/unknown_plugins.h"
#include "io/mitsuba/world_origin.h"
#include "scattering/diffuse.h"
#include "scattering/null_bsdf.h"
#include "scattering/textures/constant.h"

#include <algorithm>

namespace metrolux::core::mitsuba {

namespace {

using MakeShape = ShapePtr (*)(const Element&, LoadContext&);

MeshOptions meshOptions(const Element& element, LoadContext& context, bool flipTexCoords) {
    MeshOptions options;
    options.memory = &context.memory;
    options.toWorld = context.toWorld(element, true);
    options.exact = context.origin != Vec3d(0.0);
    options.flipNormals = element.boolean("flip_normals", false);
    options.faceNormals = element.boolean("face_normals", false);
    if (element.version == 2 && element.has("disable_vertex_normals"))  // of 2.0
        options.faceNormals = element.boolean("disable_vertex_normals", false);
    options.flipTexCoords = element.boolean("flip_tex_coords", flipTexCoords);
    if (element.isLegacy() && element.has("max_smooth_angle")) {
        if (options.faceNormals)
            throw element.error(
                "found \"max_smooth_angle\" as well as \"face_normals\", expected one of them");
        options.maxSmoothAngle = element.number("max_smooth_angle", 0);
    }
    return options;
}

/// Reads a mesh with `read(file, options)`; its warnings get the element's place.
template <class Read>
auto readMesh(const Element& element, LoadContext& context, bool flipTexCoords, Read&& read) {
    std::vector<std::string> warnings;
    MeshOptions options = meshOptions(element, context, flipTexCoords);
    options.warnings = &warnings;
    auto result = read(context.resolve(element, element.requiredString("filename")), options);
    for (const std::string& warning : warnings) context.warn(element, warning);
    return result;
}

struct Placement {
    Transform toWorld;
    bool flipNormals;
    Placement(const Element& element, const LoadContext& context, bool mayFlatten = false)
        : toWorld(context.toWorld(element, mayFlatten)),
          flipNormals(element.boolean("flip_normals", false)) {}
};

ShapePtr makeObjShape(const Element& element, LoadContext& context) {
    return readMesh(element, context, true, readObj);
}

ShapePtr makePlyShape(const Element& element, LoadContext& context) {
    return readMesh(element, context, false, readPly);
}

ShapePtr makeSerializedShape(const Element& element, LoadContext& context) {
    const int64_t index = element.integer("shape_index", 0);
    if (index < 0 || index > std::numeric_limits<int>::max())
        throw element.error(fmt::format("shape_index is {}, expected 0 or more", index));
    return readMesh(element, context, false,
                    [&](const std::filesystem::path& file, const MeshOptions& options) {
                        return readSerialized(file, static_cast<int>(index), options);
                    });
}

/// Of a program: the arrays go the way of a file's.
ShapePtr makeMeshShape(const Element& element, LoadContext& context) {
    return meshOfArrays(element.requiredArrays("arrays"), meshOptions(element, context, false));
}

/// Shapes that a placement describes completely.
template <ShapePtr (*Make)(const Transform&, bool)>
ShapePtr makePlaced(const Element& element, LoadContext& context) {
    const Placement placement(element, context, true);
    return Make(placement.toWorld, placement.flipNormals);
}

struct ShapePlugin {
    const char* type;
    MakeShape make;
};
constexpr ShapePlugin kShapePlugins[] = {
    {"obj", makeObjShape},
    {"ply", makePlyShape},
    {"serialized", makeSerializedShape},
    {"sphere", makeSphereShape},
    {"cylinder", makeCylinderShape},
    {"rectangle", makePlaced<makeRectangle>},
    {"disk", makePlaced<makeDisk>},
    {"cube", makePlaced<makeCube>},
    {"heightfield", makeHeightfield},
    {"mesh", makeMeshShape},
    {"bsplinecurve", makeBSplineCurve},
    {"linearcurve", makeLinearCurve},
    {"hair", makeHair},
    {"sdfgrid", makeDistanceShape},
};
constexpr const char* kGroup = "shapegroup";
constexpr const char* kInstance = "instance";
constexpr const char* kMerge = "merge";  // 3.x: its shapes, which may share a mesh
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

/// Of several BSDFs the last one holds in 0.6.
ElementPtr bsdfOf(const Element& element, LoadContext& context) {
    if (!element.isLegacy()) return onlyChild(element, "bsdf");
    const auto children = element.childrenOf("bsdf");
    if (children.size() > 1)
        context.warn(element, fmt::format("found {} children <bsdf>: the last one holds", children.size()));
    return children.empty() ? nullptr : children.back();
}

/// A shape and the element of its BSDF, null for none.
struct ShapePart {
    ShapePtr shape;
    ElementPtr bsdf;
};

/// 0.6: of an OBJ the BSDFs with a name are for the faces under that name of a material (usemtl), those
/// without for all; the last one holds.
std::vector<ShapePart> objByMaterial(const Element& element, const std::vector<NamedChild>& bsdfs,
                                     LoadContext& context) {
    const auto parts = readMesh(element, context, true, readObjByMaterial);
    const auto isUsed = [&](const std::string& name) {
        return name.empty() || std::any_of(parts.begin(), parts.end(),
                                           [&](const MaterialPart& p) { return p.material == name; });
    };
    // The name of an only BSDF is often "bsdf", and means nothing.
    if (bsdfs.size() == 1 && !isUsed(bsdfs[0].name))
        return {{makeObjShape(element, context), bsdfs[0].element}};
    std::vector<ShapePart> result;
    for (const MaterialPart& part : parts) {
        ShapePart& made = result.emplace_back(ShapePart{part.mesh, nullptr});
        for (const NamedChild& bsdf : bsdfs)
            if (bsdf.name.empty() || bsdf.name == part.material) made.bsdf = bsdf.element;
    }
    for (const NamedChild& bsdf : bsdfs)
        if (!isUsed(bsdf.name))
            context.warn(element,
                         fmt::format("no face of the file has the material \"{}\" (usemtl): the BSDF of "
                                     "this name has no effect",
                                     bsdf.name));
    return result;
}

/// The shapes that the plugin makes of an element: one, but for an OBJ whose materials have BSDFs.
std::vector<ShapePart> makeParts(const Element& element, const ShapePlugin& plugin, LoadContext& context) {
    if (element.isLegacy() && element.type == "obj") {
        const std::vector<NamedChild> bsdfs = element.namedChildrenOf("bsdf");
        const auto hasName = [](const NamedChild& bsdf) { return !bsdf.name.empty(); };
        if (std::any_of(bsdfs.begin(), bsdfs.end(), hasName)) return objByMaterial(element, bsdfs, context);
    }
    return {{plugin.make(element, context), bsdfOf(element, context)}};
}

const ShapePlugin* findPlugin(const Element& element, LoadContext& context) {
    const auto* plugin = std::find_if(std::begin(kShapePlugins), std::end(kShapePlugins),
                                      [&](const ShapePlugin& p) { return element.type == p.type; });
    if (plugin != std::end(kShapePlugins)) return plugin;
    const std::string message = unknownPlugin(element, "shape", shapeTypes());
    if (!context.lenient) throw element.error(message);
    context.warn(element, message + " (the shape is left out)");
    return nullptr;
}

/// Whether the map leaves a line or a point, which has no normal in any direction.
bool leavesNoArea(const Transform& map) {
    const auto isLost = [&](const Vec3f& n) { return map.normal(n) == Vec3f(0.0f); };
    return map.isSingular() && isLost({1, 0, 0}) && isLost({0, 1, 0}) && isLost({0, 0, 1});
}

LightPtr attachLight(const Element& element, const Element& emitter, Shape& shape, LoadContext& context) {
    if (!(shape.area() > 0) || !std::isfinite(shape.area()))
        throw element.error(fmt::format("an emitter needs a finite area > 0, found {}", shape.area()));
    return makeAreaLight(emitter, shape, context);
}

/// As in Mitsuba, a light without a BSDF does not reflect, and in 0.6 other boundaries of media have null.
BsdfPtr usualBsdf(const Element& element, const std::optional<MediumSides>& media, const ElementPtr& emitter,
                  LoadContext& context) {
    if (media && !emitter && element.isLegacy()) return makeNullBsdf();
    if (media && !emitter)
        context.warn(element, "bounds a medium and has no BSDF: it is a diffuse surface, as in Mitsuba 3");
    return makeDiffuse({makeConstantTexture(Rgb(emitter ? 0.0f : 0.5f))});
}

std::string shownName(const Element& element) {
    return element.id.empty() ? fmt::format("{} at {}", element.type, element.location.str()) : element.id;
}

/// The shapes of a plain plugin with their materials and lights; none if the type is unknown and that is let
/// pass.
std::vector<ShapePtr> makeShapes(const Element& element, LoadContext& context,
                                 std::vector<LightPtr>& lights) {
    const ShapePlugin* plugin = findPlugin(element, context);
    if (!plugin) return {};
    if (!element.isLegacy()) element.ignore("silhouette_sampling_weight");  // of derivatives
    if (leavesNoArea(element.transform("to_world", true))) {
        context.warn(element, "\"to_world\" flattens the shape to a line or a point: it is left out");
        return {};
    }
    std::optional<MediumSides> media = mediumSidesOf(element, context);

    const std::vector<ShapePart> parts = withLocation(element, [&] {
        context.memory.take(kShapeBytes, "the shape");
        return makeParts(element, *plugin, context);
    });
    const auto subsurface = subsurfaceOf(element, parts.empty() ? nullptr : parts[0].bsdf, context);
    if (subsurface) media = subsurface->media;
    const ElementPtr emitter = onlyChild(element, "emitter");
    std::vector<ShapePtr> result;
    for (const ShapePart& part : parts) {
        Shape& shape = *part.shape;
        const Box box = boxOf(shape);
        requirePlaceable(element, box.lower + context.origin, box.upper + context.origin);
        shape.id = shownName(element);
        shape.material = part.bsdf ? shownName(*part.bsdf) : "default";
        shape.bsdf = part.bsdf ? makeBsdf(*part.bsdf, context) : usualBsdf(element, media, emitter, context);
        if (subsurface) shape.bsdf = subsurface->boundary;
        if (part.bsdf) checkAttributes(*part.bsdf, shape, context);
        shape.media = media;
        if (media && emitter && part.bsdf && part.bsdf->type == "null")
            throw element.error(
                "the boundary of a medium emits and has the BSDF null, expected one of the two: light passes "
                "such a boundary without a vertex");
        if (emitter) {
            checkAttributes(*emitter, shape, context);
            if (LightPtr light = attachLight(element, *emitter, shape, context)) {
                shape.emitter = light;
                lights.push_back(std::move(light));
            }
        }
        result.push_back(part.shape);
    }
    element.checkAllUsed(context.lenient, context.warnings);
    return result;
}

/// The shapes inside, those of a `merge` among them.
std::vector<ElementPtr> shapesOf(const Element& element, LoadContext& context) {
    std::vector<ElementPtr> result;
    for (const ElementPtr& child : element.childrenOf("shape")) {
        if (child->type != kMerge) {
            result.push_back(child);
            continue;
        }
        const std::vector<ElementPtr> merged = shapesOf(*child, context);
        result.insert(result.end(), merged.begin(), merged.end());
        child->checkAllUsed(context.lenient, context.warnings);
    }
    return result;
}

/// A group and where its origin lies in the file's coordinates of the group.
struct BuiltGroup {
    ShapeGroup shapes;
    Vec3d origin{0.0};
};

void fillGroup(ShapeGroup& group, const Element& element, LoadContext& context) {
    for (const ElementPtr& child : shapesOf(element, context)) {
        if (child->type == kGroup || child->type == kInstance)
            throw child->error(fmt::format("a shapegroup cannot contain a {}", child->type));
        if (!child->childrenOf("emitter").empty())
            throw child->error(
                "shapes of a shapegroup cannot be emitters: each instance would be a light of its own");
        std::vector<LightPtr> none;
        for (ShapePtr& shape : makeShapes(*child, context, none)) group.shapes.push_back(std::move(shape));
    }
    if (group.shapes.empty()) throw element.error("a shapegroup without shapes");
    element.checkAllUsed(context.lenient, context.warnings);
}

std::shared_ptr<const BuiltGroup> makeGroup(const Element& element, LoadContext& context) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const BuiltGroup>(found->second);
    auto group = std::make_shared<BuiltGroup>();
    const Vec3d outside = context.origin;
    const MemoryBudget memory = context.memory;
    const size_t warnings = context.warnings.size();
    context.origin = Vec3d(0.0);
    fillGroup(group->shapes, element, context);
    group->origin = context.origin = originFor(boxesOf(group->shapes.shapes, {}));
    if (group->origin != Vec3d(0.0)) {  // once more, around its own origin
        group->shapes.shapes.clear();
        context.memory = memory;
        context.warnings.resize(warnings);
        forgetReads(element);
        fillGroup(group->shapes, element, context);
    }
    context.origin = outside;
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
    const Transform toWorld = context.toWorld(element);
    withLocation(element, [&] {
        context.memory.take(kInstanceBytes, "the instance");
        const Affine checked(toWorld);
    });
    const auto group = makeGroup(*child, context);
    const Instance instance{{group, &group->shapes}, toWorld * movedBy(group->origin, Transform())};
    for (const Box& box : boxesOf({}, {instance}))
        requirePlaceable(element, box.lower + context.origin, box.upper + context.origin);
    parts.instances.push_back(instance);
    element.checkAllUsed(context.lenient, context.warnings);
}

void addMerged(const Element& element, LoadContext& context, SceneParts& parts) {
    for (const ElementPtr& child : element.childrenOf("shape")) addShape(*child, context, parts);
    element.checkAllUsed(context.lenient, context.warnings);
}

}  // namespace

std::vector<std::string> shapeTypes() {
    std::vector<std::string> names = {kGroup, kInstance, kMerge};
    for (const ShapePlugin& p : kShapePlugins) names.emplace_back(p.type);
    return names;
}

void addShape(const Element& element, LoadContext& context, SceneParts& parts) {
    if (element.type == kGroup)
        makeGroup(element, context);
    else if (element.type == kInstance)
        addInstance(element, context, parts);
    else if (element.type == kMerge)
        addMerged(element, context, parts);
    else
        for (ShapePtr& shape : makeShapes(element, context, parts.lights))
            parts.shapes.push_back(std::move(shape));
}

}  // namespace metrolux::core::mitsuba
