#include "io/pbrt/view.h"

#include "base/suggest.h"
#include "io/mitsuba/maker.h"

#include <algorithm>
#include <numbers>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::settledMap;

constexpr double kDegree = std::numbers::pi / 180;
/// Rays of pbrt start at the lens.
constexpr double kNearClip = 1e-5;

struct FilmSize {
    int64_t width, height;
};

FilmSize sizeOf(const Parameters& film) {
    constexpr int64_t kLargestSide = 65536;
    const FilmSize size{film.integer("xresolution", 1280), film.integer("yresolution", 720)};
    if (size.width < 1 || size.height < 1 || size.width > kLargestSide || size.height > kLargestSide)
        throw film.error(fmt::format("found {} x {} pixels, expected 1 to {} a side", size.width, size.height,
                                     kLargestSide));
    return size;
}

ElementPtr filterOf(const TypedDirective& filter, Reading& reading) {
    const Parameters& p = filter.parameters;
    const std::string type = filter.isGiven ? filter.type : "gaussian";
    const auto radius = [&](double fallback) {
        const double x = p.number("xradius", p.number("xwidth", fallback)),
                     y = p.number("yradius", p.number("ywidth", fallback));
        if (x != y)
            reading.warn(p.error(fmt::format("found the radii {} and {}: the first holds for both", x, y)));
        if (!(x > 0)) throw p.error(fmt::format("found the radius {}, expected more than zero", x));
        return x;
    };
    const auto named = [&](const char* name) { return Maker("rfilter", name, p.where()); };
    Maker made = named("gaussian");
    if (type == "box") {
        made = named("box").with("radius", radius(0.5));
    } else if (type == "triangle") {
        made = named("tent").with("radius", radius(2));
    } else if (type == "gaussian") {
        // Ours ends at four deviations.
        made = named("gaussian").with("stddev", p.number("sigma", 0.5));
        p.ignore({"xradius", "yradius", "xwidth", "ywidth", "alpha"});
    } else if (type == "mitchell") {
        made = named("mitchell").with("A", p.number("B", 1.0 / 3)).with("B", p.number("C", 1.0 / 3));
        p.ignore({"xradius", "yradius", "xwidth", "ywidth"});
    } else if (type == "sinc") {
        made = named("lanczos").with("lobes",
                                     static_cast<int64_t>(std::lround(std::max(1.0, p.number("tau", 3)))));
        p.ignore({"xradius", "yradius", "xwidth", "ywidth"});
    } else {
        reading.refuse(
            p.error(fmt::format("found the filter \"{}\", expected box, triangle, gaussian, mitchell or sinc",
                                type)),
            "gaussian is used");
    }
    p.checkAllUsed(reading);
    return made.done();
}

ElementPtr filmOf(const TypedDirective& film, const TypedDirective& filter, Reading& reading) {
    const Parameters& p = film.parameters;
    if (film.isGiven && film.type != "rgb" && film.type != "gbuffer" && film.type != "spectral" &&
        film.type != "image")
        reading.refuse(p.error(fmt::format("found the film \"{}\", expected rgb", film.type)), "read as rgb");
    const FilmSize size = sizeOf(p);
    Maker result("film", "hdrfilm", p.where());
    result.with("width", size.width).with("height", size.height);
    int64_t x0 = 0, x1 = size.width, y0 = 0, y1 = size.height;
    const auto four = [&](const char* name) -> const std::vector<double>& {
        const std::vector<double>& v = p.numbers(name, 4);
        if (v.size() != 4)
            throw p.error(fmt::format("found {} numbers of \"{}\", expected 4", v.size(), name));
        return v;
    };
    if (p.has("pixelbounds")) {
        const std::vector<double>& b = four("pixelbounds");
        x0 = std::llround(std::clamp(b[0], 0.0, 65536.0)), x1 = std::llround(std::clamp(b[1], 0.0, 65536.0));
        y0 = std::llround(std::clamp(b[2], 0.0, 65536.0)), y1 = std::llround(std::clamp(b[3], 0.0, 65536.0));
    } else if (p.has("cropwindow")) {
        const std::vector<double>& c = four("cropwindow");
        const auto edge = [](double share, int64_t n) {
            return static_cast<int64_t>(std::ceil(std::clamp(share, 0.0, 1.0) * double(n)));
        };
        x0 = edge(c[0], size.width), x1 = edge(c[1], size.width);
        y0 = edge(c[2], size.height), y1 = edge(c[3], size.height);
    }
    if (x1 <= x0 || y1 <= y0) throw p.error("the crop has no pixels, expected some");
    if (x0 > 0 || y0 > 0 || x1 < size.width || y1 < size.height)
        result.with("crop_offset_x", x0)
            .with("crop_offset_y", y0)
            .with("crop_width", x1 - x0)
            .with("crop_height", y1 - y0);
    if (const std::string sensor = p.string("sensor", "cie1931"); sensor != "cie1931")
        reading.warn(
            p.error(fmt::format("the sensor \"{}\" has no effect: colors are those of cie1931", sensor)));
    if (p.number("whitebalance", 0) != 0) reading.warn(p.error("\"whitebalance\" has no effect"));
    if (p.has("maxcomponentvalue"))
        reading.warn(p.error("\"maxcomponentvalue\" has no effect: nothing is clamped"));
    p.ignore({"filename", "diagonal", "iso", "savefp16", "scale", "nbuckets", "lambdamin", "lambdamax",
              "coordinatesystem"});
    result.containing(filterOf(filter, reading));
    p.checkAllUsed(reading);
    return result.done();
}

