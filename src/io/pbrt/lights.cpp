#include "io/pbrt/lights.h"

#include "base/suggest.h"
#include "image/image_io.h"
#include "io/mitsuba/maker.h"

#include <algorithm>
#include <numbers>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::PixelArray;
using mitsuba::RgbValue;
using mitsuba::settledMap;

constexpr double kPiD2 = std::numbers::pi;
constexpr double kDegree = kPiD2 / 180;

/// A square image over all directions, z up: the equal-area map of Clarberg, Fast Equal-Area Mapping of the
/// (Hemi)Sphere using SIMD, 2008. Directions are of unit length.
Vec2f squareOf(const Vec3d& d) {
    const double r = std::sqrt(std::max(0.0, 1 - std::abs(d.z)));
    const double turn = std::atan2(std::abs(d.y), std::abs(d.x)) / (kPiD2 / 2);
    double v = turn * r, u = r - v;
    if (d.z < 0) {
        std::swap(u, v);
        u = 1 - u;
        v = 1 - v;
    }
    return {static_cast<float>((std::copysign(u, d.x) + 1) / 2),
            static_cast<float>((std::copysign(v, d.y) + 1) / 2)};
}

Rgb pixel(const ImageData& image, double u, double v) {
    const auto at = [](double x, int n) { return std::clamp(static_cast<int>(x * n), 0, n - 1); };
    const float* p = image.at(at(u, image.width), at(v, image.height));
    return image.channels >= 3 ? Rgb(p[0], p[1], p[2]) : Rgb(p[0]);
}

struct LightMaker {
    const Parameters& p;
    Transform toWorld;
    const ColorSpace& space;
    double exposure;
    Reading& reading;

    Rgb color(const char* name) const {
        const Parameter* given = p.find(name);
        return given ? lightColor(*given, space, reading) : Rgb(1.0f);
    }
    /// Of the spectrum: with `scale`, or such that the photometric quantity is met that is `unit` for white
    /// of 1.
    Rgb scaled(const char* name, const char* quantity, double unit) const {
        double scale = p.number("scale", 1) * exposure;
        if (const double wanted = p.number(quantity, -1); wanted > 0) scale *= wanted / unit;
        return color(name) * static_cast<float>(scale);
    }
    ImageData image() const {
        const char* const name = p.has("mapname") ? "mapname" : "filename";  // of version 3
        return readImage(reading.find(p.requiredString(name), p.where()), false, &reading.memory);
    }
    /// Light space of spot and distant: along +z from "from" to "to".
    Transform aimed(const Vec3d& from, const Vec3d& to) const {
        const Vec3d axis = to - from;
        if (!(axis.length() > 0)) throw p.error("\"from\" and \"to\" are one point, expected two");
        const Vec3d up = std::abs(axis.normalized().y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0);
        return toWorld * Transform::lookAt(from, to, Vec3f(up));
    }
    static Transform unscaled(const Transform& map) {
        double rows[4][4] = {
            {0, 0, 0, map.at(0, 3)}, {0, 0, 0, map.at(1, 3)}, {0, 0, 0, map.at(2, 3)}, {0, 0, 0, 1}};
        for (int j = 0; j < 3; ++j) {
            const double length = std::hypot(map.at(0, j), map.at(1, j), map.at(2, j));
            for (int i = 0; i < 3; ++i) rows[i][j] = map.at(i, j) / (length > 0 ? length : 1);
        }
        return Transform::fromRows(rows);
    }

