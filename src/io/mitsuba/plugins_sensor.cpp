#include "endpoint/wide_cameras.h"
#include "io/mitsuba/context.h"
#include "io/mitsuba/field_of_view.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/unknown_plugins.h"
#include "io/mitsuba/world_origin.h"

namespace metrolux::core::mitsuba {

namespace {

constexpr int64_t kMaxPixels = int64_t(1) << 28;
const std::vector<std::string> kSensorTypes = {"perspective", "thinlens", "orthographic",
                                               "spherical",   "fisheye",  "radiancemeter"};
const std::vector<std::string> kFilmTypes = {"hdrfilm", "specfilm", "ldrfilm"};
constexpr uint64_t kFilmPixelBytes = 128;  // allowance for what a Film keeps of one

/// The unnamed child with a tag; null if there is none, Error if there are several.
ElementPtr onlyChild(const Element& element, const std::string& tag) {
    const std::vector<ElementPtr> children = element.childrenOf(tag);
    if (children.size() > 1) throw children[1]->error("found a second <" + tag + ">, expected at most one");
    return children.empty() ? nullptr : children[0];
}

void readFilter(const Element& element, LoadContext& context, SceneParts& parts) {
    using Kind = ReconstructionFilter::Kind;
    bool known = false;
    std::vector<std::string> names;
    for (const auto& [name, kind] : filterNames()) {
        names.push_back(name);
        if (element.type == name) {
            parts.filterKind = kind;
            known = true;
        }
    }
    if (!known) {
        const std::string message = unknownPlugin(element, "reconstruction filter", names);
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (gaussian is used)");
        return;
    }
    ReconstructionFilter::Parameters& p = parts.filter;
    if (parts.filterKind == Kind::Box || parts.filterKind == Kind::Tent) {
        p.radius = element.number("radius", p.radius);
        if (element.has("radius") && !(p.radius > 0)) throw element.error("\"radius\" must be positive");
    } else if (parts.filterKind == Kind::Gaussian) {
        p.stddev = element.number("stddev", p.stddev);
        if (!(p.stddev > 0)) throw element.error("\"stddev\" must be positive");
    } else if (parts.filterKind == Kind::Mitchell) {
        // Mitsuba 3 calls the parameters A and B, 0.x (and the paper) B and C.
        const bool paper = element.has("C") || (element.isLegacy() && !element.has("A"));
        p.b = element.number(paper ? "B" : "A", p.b);
        p.c = element.number(paper ? "C" : "B", p.c);
    } else if (parts.filterKind == Kind::Lanczos) {
        const int64_t lobes = element.integer("lobes", p.lobes);
        if (lobes < 1 || lobes > 16)
            throw element.error(fmt::format("found {} lobes, expected 1 to 16", lobes));
        p.lobes = static_cast<int>(lobes);
    }
    element.checkAllUsed(context.lenient, context.warnings);
}

/// Properties that choose the output file. Metrolux writes linear RGB in 32-bit floating point.
void readFormats(const Element& element, LoadContext& context) {
    struct Format {
        const char* property;
        const char* fallback;
        std::vector<std::string> known;
        std::vector<std::string> fulfilled;  ///< of which nothing is lost
    };
    const std::vector<Format> formats = {
        {"pixel_format",
         "rgb",
         {"luminance", "luminance_alpha", "rgb", "rgba", "xyz", "xyza", "spectrum", "spectrum_alpha"},
         {"rgb"}},
        {"component_format", "float32", {"float16", "float32", "uint32"}, {"float16", "float32"}},
        {"file_format", "openexr", {"openexr", "exr", "rgbe", "pfm"}, {"openexr", "exr"}}};
    for (const Format& format : formats) {
        std::string value = element.string(format.property, format.fallback);
        for (char& c : value) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        const bool isKnown = std::find(format.known.begin(), format.known.end(), value) != format.known.end();
        if (!isKnown && !element.isLegacy() && !context.lenient) {
            const std::string nearest = nearestName(value, format.known);
            throw element.error(
                fmt::format("found {} \"{}\"{}, expected one of {}", format.property, value,
                            nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                            fmt::join(format.known, ", ")));
        }
        if (std::find(format.fulfilled.begin(), format.fulfilled.end(), value) == format.fulfilled.end())
            context.warn(element, fmt::format("{} \"{}\" has no effect: images are written as RGB",
                                              format.property, value));
    }
    // 2.x has it under another name.
    const std::string border =
        element.version == 2 && element.has("high_quality_edges") ? "high_quality_edges" : "sample_border";
    if (element.boolean(border, false))
        context.warn(
            element,
            fmt::format("\"{}\" has no effect: the filter is exact at the border of the image", border));
    element.ignore("compensate");                          // sums are always exact enough
    if (element.version == 2) element.ignore("filename");  // of 2.0: the output is chosen on the command line
    element.ignore("banner");
}

int readSize(const Element& element, const std::string& name, int fallback) {
    const int64_t value = element.integer(name, fallback);
    if (value < 1 || value > kMaxPixels)
        throw element.error(fmt::format("found \"{}\" {}, expected a number of pixels from 1 to {}", name,
                                        value, kMaxPixels));
    return static_cast<int>(value);
}

FilmWindow fullWindow(int width, int height) { return {width, height, 0, 0, width, height}; }

/// The window after a change of resolution: its edges move in proportion.
FilmWindow rescaled(const FilmWindow& w, int width, int height) {
    const auto scale = [](int value, int from, int to) {
        return static_cast<int>(std::lround(double(value) * to / from));
    };
    FilmWindow result = fullWindow(width, height);
    result.x = std::min(scale(w.x, w.fullWidth, width), width - 1);
    result.y = std::min(scale(w.y, w.fullHeight, height), height - 1);
    result.width = std::max(1, scale(w.x + w.width, w.fullWidth, width) - result.x);
    result.height = std::max(1, scale(w.y + w.height, w.fullHeight, height) - result.y);
    return result;
}

void checkCrop(const Element& element, const FilmWindow& w) {
    if (w.x < 0 || w.y < 0 || w.width < 1 || w.height < 1 || int64_t(w.x) + w.width > w.fullWidth ||
        int64_t(w.y) + w.height > w.fullHeight)
        throw element.error(
            fmt::format("the crop window {} x {} at ({}, {}) is not within the image of {} x {}", w.width,
                        w.height, w.x, w.y, w.fullWidth, w.fullHeight));
}

FilmWindow overridden(const Element& element, FilmWindow w, const FilmOverride& o) {
    if (o.width > 0 || o.height > 0)
        w = rescaled(w, o.width > 0 ? o.width : w.fullWidth, o.height > 0 ? o.height : w.fullHeight);
    if (o.hasCrop) {
        w.x = o.cropX;
        w.y = o.cropY;
        w.width = o.cropWidth;
        w.height = o.cropHeight;
    }
    checkCrop(element, w);
    if (int64_t(w.fullWidth) * w.fullHeight > kMaxPixels)
        throw element.error(
            fmt::format("the image of {} x {} pixels is too large, at most {} pixels are possible",
                        w.fullWidth, w.fullHeight, kMaxPixels));
    return w;
}

FilmWindow readFilm(const Element& element, LoadContext& context, SceneParts& parts) {
    if (element.type != "hdrfilm") {
        const std::string message = unknownPlugin(element, "film", {"hdrfilm"});
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (read as hdrfilm)");
    }
    FilmWindow w = fullWindow(readSize(element, "width", 768), readSize(element, "height", 576));
    w.width = readSize(element, "crop_width", w.fullWidth);
    w.height = readSize(element, "crop_height", w.fullHeight);
    const int64_t x = element.integer("crop_offset_x", 0), y = element.integer("crop_offset_y", 0);
    w.x = static_cast<int>(std::clamp<int64_t>(x, -1, kMaxPixels));
    w.y = static_cast<int>(std::clamp<int64_t>(y, -1, kMaxPixels));
    checkCrop(element, w);
    readFormats(element, context);
    if (const ElementPtr filter = onlyChild(element, "rfilter")) readFilter(*filter, context, parts);
    element.checkAllUsed(context.lenient, context.warnings);
    return overridden(element, w, context.film);
}

void readClips(const Element& element, LoadContext& context, float& nearClip) {
    nearClip = element.number("near_clip", nearClip);
    const float farClip = element.number("far_clip", 1e4f);
    if (!(nearClip > 0))
        throw element.error(fmt::format("found near_clip {}, expected a positive distance", nearClip));
    if (!(nearClip < farClip)) throw element.error("found a near_clip beyond far_clip");
    if (element.has("far_clip"))
        context.warn(element, "\"far_clip\" has no effect: nothing is too far to be seen");
}

void bookFilm(const Element& element, LoadContext& context, const FilmWindow& window) {
    try {
        context.memory.take(static_cast<uint64_t>(window.pixelCount()) * kFilmPixelBytes,
                            fmt::format("an image of {} x {} pixels", window.width, window.height));
    } catch (const Error& problem) {
        throw element.error(problem.what());
    }
}

CameraPtr makePerspective(const Element& element, LoadContext& context, const FilmWindow& window) {
    PerspectiveParameters p;
    p.toWorld = context.toWorld(element);
    if (!isSimilarity(p.toWorld)) throw element.error("\"to_world\" of a camera may not scale or shear");
    if (p.toWorld.hasScale()) context.warn(element, "the scale in \"to_world\" of the camera has no effect");
    const FieldOfView fov = readFieldOfView(element);
    p.fov = fov.degrees;
    p.axis = fov.axis;
    readClips(element, context, p.nearClip);
    p.principalOffsetX = element.number("principal_point_offset_x", 0);
    p.principalOffsetY = element.number("principal_point_offset_y", 0);
    p.focusDistance = element.number("focus_distance", element.number("far_clip", 1e4f));
    if (element.type == "thinlens") {
        p.apertureRadius = element.number("aperture_radius", 0);
        if (!element.has("aperture_radius")) throw element.error("\"aperture_radius\" is missing");
    }
    return makePerspectiveCamera(p, window);
}

CameraPtr makeOrthographic(const Element& element, LoadContext& context, const FilmWindow& window) {
    OrthographicParameters p;
    p.toWorld = context.toWorld(element);
    readClips(element, context, p.nearClip);
    element.ignore("focus_distance");
    return makeOrthographicCamera(p, window);
}

/// 0.6's "spherical", and "fisheye", which neither Mitsuba has but plugins of others do.
CameraPtr makeWide(const Element& element, LoadContext& context, const FilmWindow& window) {
    WideCameraParameters p;
    p.toWorld = context.toWorld(element);
    if (!isSimilarity(p.toWorld)) throw element.error("\"to_world\" of a camera may not scale or shear");
    if (p.toWorld.hasScale()) context.warn(element, "the scale in \"to_world\" of the camera has no effect");
    if (element.has("near_clip") || element.has("far_clip")) {
        p.nearClip = 1e-2f;
        readClips(element, context, p.nearClip);
    }
    if (element.type == "spherical") return makePanoramaCamera(p, window);
    const char* const angle = element.has("fov") ? "fov" : "aperture";
    return makeFisheyeCamera(p, element.number(angle, 180), window);
}

/// Radiance along one ray, as a picture of one pixel that sees next to nothing else.
CameraPtr makeRadianceMeter(const Element& element, LoadContext& context, const FilmWindow& window) {
    if (window.fullWidth != 1 || window.fullHeight != 1)
        throw element.error(fmt::format("found an image of {} x {} pixels, expected a <film> of one",
                                        window.fullWidth, window.fullHeight));
    PerspectiveParameters p;
    p.toWorld = context.toWorld(element);
    const bool hasRay = element.has("origin") || element.has("direction");
    if (hasRay && (!element.has("origin") || !element.has("direction")))
        throw element.error("found only one of \"origin\" and \"direction\", expected both");
    if (hasRay && element.has("to_world"))
        throw element.error("found \"to_world\" as well as \"origin\", expected one of the two");
    if (hasRay) {
        const Vec3d origin = element.point("origin", Vec3d(0.0)),
                    direction = element.point("direction", Vec3d(0.0));
        if (!(direction.length() > 0)) throw element.error("\"direction\" has no length");
        const Vec3f up = std::abs(direction.y) < 0.9 * direction.length() ? Vec3f(0, 1, 0) : Vec3f(1, 0, 0);
        p.toWorld = movedBy(-context.origin, Transform::lookAt(origin, origin + direction, up));
    }
    if (!isSimilarity(p.toWorld)) throw element.error("\"to_world\" of a camera may not scale or shear");
    p.fov = 0.01f;
    p.nearClip = 1e-4f;
    return makePerspectiveCamera(p, window);
}

CameraPtr makeProjection(const Element& element, LoadContext& context, const FilmWindow& window) {
    if (element.type == "radiancemeter") return makeRadianceMeter(element, context, window);
    if (element.type == "orthographic") return makeOrthographic(element, context, window);
    if (element.type == "spherical" || element.type == "fisheye") return makeWide(element, context, window);
    return makePerspective(element, context, window);
}

}  // namespace

std::vector<std::string> sensorTypes() { return kSensorTypes; }
std::vector<std::string> filmTypes() { return kFilmTypes; }

CameraPtr makeCamera(const Element& element, LoadContext& context, SceneParts& parts) {
    const bool isKnown =
        std::find(kSensorTypes.begin(), kSensorTypes.end(), element.type) != kSensorTypes.end();
    if (!isKnown) {
        const std::string message = unknownPlugin(element, "sensor", kSensorTypes);
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (read as perspective)");
    }

    const ElementPtr film = onlyChild(element, "film");
    const FilmWindow window = film ? readFilm(*film, context, parts) : overridden(element, {}, context.film);
    bookFilm(film ? *film : element, context, window);
    element.childrenOf(
        "sampler");  // samples are drawn by the integrator, their number is a choice of the command line
    if (!element.isLegacy())
        for (const char* name : {"rolling_shutter_type", "rolling_shutter_duration"}) element.ignore(name);
    if (element.number("shutter_open", 0) != 0 || element.number("shutter_close", 0) != 0)
        context.warn(element, "the shutter has no effect: scenes do not move");

    CameraPtr camera;
    try {
        camera = makeProjection(element, context, window);
    } catch (const Error& problem) {
        const std::string message = problem.what();
        if (message.starts_with(element.location.file)) throw;
        throw element.error(message);
    }
    const Vec3d position = Vec3d(camera->position()) + context.origin;
    requirePlaceable(element, position, position);
    camera->medium = mediumOf(element, context);
    element.checkAllUsed(context.lenient, context.warnings);
    return camera;
}

}  // namespace metrolux::core::mitsuba
