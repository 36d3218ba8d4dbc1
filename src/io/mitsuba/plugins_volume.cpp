/// Volumes, and the properties that may be a value or a volume.

#include "io/mitsuba/choice.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/spectrum.h"
#include "io/mitsuba/unknown_plugins.h"
#include "io/mitsuba/world_origin.h"
#include "io/vdb_file.h"
#include "io/volume_file.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

Transform ontoBox(const Vec3d& lower, const Vec3d& upper) {
    const Vec3d size = upper - lower;
    return Transform::fromRows(
        {{size.x, 0, 0, lower.x}, {0, size.y, 0, lower.y}, {0, 0, size.z, lower.z}, {0, 0, 0, 1}});
}

/// Volumes are in the world also where the shapes around them are in a group of their own.
Transform toScene(const Element& element, const LoadContext& context) {
    return movedBy(-context.sceneOrigin, element.transform("to_world"));
}

VolumePtr constant(const Element& e, LoadContext& context) {
    const Rgb value = quantity(e, "value", kCoefficient, 1);
    if (e.isLegacy()) return makeConstantVolume(value);
    return makeConstantVolume(value, toScene(e, context));
}

/// Of "filename", or of "data", whose box is the unit cube.
VolumeFile samplesOf(const Element& e, LoadContext& context) {
    const VoxelArray* data = e.voxels("data");
    if (!data) return readVolumeFile(context.resolve(e, e.requiredString("filename")), &context.memory);
    if (e.has("filename")) throw e.error("found both \"data\" and \"filename\", expected one");
    const auto& n = data->resolution;
    VolumeFile result{{Imath::V3i(n[0], n[1], n[2]), data->channels, {}}, {Vec3f(0.0f), Vec3f(1.0f)}};
    context.memory.take(data->values.size() * sizeof(float), "the volume");
    result.samples.values.assign(data->values.begin(), data->values.end());
    return result;
}

void readLookUp(const Element& e, LoadContext& context, GridSettings& settings) {
    settings.filter = choice<GridFilter>(
        e, "filter_type", {{"trilinear", GridFilter::Trilinear}, {"nearest", GridFilter::Nearest}});
    settings.wrap = choice<GridWrap>(
        e, "wrap_mode",
        {{"clamp", GridWrap::Clamp}, {"repeat", GridWrap::Repeat}, {"mirror", GridWrap::Mirror}});
    e.boolean("raw", false);   // of spectral modes
    e.boolean("accel", true);  // of GPUs
    if (e.has("max_value")) {
        e.number("max_value", 0);
        context.warn(e, "\"max_value\" has no effect: what no value exceeds is found out");
    }
}

/// A grid of OpenVDB is where its file has it, in the space of to_world.
VolumePtr gridOfVdb(const Element& e, LoadContext& context) {
    VdbFile file =
        readVdbFile(context.resolve(e, e.requiredString("filename")), e.string("grid", ""), &context.memory);
    GridSettings settings;
    readLookUp(e, context, settings);
    settings.toWorld = toScene(e, context) * file.toFile;
    return makeGridVolume(std::move(file.samples), settings);
}

VolumePtr grid(const Element& e, LoadContext& context) {
    if (!e.voxels("data") && e.requiredString("filename").ends_with(".vdb")) return gridOfVdb(e, context);
    VolumeFile file = samplesOf(e, context);
    Vec3d lower(file.box.min), upper(file.box.max);
    GridSettings settings;
    bool isInBox = true;
    if (e.isLegacy()) {
        settings.placement = GridPlacement::Nodes;
        if (e.has("min") != e.has("max")) throw e.error("found only one of \"min\" and \"max\"");
        lower = e.point("min", lower);
        upper = e.point("max", upper);
        e.ignore("send_data");  // over a network
    } else {
        readLookUp(e, context, settings);
        isInBox = e.boolean("use_grid_bbox", false);
    }
    settings.toWorld = toScene(e, context);
    if (isInBox) {
        for (int axis = 0; axis < 3; ++axis)
            if (!(lower[axis] < upper[axis]))
                throw e.error(
                    fmt::format("the box of the data reaches from ({}, {}, {}) to ({}, {}, {}), "
                                "expected one with a volume",
                                lower.x, lower.y, lower.z, upper.x, upper.y, upper.z));
        settings.toWorld = settings.toWorld * ontoBox(lower, upper);
    }
    context.memory.take(gridVolumeBytes(file.samples.resolution), "the volume");
    return makeGridVolume(std::move(file.samples), settings);
}

using VolumeFactory = VolumePtr (*)(const Element&, LoadContext&);
const std::vector<std::pair<std::string, VolumeFactory>> kVolumeFactories = {{"constvolume", constant},
                                                                             {"gridvolume", grid}};

}  // namespace

const Quantity kCoefficient{"coefficient of zero or more", unboundedFromSpectrum,
                            std::numeric_limits<float>::max()};
const Quantity kAlbedo{"albedo in [0, 1]", reflectanceFromSpectrum, 1};

std::vector<std::string> volumeTypes() {
    std::vector<std::string> names;
    names.reserve(kVolumeFactories.size());
    for (const auto& [name, factory] : kVolumeFactories) names.push_back(name);
    return names;
}

VolumePtr makeVolume(const Element& element, LoadContext& context) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const Volume>(found->second);
    VolumePtr result;
    for (const auto& [name, factory] : kVolumeFactories)
        if (element.type == name)
            result = withLocation(element, [&, make = factory] { return make(element, context); });
    if (result) {
        element.checkAllUsed(context.lenient, context.warnings);
    } else {
        const std::string message = unknownPlugin(element, "volume", volumeTypes());
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (nothing is there)");
        result = makeConstantVolume(Rgb(0.0f));
    }
    context.built[&element] = result;
    return result;
}

namespace {

Rgb inRange(const Element& element, const Property& property, const Quantity& kind, const Rgb& value) {
    for (int c = 0; c < 3; ++c)
        if (!(value[c] >= 0 && value[c] <= kind.largest))
            throw element.error(property, fmt::format("found {}, expected a{} {}", value[c],
                                                      kind.name[0] == 'a' ? "n" : "", kind.name));
    return value;
}

}  // namespace

Rgb quantity(const Element& element, const char* name, const Quantity& kind, float fallback) {
    const Property* property = element.find(name);
    if (!property) return Rgb(fallback);
    const std::optional<Rgb> color = constantColor(element, *property, kind.convert);
    if (!color)
        throw element.error(*property, "found an element, expected a number, an <rgb> or a <spectrum>");
    return inRange(element, *property, kind, *color);
}

VolumePtr volumeProperty(const Element& element, const char* name, LoadContext& context, const Quantity& kind,
                         float fallback, bool bounded) {
    const Property* property = element.find(name);
    if (const ElementPtr child = property ? element.child(name) : nullptr) {
        if (child->tag == "volume") return makeVolume(*child, context);
        if (child->tag != "texture")
            throw element.error(*property, fmt::format("found a <{}>, expected a <volume>", child->tag));
        const TexturePtr texture = makeTexture(*child, context);  // a spectrum by name
        if (!texture->isConstant())
            throw element.error(*property, "found a <texture> that varies, expected a <volume>");
        return makeConstantVolume(inRange(element, *property, kind, texture->mean()));
    }
    const Rgb value = quantity(element, name, kind, fallback);
    if (!bounded) return makeConstantVolume(value);
    return makeConstantVolume(value, movedBy(-context.sceneOrigin, Transform()));
}

}  // namespace metrolux::core::mitsuba
