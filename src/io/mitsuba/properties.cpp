#include "io/mitsuba/properties.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace metrolux::core::mitsuba {
namespace {

std::string shortened(const std::string& text) {
    return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

std::string describe(const Property& property) {
    struct Describe {
        std::string operator()(bool v) const { return v ? "the boolean true" : "the boolean false"; }
        std::string operator()(int64_t v) const { return fmt::format("the integer {}", v); }
        std::string operator()(double v) const { return fmt::format("the number {}", v); }
        std::string operator()(const std::string& v) const {
            return fmt::format("the string \"{}\"", shortened(v));
        }
        std::string operator()(const Vec3d& v) const {
            return fmt::format("the vector ({}, {}, {})", v.x, v.y, v.z);
        }
        std::string operator()(const Transform&) const { return "a transform"; }
        std::string operator()(const RgbValue&) const { return "a color"; }
        std::string operator()(const SpectrumValue&) const { return "a spectrum"; }
        std::string operator()(const MeshArrays&) const { return "the arrays of a mesh"; }
        std::string operator()(const PixelArray&) const { return "the pixels of an image"; }
        std::string operator()(const VoxelArray&) const { return "the samples of a volume"; }
        std::string operator()(const ElementPtr& v) const {
            return v ? fmt::format("a <{} type=\"{}\">", v->tag, v->type) : std::string("nothing");
        }
    };
    return std::visit(Describe{}, property.value);
}

std::string suggestion(const std::string& name, const std::vector<std::string>& known) {
    const std::string nearest = nearestName(name, known);
    if (!nearest.empty()) return fmt::format("did you mean \"{}\"?", nearest);
    if (known.empty()) return "no properties are expected here";
    std::string list;
    for (size_t i = 0; i < known.size() && i < 16; ++i) list += (i > 0 ? ", " : "") + known[i];
    return "expected one of: " + list + (known.size() > 16 ? ", ..." : "");
}

template <class T>
const T* typed(const Element& element, const Property* property, const char* expected) {
    if (!property) return nullptr;
    property->used = true;
    const T* value = std::get_if<T>(&property->value);
    if (!value)
        throw element.error(*property, fmt::format("found {}, expected {}", describe(*property), expected));
    return value;
}

}  // namespace

const Property* Element::find(const std::string& name) const {
    if (std::find(known_.begin(), known_.end(), name) == known_.end()) known_.push_back(name);
    for (const auto& [key, property] : named)
        if (key == name) return &property;
    return nullptr;
}

bool Element::boolean(const std::string& name, bool fallback) const {
    const bool* value = typed<bool>(*this, find(name), "a <boolean>");
    return value ? *value : fallback;
}

int64_t Element::integer(const std::string& name, int64_t fallback) const {
    const int64_t* value = typed<int64_t>(*this, find(name), "an <integer>");
    return value ? *value : fallback;
}

float Element::number(const std::string& name, float fallback) const {
    const Property* property = find(name);
    if (!property) return fallback;
    if (const int64_t* whole = std::get_if<int64_t>(&property->value)) {
        property->used = true;
        return static_cast<float>(*whole);
    }
    const double value = *typed<double>(*this, property, "a <float>");
    if (!(std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max())))
        throw error(*property, fmt::format("found {}, expected a finite single-precision number", value));
    return static_cast<float>(value);
}

std::string Element::string(const std::string& name, const std::string& fallback) const {
    const std::string* value = typed<std::string>(*this, find(name), "a <string>");
    return value ? *value : fallback;
}

std::string Element::requiredString(const std::string& name) const {
    const std::string* value = typed<std::string>(*this, find(name), "a <string>");
    if (!value)
        throw error(fmt::format("has no \"{0}\", expected <string name=\"{0}\" value=\"...\"/>", name));
    return *value;
}

Vec3f Element::vector(const std::string& name, const Vec3f& fallback) const {
    return Vec3f(point(name, Vec3d(fallback)));
}