    ElementPtr point() const {
        const Vec3d from = toWorld.exactPoint(p.vector("from", Vec3d(0.0)));
        return Maker("emitter", "point", p.where())
            .with("position", settled(from))
            .with("intensity", RgbValue{scaled("I", "power", 4 * kPiD2)})
            .done();
    }
    ElementPtr spot() const {
        const double cutoff = p.number("coneangle", 30), delta = p.number("conedeltaangle", 5);
        if (!(cutoff > 0 && cutoff <= 90))
            throw p.error(fmt::format("found the coneangle {}, expected more than 0 and at most 90", cutoff));
        const double beam = std::clamp(cutoff - delta, 0.0, cutoff);
        const double inner = std::cos(beam * kDegree), outer = std::cos(cutoff * kDegree);
        if (beam < cutoff)
            reading.warn(p.error(
                "falls off linearly with the angle here, where pbrt has a smooth step of its cosine"));
        const Rgb intensity = scaled("I", "power", 2 * kPiD2 * ((1 - inner) + (inner - outer) / 2));
        return Maker("emitter", "spot", p.where())
            .with("to_world",
                  settledMap(unscaled(aimed(p.vector("from", Vec3d(0.0)), p.vector("to", Vec3d(0, 0, 1))))))
            .with("intensity", RgbValue{intensity})
            .with("cutoff_angle", cutoff)
            .with("beam_width", beam)
            .done();
    }
    ElementPtr distant() const {
        const Vec3d from = toWorld.exactPoint(p.vector("from", Vec3d(0.0))),
                    to = toWorld.exactPoint(p.vector("to", Vec3d(0, 0, 1)));
        if (!((to - from).length() > 0)) throw p.error("\"from\" and \"to\" are one point, expected two");
        return Maker("emitter", "directional", p.where())
            .with("direction", settled((to - from).normalized()))
            .with("irradiance", RgbValue{scaled("L", "illuminance", 1)})
            .done();
    }

