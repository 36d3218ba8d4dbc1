#include "api/converter.h"

#include "api/internals.h"
#include "base/suggest.h"
#include "image/filter.h"
#include "integrators/registry.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/spectrum_plugins.h"
#include "io/mitsuba/values.h"

#include <set>

namespace metrolux::core::api {
namespace {

using namespace mitsuba;

/// The tag of a scene file that each type of object has.
std::map<std::string, std::string> makeTags() {
    std::map<std::string, std::string> tags;
    const auto add = [&tags](const char* tag, const std::vector<std::string>& types) {
        for (const std::string& type : types) tags.emplace(type, tag);
    };
    add("spectrum", spectrumPluginNames());  // which textures may be too: as values they need no element
    add("bsdf", bsdfTypes());
    add("texture", textureTypes());
    add("emitter", emitterTypes());
    add("sensor", sensorTypes());
    add("film", filmTypes());
    add("shape", shapeTypes());
    add("medium", mediumTypes());
    add("phase", phaseTypes());
    add("volume", volumeTypes());
    for (const auto& [name, kind] : filterNames()) tags.emplace(name, "rfilter");
    for (const IntegratorDescription& integrator : integratorList()) {
        add("integrator", {integrator.name});
        add("integrator", integrator.mitsubaTypes);
    }
    add("sampler", {"independent", "stratified", "multijitter", "orthogonal", "ldsampler"});
    return tags;
}

const std::map<std::string, std::string>& tags() {
    static const std::map<std::string, std::string> instance = makeTags();
    return instance;
}

const std::set<std::string> kTags = {"integrator", "sensor", "film",    "rfilter", "sampler", "emitter",
                                     "shape",      "bsdf",   "texture", "medium",  "phase",   "volume"};

double finite(double value) {
    if (!std::isfinite(value)) throw Error("found {}, expected a finite number", value);
    return value;
}

float single(double value) {
    const auto result = static_cast<float>(finite(value));
    if (!std::isfinite(result)) throw Error("found {}, expected a single-precision number", value);
    return result;
}

std::vector<float> singles(const std::vector<double>& values) {
    std::vector<float> result;
    for (const double value : values) result.push_back(single(value));
    return result;
}

SpectrumValue spectrumValue(const Spectrum& s) {
    SpectrumValue result;
    result.wavelengths = singles(s.wavelengths);
    result.values = singles(s.values);
    if (!s.wavelengths.empty() || s.values.size() != 1) checkSpectrum(result);
    return result;
}

SpectrumValue blackbodyValue(const Blackbody& b) {
    if (!(b.kelvin > 0)) throw Error("found the temperature {}, expected positive kelvins", b.kelvin);
    SpectrumValue result;
    result.blackbodyKelvin = single(b.kelvin);
    result.values = {single(b.scale)};
    return result;
}

MeshArrays arraysOf(const std::shared_ptr<const Mesh>& mesh) {
    MeshArrays arrays{mesh->positions, mesh->normals, mesh->uvs, mesh->triangles, {}, mesh, true};
    for (const Mesh::Attribute& a : mesh->attributes)
        arrays.attributes.push_back({a.name, a.channels, a.values});
    return arrays;
}

using Data = decltype(Property::value);
Data plain(bool v) { return v; }
Data plain(std::int64_t v) { return v; }
Data plain(double v) { return finite(v); }
Data plain(const std::string& v) { return v; }
Data plain(const Vector& v) {
    for (const double x : {v.x, v.y, v.z}) single(x);  // within its range
    return settled({v.x, v.y, v.z});
}
Data plain(const Color& c) { return RgbValue{{single(c.r), single(c.g), single(c.b)}}; }
Data plain(const Spectrum& s) { return spectrumValue(s); }
Data plain(const Blackbody& b) { return blackbodyValue(b); }
Data plain(const metrolux::Transform& t) { return Internals::transform(t); }
Data plain(const std::shared_ptr<const Mesh>& mesh) {
    if (!mesh) throw Error("found no mesh, expected one");
    return arraysOf(mesh);
}
Data plain(const std::shared_ptr<const Image>& image) {
    if (!image) throw Error("found no image, expected one");
    return PixelArray{image->width, image->height, image->channels, image->pixels, image, true};
}

bool isList(const Element& parent) { return parent.tag == "scene" || parent.type == "shapegroup"; }

/// With its place in front, unless it has one.
Error located(const Location& location, const Error& problem) {
    const std::string message = problem.what();
    return message.starts_with(location.file + ":") ? problem : Error("{}: {}", location.str(), message);
}

std::string tagOf(const std::string& type, const std::string& name) {
    if (const auto found = tags().find(type); found != tags().end()) return found->second;
    if (kTags.contains(name)) return name;  // what the type should have been, its own factory says
    std::vector<std::string> known;
    for (const auto& entry : tags()) known.push_back(entry.first);
    const std::string nearest = nearestName(type, known);
    throw Error("unknown type \"{}\"{}", type,
                nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest));
}

std::string text(const Object& object, const char* name) {
    const Value* value = object.find(name);
    const std::string* text = value ? std::get_if<std::string>(&value->data()) : nullptr;
    if (!text) throw Error("a \"{}\" has no string \"{}\", expected one", object.type(), name);
    return *text;
}

/// The only value of an object that has no other.
const Value::Data& valueOf(const Object& object) {
    const Value* value = object.find("value");
    if (!value || object.values().size() != 1)
        throw Error("a \"{}\" has to have a \"value\" and nothing else", object.type());
    return value->data();
}

std::optional<double> numberOf(const Value::Data& data) {
    if (const auto* real = std::get_if<double>(&data)) return *real;
    if (const auto* whole = std::get_if<std::int64_t>(&data)) return static_cast<double>(*whole);
    return std::nullopt;
}

RgbValue colorOf(const Object& object) {
    const Value::Data& data = valueOf(object);
    if (const auto* c = std::get_if<Color>(&data)) return {{single(c->r), single(c->g), single(c->b)}};
    if (const auto* v = std::get_if<Vector>(&data)) return {{single(v->x), single(v->y), single(v->z)}};
    if (const auto gray = numberOf(data)) return {Rgb(single(*gray))};
    throw Error("the \"value\" of an \"rgb\" is neither three numbers nor one");
}

SpectrumValue spectrumOf(const Object& object) {
    const Value::Data& data = valueOf(object);
    if (const auto* s = std::get_if<Spectrum>(&data)) return spectrumValue(*s);
    if (const auto value = numberOf(data)) return spectrumValue(Spectrum{{}, {*value}});
    throw Error("the \"value\" of a \"spectrum\" is neither a spectrum nor a number");
}

}  // namespace