Vec3d Element::point(const std::string& name, const Vec3d& fallback) const {
    const Vec3d* value = typed<Vec3d>(*this, find(name), "a <point> or <vector>");
    return value ? *value : fallback;
}

Transform Element::transform(const std::string& name, bool mayFlatten) const {
    const Property* property = find(name);
    const Transform* value = typed<Transform>(*this, property, "a <transform>");
    if (value && value->isSingular() && !mayFlatten)
        throw error(*property,
                    "the matrix is singular (does something scale by 0?), expected an invertible map");
    return value ? *value : Transform();
}

const MeshArrays& Element::requiredArrays(const std::string& name) const {
    const MeshArrays* value = typed<MeshArrays>(*this, find(name), "the arrays of a mesh");
    if (!value) throw error("has no arrays, which only a program can give it; expected a type with a file");
    return *value;
}

const PixelArray* Element::pixels(const std::string& name) const {
    return typed<PixelArray>(*this, find(name), "the pixels of an image");
}

const VoxelArray* Element::voxels(const std::string& name) const {
    return typed<VoxelArray>(*this, find(name), "the samples of a volume");
}

ElementPtr Element::child(const std::string& name) const {
    const Property* property = find(name);
    if (!property) return nullptr;
    const ElementPtr* element = std::get_if<ElementPtr>(&property->value);
    if (!element) return nullptr;
    property->used = true;
    return *element;
}

std::vector<NamedChild> Element::namedChildrenOf(const std::string& childTag) const {
    std::vector<std::pair<int, NamedChild>> found;
    const auto take = [&](const std::string& name, const Property& property) {
        const ElementPtr* element = std::get_if<ElementPtr>(&property.value);
        if (!element || !*element || (*element)->tag != childTag) return;
        property.used = true;
        found.push_back({property.order, {name, *element}});
    };
    for (const Property& property : children) take("", property);
    for (const auto& [name, property] : named) take(name, property);
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<NamedChild> result;
    result.reserve(found.size());
    for (auto& entry : found) result.push_back(std::move(entry.second));
    return result;
}

std::vector<ElementPtr> Element::childrenOf(const std::string& childTag) const {
    std::vector<ElementPtr> result;
    for (NamedChild& child : namedChildrenOf(childTag)) result.push_back(std::move(child.element));
    return result;
}

void Element::ignore(const std::string& name) const {
    if (const Property* property = find(name)) property->used = true;
}

Error Element::error(const std::string& message) const {
    const std::string typeText = type.empty() ? "" : fmt::format(" type=\"{}\"", shortened(type));
    const std::string idText = id.empty() ? "" : fmt::format(" id=\"{}\"", shortened(id));
    return Error("{}: <{}{}{}>: {}", location.str(), tag, typeText, idText, message);
}

Error Element::error(const Property& property, const std::string& message) const {
    std::string name;
    for (const auto& [key, candidate] : named)
        if (&candidate == &property) name = key;
    const std::string typeText = type.empty() ? "" : fmt::format(" type=\"{}\"", shortened(type));
    const std::string what =
        name.empty() ? describe(property) : fmt::format("property \"{}\"", shortened(name));
    return Error("{}: <{}{}>: {}: {}", property.location.str(), tag, typeText, what, message);
}

void Element::checkAllUsed(bool lenient, std::vector<std::string>& warnings) const {
    const auto report = [&](const Error& problem, bool isWarning) {
        if (!isWarning) throw problem;
        warnings.emplace_back(problem.what());
    };
    for (const auto& [name, property] : named) {
        if (property.used) continue;
        property.used = true;  // said once, also when the element is shared
        const bool isElement = std::holds_alternative<ElementPtr>(property.value);
        report(error(property, fmt::format("{} is not used by this element; {}", describe(property),
                                           suggestion(name, known_))),
               lenient || (isLegacy() && !isElement));
    }
    for (const Property& property : children) {
        if (property.used) continue;
        property.used = true;
        report(error(property, "is not expected inside this element"), lenient);
    }
}

}  // namespace metrolux::core::mitsuba