    ElementPtr infinite() const {
        if (p.has("portal")) reading.warn(p.error("\"portal\" has no effect: it changes noise only"));
        const bool isOld = p.has("mapname");
        if (!p.has("filename") && !isOld)
            return Maker("emitter", "constant", p.where())
                .with("radiance", RgbValue{scaled("L", "illuminance", kPiD2)})
                .done();
        const ImageData source = image();
        if (p.has("L") && !isOld)
            throw p.error("found \"L\" as well as \"filename\", expected one of the two");
        const Rgb tint = color("L");  // of version 3, where it multiplies the image
        const bool isSquare = source.width == source.height;
        if (!isSquare && source.width != 2 * source.height)
            throw p.error(fmt::format(
                "found an image of {} x {} pixels, expected a square one (equal-area), or one twice "
                "as wide as high (latitude and longitude, of pbrt 3)",
                source.width, source.height));
        if (!isSquare)
            reading.warn(p.error(
                "the image is twice as wide as high: read as latitude and longitude, as pbrt 3 does"));
        const auto lookUp = [&](const Vec3d& d) {
            if (isSquare) return pixelOver(d, source);
            double turn = std::atan2(d.y, d.x) / (2 * kPiD2);
            turn -= std::floor(turn);
            return pixel(source, turn, std::acos(std::clamp(d.z, -1.0, 1.0)) / kPiD2);
        };
        const float scale = environmentScale(lookUp);
        // Ours has y up and its first and last rows at the poles; it is turned so that this is pbrt's z.
        const int height = std::max(2, isSquare ? source.height : source.height + 1), width = 2 * height;
        const auto count = static_cast<size_t>(width) * static_cast<size_t>(height);
        reading.memory.take(3 * count * sizeof(float), "the environment map");
        auto pixels = std::make_shared<std::vector<float>>();
        pixels->reserve(3 * count);
        constexpr int kCoarse = 1024;
        const int samples = source.height > kCoarse ? 1 : 3;  // in each direction of a pixel
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                Rgb sum(0.0f);
                for (int k = 0; k < samples * samples; ++k) {
                    const double phi = 2 * kPiD2 * (x + (k % samples + 0.5) / samples) / width;
                    const double row = y + (k / samples + 0.5) / samples - 0.5;
                    const double theta = kPiD2 * std::clamp(row / (height - 1), 0.0, 1.0);
                    sum += lookUp(
                        {std::cos(phi) * std::sin(theta), std::sin(phi) * std::sin(theta), std::cos(theta)});
                }
                const Rgb value = tint * space.convert(sum * (scale / static_cast<float>(samples * samples)));
                pixels->insert(pixels->end(), {value.x, value.y, value.z});
            }
        // u = 0 is local -z, u = 1/4 local +x, the zenith local +y: pbrt's +x, +y and +z.
        const Transform turned =
            Transform::fromRows({{0, 0, -1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}});
        return Maker("emitter", "envmap", p.where())
            .with("to_world", settledMap(unscaled(toWorld) * turned))
            .with("data", PixelArray{width, height, 3, *pixels, pixels})
            .done();
    }
    template <class LookUp>
    float environmentScale(const LookUp& lookUp) const {
        double scale = p.number("scale", 1) * exposure;
        const double wanted = p.number("illuminance", -1);
        if (!(wanted > 0)) return static_cast<float>(scale);
        constexpr int kRows = 256, kColumns = 512;
        double sum = 0;
        for (int j = 0; j < kRows; ++j)
            for (int i = 0; i < kColumns; ++i) {
                // Uniform in the disk below the hemisphere: each sample stands for pi / count of irradiance.
                const double z = std::sqrt((j + 0.5) / kRows), phi = 2 * kPiD2 * (i + 0.5) / kColumns,
                             r = std::sqrt(1 - z * z);
                sum += double(luminance(lookUp({r * std::cos(phi), r * std::sin(phi), z})));
            }
        const double illuminance = kPiD2 * sum / (kRows * kColumns);
        if (illuminance > 0) scale *= wanted / illuminance;
        return static_cast<float>(scale);
    }

    /// Intensity by direction within a pyramid. Ours projects an irradiance on the plane z = 1, which is the
    /// intensity times the cubed cosine.
    ElementPtr projection() const {
        ImageData source = image();
        const double fov = p.number("fov", 90);
        const double aspect = double(source.width) / double(source.height);
        const double half = std::tan(fov * kDegree / 2);
        const double halfX = aspect > 1 ? half * aspect : half, halfY = aspect > 1 ? half : half / aspect;
        auto pixels = std::make_shared<std::vector<float>>();
        reading.memory.take(3 * source.pixels.size() * sizeof(float), "the projected image");
        const double du = 2 * halfX / source.width, dv = 2 * halfY / source.height;
        double power = 0;
        for (int y = 0; y < source.height; ++y)
            for (int x = 0; x < source.width; ++x) {
                const double px = (x + 0.5) * du - halfX, py = halfY - (y + 0.5) * dv;
                const double cosine = 1 / std::sqrt(1 + px * px + py * py), cubed = cosine * cosine * cosine;
                const Rgb c = pixel(source, (x + 0.5) / source.width, (y + 0.5) / source.height);
                power += double(luminance(c)) * cubed * du * dv;
                const Rgb v = space.convert(c * static_cast<float>(cubed / kPiD2));
                pixels->insert(pixels->end(), {v.x, v.y, v.z});
            }
        double scale = p.number("scale", 1) * exposure;
        if (const double wanted = p.number("power", -1); wanted > 0 && power > 0) scale *= wanted / power;
        const ElementPtr bitmap =
            Maker("texture", "bitmap", p.where())
                .with("data", PixelArray{source.width, source.height, 3, *pixels, pixels})
                .with("raw", true)
                .done();
        // Its image has x to the right, ours to the left.
        return Maker("emitter", "projector", p.where())
            .with("to_world", settledMap(unscaled(toWorld) * Transform::scale({-1, 1, 1})))
            .with("irradiance", bitmap)
            .with("scale", scale)
            .with("fov", 2 * std::atan(halfX) / kDegree)
            .with("fov_axis", std::string("x"))
            .done();
    }

    /// Intensity by an equal-area image whose z is y of the light.
    ElementPtr goniometric() const {
        const ImageData source = image();
        if (source.width != source.height)
            throw p.error(fmt::format("found an image of {} x {} pixels, expected a square one (equal-area)",
                                      source.width, source.height));
        constexpr int kMostRows = 721;
        const int height = std::clamp(source.height, 3, kMostRows), width = 2 * height;
        reading.memory.take(static_cast<uint64_t>(height) * static_cast<uint64_t>(width) * sizeof(float),
                            "the light");
        auto pixels = std::make_shared<std::vector<float>>();
        double sum = 0, weights = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double theta = kPiD2 * y / (height - 1), phi = 2 * kPiD2 * x / width;
                const Rgb c = pixelOver(
                    {std::sin(theta) * std::cos(phi), -std::sin(theta) * std::sin(phi), std::cos(theta)},
                    source);
                pixels->push_back((c.x + c.y + c.z) / 3);
                sum += std::sin(theta) * double(pixels->back());
                weights += std::sin(theta);
            }
        const Transform turned =
            Transform::fromRows({{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}});
        return Maker("emitter", "goniometric", p.where())
            .with("to_world", settledMap(unscaled(toWorld) * turned))
            .with("intensity", RgbValue{scaled("I", "power", 4 * kPiD2 * std::max(sum / weights, 1e-30))})
            .with("data", PixelArray{width, height, 1, *pixels, pixels})
            .done();
    }
    static Rgb pixelOver(const Vec3d& direction, const ImageData& image) {
        const Vec2f uv = squareOf(direction);
        return pixel(image, double(uv.x), double(uv.y));
    }
};