std::shared_ptr<Element> Converter::convert(const Object& object, const std::string& tag,
                                            const std::string& path, const std::string& ownId, int depth) {
    auto element = std::make_shared<Element>();
    fill(element, object, tag, path, ownId, depth);
    return element;
}

bool Converter::isElement(const Object& object) {
    const std::string& type = object.type();
    const auto tag = tags().find(type);
    return type != "ref" && type != "rgb" && type != "spectrum" &&
           !(tag != tags().end() && tag->second == "spectrum");
}

void Converter::replace(const std::shared_ptr<Element>& element, const Object& object,
                        const std::string& name, const std::string& path) {
    const std::string id = element->id;
    try {
        const std::string tag = tagOf(object.type(), name);
        *element = Element();
        fill(element, object, tag, path, id, 0);
    } catch (const Error& problem) {
        throw located(locationOf(path), problem);
    }
}

void Converter::fill(const std::shared_ptr<Element>& element, const Object& object, const std::string& tag,
                     const std::string& path, const std::string& ownId, int depth) {
    element->tag = tag;
    element->type = tag == "scene" ? "" : object.type();
    element->location = {file_, 0, path};
    element->id = ownId;
    if (const Value* id = object.find("id")) {
        const std::string* text = std::get_if<std::string>(&id->data());
        if (!text) throw element->error("found an \"id\" that is no string, expected one");
        element->id = *text;
    }
    if (depth > kMaxDepth)
        throw element->error(fmt::format("objects are nested more than {} levels deep", kMaxDepth));
    std::set<std::string> names;
    for (const auto& [name, value] : object.values()) {
        if (name == "id") continue;
        if (name.empty() || !names.insert(name).second)
            throw element->error(fmt::format("found the name \"{}\" twice or empty, expected it once", name));
        add(*element, name, value, depth);
    }
    if (tag == "spectrum") return;
    references_.addElement(element);
    made_.insert(element.get());
}

void Converter::add(Element& parent, const std::string& name, const Value& value, int depth) {
    const std::string& above = parent.location.path;
    Property property{{}, locationOf(above.empty() ? name : above + "." + name), false, nextOrder_++};
    assign(parent, name, isList(parent), value, property, depth);
    if (isList(parent) && std::holds_alternative<ElementPtr>(property.value))
        parent.children.push_back(std::move(property));
    else
        parent.named.emplace_back(name, std::move(property));
}

void Converter::assign(Element& parent, const std::string& name, bool isChild, const Value& value,
                       Property& property, int depth) {
    const Place place{parent, name, property, isChild, depth};
    try {
        property.value = std::visit(
            [&](const auto& v) -> Data {
                if constexpr (requires { of(v, place); })
                    return of(v, place);
                else
                    return plain(v);
            },
            value.data());
    } catch (const Error& problem) {
        throw located(property.location, problem);
    }
}

Converter::Data Converter::of(const Reference& reference, const Place& at) {
    references_.addReference(at.parent, at.property.order, at.isChild ? "" : at.name, reference.id,
                             at.property.location);
    return ElementPtr();
}

Converter::Data Converter::of(const std::shared_ptr<const Object>& object, const Place& at) {
    if (!object) throw Error("found no object, expected one");
    const std::string& type = object->type();
    if (type == "ref") return of(Reference{text(*object, "id")}, at);
    if (type == "rgb") return colorOf(*object);
    if (type == "spectrum") return spectrumOf(*object);
    const std::string tag = tagOf(type, at.name);
    auto element = convert(*object, tag, at.property.location.path, at.parent.tag == "scene" ? at.name : "",
                           at.depth + 1);
    if (tag == "spectrum") return spectrumFromPlugin(*element);
    return ElementPtr(std::move(element));
}

}  // namespace metrolux::core::api