/// Half the width and height of the screen window; [-1, 1] along the shorter side.
struct Screen {
    double x, y;
};
Screen screenOf(const Parameters& p, const FilmSize& size) {
    const double aspect = p.number("frameaspectratio", double(size.width) / double(size.height));
    if (std::abs(aspect * double(size.height) / double(size.width) - 1) > 1e-3)
        throw p.error("\"frameaspectratio\" would make pixels that are not square, which is not supported");
    Screen screen = aspect > 1 ? Screen{aspect, 1} : Screen{1, 1 / aspect};
    if (!p.has("screenwindow")) return screen;
    const std::vector<double>& w = p.numbers("screenwindow", 4);
    if (w.size() != 4)
        throw p.error(fmt::format("found {} numbers of \"screenwindow\", expected 4", w.size()));
    screen = {(w[1] - w[0]) / 2, (w[3] - w[2]) / 2};
    if (!(screen.x > 0 && screen.y > 0) || std::abs(w[0] + w[1]) > 1e-6 * screen.x ||
        std::abs(w[2] + w[3]) > 1e-6 * screen.y || std::abs(screen.x / screen.y / aspect - 1) > 1e-3)
        throw p.error(
            "found a \"screenwindow\" that is not centered or not as wide as the image, which is not "
            "supported");
    return screen;
}

}  // namespace

double View::exposure() const {
    const Parameters &c = camera.parameters, &f = film.parameters;
    const double open = c.number("shutteropen", 0), close = c.number("shutterclose", 1);
    // A shutter of no time is that of scenes that do not move.
    const double time = close > open ? close - open : 1;
    return time * f.number("iso", 100) / 100;
}

ElementPtr View::sensor(Reading& reading) const {
    const Parameters& p = camera.parameters;
    const FilmSize size = sizeOf(film.parameters);
    // Camera space of pbrt has x to the right, Mitsuba's to the left.
    const Transform place = cameraToWorld * Transform::scale({-1, 1, 1});
    std::string type = camera.isGiven ? camera.type : "perspective";
    if (type == "environment") type = "spherical";  // of version 3
    if (type != "perspective" && type != "orthographic" && type != "spherical") {
        reading.refuse(
            p.error(fmt::format(
                "the camera \"{}\" is not supported, expected perspective, orthographic or spherical", type)),
            "a perspective camera stands in");
        for (const Parameter& parameter : p.all()) p.find(parameter.name);
        type = "perspective";
    }
    const double lens = p.number("lensradius", 0), focus = p.number("focaldistance", 1e6);
    Maker result("sensor", type == "perspective" && lens > 0 ? "thinlens" : type, p.where());
    if (type == "perspective") {
        const Screen screen = screenOf(p, size);
        const double fov = p.number("fov", 90);
        if (!(fov > 0 && fov < 180))
            throw p.error(fmt::format("found fov {}, expected more than 0 and less than 180", fov));
        const double half = std::tan(fov / 2 * kDegree) * std::min(screen.x, screen.y);
        result.with("to_world", settledMap(place))
            .with("fov", std::min(screen.x, screen.y) == 1 ? fov : 2 * std::atan(half) / kDegree)
            .with("fov_axis", std::string("smaller"))
            .with("near_clip", kNearClip);
        if (lens > 0) result.with("aperture_radius", lens).with("focus_distance", focus);
    } else if (type == "orthographic") {
        const Screen screen = screenOf(p, size);
        const auto x = static_cast<float>(screen.x);
        if (lens > 0)
            reading.warn(p.error("an orthographic camera has no lens here: \"lensradius\" has no effect"));
        result.with("to_world", settledMap(place * Transform::scale({x, x, 1}))).with("near_clip", kNearClip);
    } else {
        if (const std::string mapping =
                p.string("mapping", camera.type == "environment" ? "equirectangular" : "equalarea");
            mapping != "equirectangular")
            reading.refuse(p.error(fmt::format(
                               "the mapping \"{}\" is not supported, expected equirectangular", mapping)),
                           "read as equirectangular");
        // pbrt's image begins at +x and turns to +z; ours begins at -z and turns to +x.
        const Transform turned =
            Transform::fromRows({{0, 0, -1, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}, {0, 0, 0, 1}});
        result.with("to_world", settledMap(cameraToWorld * turned));
    }
    p.ignore({"shutteropen", "shutterclose", "frameaspectratio", "screenwindow"});
    p.checkAllUsed(reading);
    return result.containing(filmOf(film, filter, reading)).done();
}

ElementPtr View::integratorElement(Reading& reading) const {
    struct Ours {
        const char *pbrt, *name;
    };
    constexpr Ours kOurs[] = {{"path", "path"},          {"volpath", "path"},    {"simplepath", "path"},
                              {"simplevolpath", "path"}, {"randomwalk", "path"}, {"directlighting", "path"},
                              {"whitted", "path"},       {"bdpt", "bdpt"},       {"mlt", "mmlt"},
                              {"sppm", "sppm"},          {"lightpath", "light"}};
    const Parameters& p = integrator.parameters;
    const std::string type = integrator.isGiven ? integrator.type : "volpath";
    std::string ours = "path";
    bool isKnown = false;
    for (const Ours& entry : kOurs)
        if (type == entry.pbrt) {
            ours = entry.name;
            isKnown = true;
        }
    if (!isKnown)
        reading.warn(p.error(fmt::format("the integrator \"{}\" is not known: path stands in", type)));
    // pbrt counts bounces, ours edges; other settings are those of its algorithms.
    const int64_t depth = p.integer("maxdepth", 5);
    return Maker("integrator", ours, p.where()).with("max_depth", depth < 0 ? int64_t{-1} : depth + 1).done();
}

}  // namespace metrolux::core::pbrt