struct LightType {
    const char* name;
    ElementPtr (*make)(const LightMaker&);
};
constexpr LightType kLightTypes[] = {
    {"point", [](const LightMaker& l) { return l.point(); }},
    {"spot", [](const LightMaker& l) { return l.spot(); }},
    {"distant", [](const LightMaker& l) { return l.distant(); }},
    {"infinite", [](const LightMaker& l) { return l.infinite(); }},
    {"projection", [](const LightMaker& l) { return l.projection(); }},
    {"goniometric", [](const LightMaker& l) { return l.goniometric(); }},
};

}  // namespace

std::vector<std::string> lightTypes() {
    std::vector<std::string> names;
    for (const LightType& type : kLightTypes) names.emplace_back(type.name);
    return names;
}

ElementPtr makeLight(const std::string& type, const Parameters& p, const Transform& toWorld,
                     const ColorSpace& space, double exposure, Reading& reading) {
    for (const LightType& known : kLightTypes) {
        if (type != known.name) continue;
        ElementPtr made = known.make({p, toWorld, space, exposure, reading});
        p.ignore({"samples", "nsamples"});  // of version 3
        p.checkAllUsed(reading);
        return made;
    }
    const std::string nearest = nearestName(type, lightTypes());
    reading.refuse(p.error(fmt::format("the light \"{}\" is not supported{}, expected one of {}", type,
                                       nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                                       fmt::join(lightTypes(), ", "))),
                   "it is left out");
    return nullptr;
}

AreaLight readAreaLight(const std::string& type, const Parameters& p, const ColorSpace& space,
                        double exposure, Textures& textures, Reading& reading) {
    AreaLight light;
    light.where = p.where();
    if (type != "diffuse" && type != "area")
        reading.refuse(
            p.error(fmt::format("the area light \"{}\" is not supported, expected \"diffuse\"", type)),
            "read as diffuse");
    const auto scale = static_cast<float>(p.number("scale", 1) * exposure);
    if (p.has("filename")) {
        if (p.has("L")) throw p.error("found \"L\" as well as \"filename\", expected one of the two");
        light.radiance = textures.imageFile(p.requiredString("filename"), p, false, space);
    } else if (const Parameter* given = p.find("L")) {
        light.radiance = Texture(lightColor(*given, space, reading));
    }
    light.radiance = light.radiance.changed([scale](const Rgb& c) { return c * scale; }, reading.memory);
    light.bothSides = p.boolean("twosided", false);
    light.power = p.number("power", -1);
    p.ignore({"nsamples", "samples"});
    p.checkAllUsed(reading);
    return light;
}

ElementPtr AreaLight::emitter(double area, double triangles, MemoryBudget& memory) const {
    Texture emitted = radiance;
    if (power > 0 && area > 0) {
        // pbrt leaves the color of L out of the count, but not the mean of an image.
        const double mean = radiance.isConstant() ? 1 : double(luminance(radiance.mean()));
        const double unit = (bothSides ? 2 : 1) * kPiD2 * area / triangles * (mean > 0 ? mean : 1);
        const auto factor = static_cast<float>(power / unit);
        emitted = emitted.changed([factor](const Rgb& c) { return c * factor; }, memory);
    }
    Maker result("emitter", "area", where);
    emitted.addTo(result, "radiance", false);
    return result.done();
}

}  // namespace metrolux::core::pbrt
