#include "io/pbrt/media.h"

#include "base/suggest.h"
#include "io/medium_presets.h"
#include "io/mitsuba/maker.h"

#include <algorithm>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::RgbValue;

/// Absorption and scattering of each unit of density.
struct Coefficients {
    Rgb absorption{1.0f}, scattering{1.0f};

    Rgb extinction() const { return absorption + scattering; }
    Rgb albedo() const {
        Rgb result(0.0f);
        for (int c = 0; c < 3; ++c)
            if (const float sum = extinction()[c]; sum > 0) result[c] = scattering[c] / sum;
        return result;
    }
};

struct MediumMaker {
    const Parameters& p;
    const Transform& toWorld;
    const ColorSpace& space;
    Reading& reading;

    Coefficients coefficients() const {
        Coefficients result;
        const auto read = [&](const char* name, Rgb& value) {
            const Parameter* given = p.find(name);
            if (!given) return;
            value = surfaceColor(*given, space, reading);
            for (int c = 0; c < 3; ++c)
                if (!(value[c] >= 0))
                    throw given->error(
                        fmt::format("found {}, expected a coefficient of zero or more", value[c]));
        };
        read("sigma_a", result.absorption);
        read("sigma_s", result.scattering);
        return result;
    }
    double scale() const {
        const double scale = p.number("scale", 1);
        if (!(scale >= 0))
            throw p.error(fmt::format("found the scale {}, expected one of zero or more", scale));
        return scale;
    }
    ElementPtr phase() const {
        const double g = p.number("g", 0);
        if (g == 0) return nullptr;
        return Maker("phase", "hg", p.where()).with("g", g).done();
    }

    void refuseEmission() const {
        const auto isBlack = [](const Parameter& le) {
            // Of a spectrum every second number is a wavelength.
            const bool isPairs = le.type == "spectrum";
            for (size_t i = 0; i < le.numbers.size(); ++i)
                if (le.numbers[i] != 0 && !(isPairs && i % 2 == 0)) return false;
            return le.strings.empty();
        };
        const Parameter *le = p.find("Le"), *scale = p.find("Lescale");
        const bool glows = le && !isBlack(*le) && !(scale && isBlack(*scale));
        if (glows || p.has("temperature"))
            reading.refuse(p.error("emissive media are not supported"), "it does not emit");
        p.ignore({"temperaturescale", "temperatureoffset", "temperaturecutoff"});
    }

    ElementPtr homogeneous(const std::string& name) const {
        Coefficients c = coefficients();
        if (const std::string preset = p.string("preset", ""); !preset.empty()) {
            if (const MediumPreset* known = findMediumPreset(kPbrtPresets, preset))
                c = {known->absorption, known->scattering};
            else
                reading.refuse(p.error(fmt::format("found the preset \"{}\", expected one of: {}", preset,
                                                   mediumPresetNames(kPbrtPresets))),
                               "sigma_a and sigma_s hold");
        }
        return Maker("medium", "homogeneous", p.where())
            .id(name)
            .with("sigma_t", RgbValue{c.extinction()})
            .with("albedo", RgbValue{c.albedo()})
            .with("scale", scale())
            .containing(phase())
            .done();
    }

    int count(const char* name) const {
        constexpr int64_t kMost = 1 << 20;
        const int64_t n = p.integer(name, 1);
        if (n < 1 || n > kMost)
            throw p.error(fmt::format("found {} {}, expected 1 to {} samples", name, n, kMost));
        return static_cast<int>(n);
    }

    /// Samples are in the middle of cells. Outside of them pbrt has zero, to which the outermost half of the
    /// outer cells falls: another layer of cells says so.
    ElementPtr uniformGrid(const std::string& name) const {
        const int nx = count("nx"), ny = count("ny"), nz = count("nz");
        const std::vector<double>& density = p.numbers("density", 1);
        const uint64_t cells = uint64_t(nx) * uint64_t(ny) * uint64_t(nz);
        if (density.size() != cells)
            throw p.error(fmt::format("found {} values of \"density\", expected {} x {} x {}", density.size(),
                                      nx, ny, nz));
        const Coefficients c = coefficients();
        const Rgb sigma = c.extinction();
        const bool isGray = sigma.x == sigma.y && sigma.y == sigma.z;
        const size_t channels = isGray ? 1 : 3;
        const auto wide = [](int n) { return size_t(n) + 2; };
        const uint64_t values = uint64_t(channels) * wide(nx) * wide(ny) * wide(nz);
        reading.memory.take(values * sizeof(float), "the medium");
        auto data = std::make_shared<std::vector<float>>(values, 0.0f);
        for (size_t z = 0; z < size_t(nz); ++z)
            for (size_t y = 0; y < size_t(ny); ++y)
                for (size_t x = 0; x < size_t(nx); ++x) {
                    const auto d = static_cast<float>(density[(z * size_t(ny) + y) * size_t(nx) + x]);
                    const size_t at = (((z + 1) * wide(ny) + y + 1) * wide(nx) + x + 1) * channels;
                    for (size_t k = 0; k < channels; ++k)
                        (*data)[at + k] = isGray ? d : d * sigma[static_cast<int>(k)];
                }
        const Vec3d p0 = p.vector("p0", Vec3d(0.0)), p1 = p.vector("p1", Vec3d(1.0));
        Vec3d lower, size;
        const int resolution[3] = {nx, ny, nz};
        for (int axis = 0; axis < 3; ++axis) {
            const double begin = std::min(p0[axis], p1[axis]), extent = std::abs(p1[axis] - p0[axis]);
            if (!(extent > 0)) throw p.error("\"p0\" and \"p1\" are no corners of a box");
            const double cell = extent / resolution[axis];
            lower[axis] = begin - cell;
            size[axis] = extent + 2 * cell;
        }
        const Transform box = Transform::fromRows(
            {{size.x, 0, 0, lower.x}, {0, size.y, 0, lower.y}, {0, 0, size.z, lower.z}, {0, 0, 0, 1}});
        const ElementPtr volume =
            Maker("volume", "gridvolume", p.where())
                .with("to_world", mitsuba::settledMap(toWorld * box))
                .with("data", mitsuba::VoxelArray{{nx + 2, ny + 2, nz + 2}, int(channels), *data, data})
                .done();
        return Maker("medium", "heterogeneous", p.where())
            .id(name)
            .with("sigma_t", volume)
            .with("albedo", RgbValue{c.albedo()})
            .with("scale", scale() * (isGray ? double(sigma.x) : 1.0))
            .containing(phase())
            .done();
    }
};

struct MediumType {
    const char* name;
    ElementPtr (*make)(const MediumMaker&, const std::string&);
};
constexpr MediumType kMediumTypes[] = {
    {"homogeneous", [](const MediumMaker& m, const std::string& name) { return m.homogeneous(name); }},
    {"uniformgrid", [](const MediumMaker& m, const std::string& name) { return m.uniformGrid(name); }},
};

}  // namespace

std::vector<std::string> Media::types() {
    std::vector<std::string> names;
    for (const MediumType& type : kMediumTypes) names.emplace_back(type.name);
    return names;
}

void Media::define(const std::string& name, const Parameters& p, const Transform& toWorld,
                   const ColorSpace& space) {
    if (name.empty() || media_.contains(name))
        throw p.error(fmt::format("found the name \"{}\" {}, expected a new one", name,
                                  name.empty() ? "of a medium" : "a second time"));
    const std::string type = p.requiredString("type");
    ElementPtr& medium = media_[name];
    const MediumMaker maker{p, toWorld, space, reading_};
    const auto* const known = std::find_if(std::begin(kMediumTypes), std::end(kMediumTypes),
                                           [&](const MediumType& t) { return type == t.name; });
    if (known == std::end(kMediumTypes)) {
        const std::string nearest = nearestName(type, types());
        reading_.refuse(
            p.error(fmt::format("the medium \"{}\" is not supported{}, expected one of {}", type,
                                nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                                fmt::join(types(), ", "))),
            "it is left out");
        return;
    }
    maker.refuseEmission();
    medium = known->make(maker, name);
    p.checkAllUsed(reading_);
}

ElementPtr Media::find(const std::string& name, const Location& where) const {
    if (name.empty()) return nullptr;
    const auto found = media_.find(name);
    if (found != media_.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& entry : media_) known.push_back(entry.first);
    const std::string nearest = nearestName(name, known);
    throw Error("{}: MediumInterface: found no medium of the name \"{}\"{}", where.str(), name,
                nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest));
}

ElementPtr placedIn(const ElementPtr& element, const ElementPtr& medium) {
    if (!element || !medium) return element;
    auto result = std::make_shared<mitsuba::Element>(*element);
    int last = 0;
    for (const auto& entry : result->named) last = std::max(last, entry.second.order);
    for (const mitsuba::Property& child : result->children) last = std::max(last, child.order);
    result->children.push_back({medium, element->location, false, last + 1});
    return result;
}

}  // namespace metrolux::core::pbrt
